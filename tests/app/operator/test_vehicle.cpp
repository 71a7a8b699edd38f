// SPDX-License-Identifier: MIT
// States of a vehicle: modes, arming, sticks, refusals, and the texts about them.
#include <array>

#include "app/operator/ship.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("a disarm leaves every state, and an operator's heartbeat shows it at once") {
  for (const State from : kEveryState) {
    Ship s;
    s.bring_to(from);
    s.command(mav::kCmdComponentArmDisarm, 0, from == State::kHold ? 21196.0F : 0.0F);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
    CHECK(s.result() == mav::kAccepted);
    if (from == State::kDisarmed) continue;
    for (const std::size_t link : {0U, 1U}) {
      REQUIRE(s.all<link::Heartbeat>(link).size() == 1);
      CHECK(s.all<link::Heartbeat>(link)[0].base_mode == 1);
      CHECK(s.all<link::Heartbeat>(link)[0].system_status == 3);
      CHECK(s.says("DISARMED", link));
    }
  }
}

TEST_CASE("every state has its heartbeat") {
  const std::array<std::array<unsigned, 3>, core::kStates> kExpected{{{1, 4, 3},
                                                                      {129, 4, 4},
                                                                      {193, 0, 4},
                                                                      {141, 6, 4},
                                                                      {141, 6, 5},
                                                                      {131, 4, 4},
                                                                      {1, 4, 6},
                                                                      {141, 10, 4},
                                                                      {141, 15, 4},
                                                                      {141, 5, 4},
                                                                      {141, 11, 4}}};
  for (const State state : kEveryState) {
    Ship s;
    s.bring_to(state);
    s.command(mav::kCmdRequestMessage, link::Heartbeat::kId);
    s.tick();
    REQUIRE(s.all<link::Heartbeat>().size() >= 1);
    const auto beat_now = s.all<link::Heartbeat>()[0];
    const auto& [base, mode, status] = kExpected[static_cast<std::size_t>(state)];
    CAPTURE(static_cast<int>(state));
    CHECK(beat_now.base_mode == base);
    CHECK(beat_now.custom_mode == mode);
    CHECK(beat_now.system_status == status);
    CHECK(beat_now.type == 11);
    CHECK(beat_now.autopilot == 0);
  }
}

TEST_CASE("termination leads to FAULT from every state, and only a disarm leads out of it") {
  for (const State from : kEveryState) {
    Ship s;
    s.bring_to(from);
    s.command(mav::kCmdDoFlightTermination, 1);
    s.tick();
    CHECK(s.state() == State::kFault);
    CHECK(s.result() == mav::kAccepted);
    if (from != State::kFault) {
      CHECK(s.says("terminated"));
      CHECK(s.all<link::Statustext>()[0].severity == mav::kSeverityCritical);
    }
    s.sticks(0, 0);
    for (const float mode : {0.0F, 4.0F, 6.0F}) s.command(mav::kCmdDoSetMode, 1, mode);
    s.command(mav::kCmdComponentArmDisarm, 1, 21196);
    s.command(mav::kCmdDoFlightTermination, 0);
    s.test_port();
    s.tick();
    const auto acks = s.all<link::CommandAck>();
    CHECK(acks.size() == 6);
    for (const auto& ack : acks) CHECK(ack.result != mav::kAccepted);
    CHECK(s.state() == State::kFault);
    s.pass(30);
    CHECK(s.state() == State::kFault);
    s.command(mav::kCmdComponentArmDisarm, 0);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
  }
}

TEST_CASE("the host's disarm acts after all other requests of that tick") {
  for (const State from : kEveryState) {
    Ship s;
    s.bring_to(from);
    s.vehicle->disarm();
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.command(mav::kCmdDoSetMode, 1, 6);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
    if (from == State::kFault) continue;
    s.command(mav::kCmdComponentArmDisarm, 1);  // the condition held for one tick only
    s.tick();
    CHECK(s.state() == State::kHold);
  }
}

TEST_CASE("sticks are valid for half a second, only if complete, only from the commander") {
  Parameters p;
  p.MAV_GCS_SYSID = 255;
  Ship s(p);
  const auto fresh = [&](std::int64_t after_us) {
    return (s.conditions(s.now_us + after_us) & core::kSticksFresh) != 0;
  };
  CHECK_FALSE(fresh(0));
  s.hear(s.stranger, link::ManualControl{500, 0, 0, 0, 0, 1});
  s.hear(s.stranger, link::ManualControl{500, 0, 0, 0, 0, 0});
  CHECK_FALSE(fresh(0));
  s.sticks(-250, 750);
  CHECK(fresh(499'999));
  CHECK_FALSE(fresh(500'000));
  CHECK(s.supervisor.sticks().surge == doctest::Approx(-0.25));
  CHECK(s.supervisor.sticks().yaw == doctest::Approx(0.75));
  s.now_us += 400'000;
  s.sticks(32767, 0);
  s.sticks(0, -1001);
  CHECK(s.counters.mavlink_bad_value == 2);
  CHECK(s.supervisor.sticks().surge == doctest::Approx(-0.25));
  CHECK_FALSE(fresh(100'000));
  s.ask(link::ManualControl{100, INT16_MAX, INT16_MAX, 100, UINT16_MAX, 0});  // for a fleet
  CHECK(s.supervisor.sticks().surge == doctest::Approx(-0.25));
  CHECK_FALSE(fresh(100'000));
  s.ask(link::ManualControl{100, INT16_MAX, INT16_MAX, 100, UINT16_MAX, 1});
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.1));
  s.ask(link::ManualControl{900, 0, 0, 0, 0, 2});  // for another boat
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.1));
}

TEST_CASE("the operator who holds the sticks keeps them until half a second after release") {
  Ship s;
  link::MavlinkEncoder mate{{255, 191}};
  s.sticks(100, 0);
  for (int k = 0; k < 100; ++k) {
    s.now_us += 490'000;
    s.hear(s.stranger, link::ManualControl{900, 0, 0, 0, 0, 1});
    s.hear(mate, link::ManualControl{-900, 0, 0, 0, 0, 1}, 1);
    REQUIRE(s.supervisor.sticks().surge == doctest::Approx(0.1));
    s.sticks(100, 0);
  }
  s.now_us += 499'999;
  s.hear(s.stranger, link::ManualControl{900, 0, 0, 0, 0, 1});
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.1));
  s.now_us += 1;
  s.hear(s.stranger, link::ManualControl{900, 0, 0, 0, 0, 1});
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.9));
  s.sticks(100, 0);
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.9));
}

TEST_CASE("a driving companion obeys HOLD to the whole system, one at rest does not answer") {
  Parameters p;
  p.MAV_IDENTITY = 1;
  p.MAV_COMPID = 191;
  Ship s(p);
  s.tick();
  s.command(mav::kCmdDoSetMode, 1, 4, {1, 0});
  s.tick();
  CHECK(s.all<link::CommandAck>().empty());  // the autopilot's answer is the one that counts
  CHECK(s.all<link::Statustext>().empty());
  s.command(mav::kCmdComponentArmDisarm, 1, 0, {1, 191});
  s.command(mav::kCmdDoSetMode, 1, 6, {1, 191});
  s.tick();
  REQUIRE(s.state() == State::kFormation);
  s.command(mav::kCmdDoSetMode, 1, 4, {1, 0});
  s.tick();
  CHECK(s.state() == State::kHold);
}

TEST_CASE("a companion has no sticks: they are the autopilot's") {
  Parameters p;
  p.MAV_IDENTITY = 1;
  p.MAV_COMPID = 191;
  Ship s(p);
  s.sticks(500, 0);
  CHECK((s.conditions(s.now_us) & core::kSticksFresh) == 0);
}

TEST_CASE("silent sticks end MANUAL in HOLD") {
  Ship s;
  s.bring_to(State::kManual);
  s.pass(0.48);
  CHECK(s.state() == State::kManual);
  s.pass(0.03);
  CHECK(s.state() == State::kHold);
  s.sticks(0, 0);
  s.pass(0.1);
  CHECK(s.state() == State::kHold);
}

TEST_CASE(
    "a motor test begins in HOLD only, ends by itself, and repeating it does not lengthen it") {
  for (const State from : kEveryState) {
    if (from == State::kTest) continue;
    Ship s;
    s.bring_to(from);
    s.test_port();
    s.tick();
    CHECK((s.result() == mav::kAccepted) == (from == State::kHold));
    CHECK((s.state() == State::kTest) == (from == State::kHold));
    CHECK(s.supervisor.motor_test().has_value() == (from == State::kHold));
  }
  Ship s;
  s.bring_to(State::kHold);
  s.test_port(5, 2);
  int ticks = 0;
  for (s.tick(); s.state() == State::kTest; s.tick()) {
    if (++ticks % 20 == 0) s.test_port(5, 2, static_cast<std::uint8_t>(ticks / 20));
    REQUIRE(ticks < 1000);
  }
  CHECK(ticks == 200);
  CHECK(s.state() == State::kHold);
}

TEST_CASE("a refusal is reported once for each failing check, at most twice a second") {
  Ship s;
  s.world = kFair & ~(core::kSoleVessel | core::kEscsOnline | core::kParametersSaved |
                      core::kSoleController);
  s.tick();
  int said = 0;
  for (int k = 0; k < 200; ++k) {
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.tick();
    CHECK(s.result() == mav::kTemporarilyRejected);
    const auto texts = s.all<link::Statustext>();
    if (texts.empty()) continue;
    ++said;
    CHECK(texts.size() == 4);
    CHECK(s.says("PreArm: another sender"));
    CHECK(s.says("PreArm: an ESC"));
    CHECK(s.says("PreArm: parameters"));
    CHECK(s.says("PreArm: another controller"));
    for (const auto& t : texts) CHECK(t.severity == mav::kSeverityWarning);
  }
  CHECK(said == 4);
  CHECK(s.state() == State::kDisarmed);
}

TEST_CASE("a boat is armed even if FORMATION is not possible, and reports that once") {
  constexpr core::Conditions kMayLack =
      core::kOwn | core::kOwnTimed | core::kOwnPrompt | core::kLimits | core::kFollows;
  for (unsigned bit = 0; bit < core::kConditionCount; ++bit) {
    if ((kMayLack >> bit & 1U) == 0) continue;
    Ship s;
    s.world = kFair & ~(core::Conditions{1} << bit);
    s.tick();
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.tick();
    CHECK(s.result() == mav::kAccepted);
    const std::string why(complaint_of(core::Conditions{1} << bit));
    CHECK(s.says("HOLD"));
    CHECK(s.says("armed, no FORMATION: " + why.substr(0, 20)));
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.tick();
    CHECK(s.all<link::Statustext>().empty());
    s.command(mav::kCmdDoSetMode, 1, 6);
    s.tick();
    CHECK(s.result() == mav::kTemporarilyRejected);
    CHECK(s.says("Refused: " + why));
    CHECK(s.state() == State::kHold);
  }
}

TEST_CASE("an armed boat whose sticks are off neutral reports it once as MANUAL begins") {
  for (const std::int16_t surge : {std::int16_t{0}, std::int16_t{1000}}) {
    Ship s;
    s.bring_to(State::kHold);
    s.sticks(surge, 0);
    s.command(mav::kCmdDoSetMode, 1, 0);
    s.tick();
    CHECK(s.state() == State::kManual);
    CHECK(s.says("MANUAL: centre the sticks first") == (surge != 0));
    s.sticks(surge, 0);
    s.tick();
    CHECK(s.all<link::Statustext>().empty());
  }
}

TEST_CASE("a refusal with every possible reason leaves room for the heartbeat") {
  Ship s;
  s.world = 0;
  s.links.signing().start({1, 2, 3}, 1, 0);
  s.links.set_policy(0, SigningPolicy::kAccept);
  for (std::uint32_t k = 0; k < 23; ++k) s.ask(link::Ping{k, k, {}});
  s.command(mav::kCmdComponentArmDisarm, 1);
  s.tick();
  CHECK(s.all<link::Statustext>().size() > 0);
  CHECK(s.all<link::Heartbeat>().size() == 1);
  CHECK(s.counters.mavlink_not_sent == 0);
}

}  // namespace
}  // namespace flotilla::app
