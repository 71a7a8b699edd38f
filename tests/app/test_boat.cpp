// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include "app/boat/boat.hpp"
#include "app/harbour.hpp"

namespace flotilla::app {
namespace {

using core::State;
namespace mav = link::mav;

template <class S>
using Harbour = testing::Harbour<S>;

TEST_CASE_TEMPLATE("a boat that is armed and in FORMATION pushes towards its slot", S, float,
                   double) {
  Harbour<S> h;
  h.cast_off();
  CHECK(h.boat.state() == State::kFormation);
  constexpr core::Conditions kIdle =
      core::kSticksFresh | core::kSticksCentred | core::kTestRunning | core::kPlanReady;
  CHECK((h.boat.snapshot().conditions & core::kAllConditions) == (core::kAllConditions & ~kIdle));
  CHECK(h.pushes());
  CHECK(h.raw.cmd[0] > 0);  // the slot is ahead
  CHECK(h.arming == 255);
  CHECK(h.boat.snapshot().error.x == doctest::Approx(-0.5).epsilon(0.1));
}

TEST_CASE_TEMPLATE("disarmed, every tick sends exactly zeros to both propellers and ArmingStatus 0",
                   S, float, double) {
  Harbour<S> h;
  const auto check_still = [&] {
    for (int k = 0; k < 100; ++k) {
      h.step();
      REQUIRE(h.stopped());
      REQUIRE(h.arming == 0);
    }
  };
  check_still();
  h.mode(6);
  check_still();
  h.cast_off();
  REQUIRE(h.pushes());
  h.disarm();
  check_still();
  CHECK(h.boat.state() == State::kDisarmed);
}

/// Steps until `limit_s` after the last message; that the boat pushes before and is stopped after.
template <class S>
void check_stops_at(Harbour<S>& h, std::int64_t last_us, double limit_s) {
  const auto limit_us = static_cast<std::int64_t>(limit_s * 1e6);
  while (h.now_us + Harbour<S>::kTick_us < last_us + limit_us) {
    h.step();
    REQUIRE(h.pushes());
  }
  for (int k = 0; k < 300; ++k) {
    h.step();
    REQUIRE(h.stopped());
  }
}

TEST_CASE_TEMPLATE("own state silent: both propellers stop within a tick of the timeout, HOLD", S,
                   float, double) {
  Harbour<S> h;
  h.cast_off();
  h.navigation_talks = false;
  check_stops_at(h, h.now_us, 0.5);
  CHECK(h.boat.state() == State::kHold);
  CHECK(h.arming == 255);
  h.navigation_talks = true;
  h.sail(2);
  CHECK(h.stopped());  // back to FORMATION by the operator only
  h.mode(6);
  h.sail(1);
  CHECK(h.pushes());
}

TEST_CASE_TEMPLATE("leader silent, HOLD chosen: both propellers stop within a tick of the timeout",
                   S, float, double) {
  Parameters p;
  p.FS_LEADER_ACT = 0;
  Harbour<S> h(p);
  h.cast_off();
  h.leader_talks = false;
  check_stops_at(h, h.now_us, 1.0);
  CHECK(h.boat.state() == State::kHold);
  CHECK(h.arming == 255);
}

TEST_CASE_TEMPLATE("leader silent: the boat coasts from the timeout on, then both propellers stop",
                   S, float, double) {
  Harbour<S> h;
  h.cast_off();
  h.leader_talks = false;
  const std::int64_t last_us = h.now_us;
  while (h.boat.state() == State::kFormation) h.step();
  CHECK(h.now_us == last_us + 1'000'000);
  CHECK(h.boat.state() == State::kCoast);
  CHECK(h.says("COAST: leader lost or origin unknown"));
  const auto greatest = [&h] { return std::max(std::abs(h.raw.cmd[0]), std::abs(h.raw.cmd[1])); };
  while (h.boat.state() == State::kCoast) {
    REQUIRE(h.arming == 255);
    const int before = greatest();
    h.step();
    REQUIRE(greatest() <= before);
  }
  CHECK(h.now_us == last_us + 6'000'000);
  CHECK(h.boat.state() == State::kHold);
  CHECK(h.says("HOLD: FS_COAST_S elapsed, or position lost"));
  CHECK(h.stopped());
  h.leader_talks = true;
  h.sail(2);
  CHECK(h.boat.state() == State::kHold);  // from there only an operator can restart it
}

TEST_CASE_TEMPLATE("a leader heard again during COAST is followed again automatically", S, float,
                   double) {
  Harbour<S> h;
  h.cast_off();
  h.leader_talks = false;
  h.sail(3);
  REQUIRE(h.boat.state() == State::kCoast);
  REQUIRE(h.pushes());
  h.leader_talks = true;
  h.step();
  CHECK(h.boat.state() == State::kFormation);
  CHECK(h.says("FORMATION"));
  CHECK(h.pushes());
}

TEST_CASE_TEMPLATE("in COAST the operator's requests prevail", S, float, double) {
  for (const float mode : {0.0F, 4.0F, 6.0F}) {
    Harbour<S> h;
    h.cast_off();
    h.leader_talks = false;
    h.sail(2);
    REQUIRE(h.boat.state() == State::kCoast);
    if (mode == 0) h.tell(h.operator_, link::ManualControl{0, 0, 0, 0, 0, 1});
    h.mode(mode);
    h.step();
    CHECK(h.boat.state() == (mode == 0   ? State::kManual
                             : mode == 4 ? State::kHold
                                         : State::kCoast));
    h.disarm();
    h.step();
    CHECK(h.boat.state() == State::kDisarmed);
    CHECK(h.stopped());
  }
}

TEST_CASE_TEMPLATE("an ESC silent: both propellers stop, ArmingStatus 0, FAULT until disarmed", S,
                   float, double) {
  for (const bool port : {true, false}) {
    Harbour<S> h;
    h.cast_off();
    while (h.now_us % 100'000 >= Harbour<S>::kTick_us) h.step();
    (port ? h.port_talks : h.stbd_talks) = false;
    check_stops_at(h, h.now_us, 1.2);
    CHECK(h.boat.state() == State::kFault);
    CHECK(h.arming == 0);
    h.port_talks = h.stbd_talks = true;
    h.sail(2);
    h.arm();
    h.mode(6);
    h.sail(1);
    CHECK(h.boat.state() == State::kFault);
    CHECK(h.stopped());
    h.disarm();
    h.step();
    CHECK(h.boat.state() == State::kDisarmed);
    h.cast_off();
    CHECK(h.pushes());
  }
}

TEST_CASE_TEMPLATE(
    "time that stands still causes neither NaN nor jump; time that goes back is counted", S, float,
    double) {
  Harbour<S> h;
  h.cast_off();
  h.sail(1);
  const auto raw = h.raw.cmd;
  for (int k = 0; k < 25; ++k) {  // in all less than FS_NAV_S: then nothing is to be trusted
    h.tick();
    REQUIRE(h.pushes());
    REQUIRE(std::abs(h.raw.cmd[0] - raw[0]) <= 1);
  }
  const std::int64_t now_us = h.now_us;
  h.now_us -= 400'000;
  for (int k = 0; k < 20; ++k) {
    h.step();
    REQUIRE(std::isfinite(h.boat.snapshot().asked.X + h.boat.snapshot().asked.N));
    REQUIRE(std::abs(h.raw.cmd[0] - raw[0]) < 400);
  }
  CHECK(h.boat.snapshot().counters.clock_went_back > 0);
  h.now_us = now_us;
  h.sail(1);
  CHECK(h.boat.state() == State::kFormation);
  CHECK(h.pushes());
}

TEST_CASE_TEMPLATE("every command is answered once, on the link it came by, granted or not", S,
                   float, double) {
  Harbour<S> h(Parameters{}, 2);
  h.sail(2);
  const auto answer_to = [&](std::uint16_t number, float first, float second) {
    h.command(number, first, second, 1);
    h.step();
    CHECK(h.template all<link::CommandAck>(0).empty());
    const auto acks = h.template all<link::CommandAck>(1);
    REQUIRE(acks.size() == 1);
    CHECK(acks[0].command == number);
    CHECK(acks[0].target.system == 255);
    CHECK(acks[0].target.component == 190);
    h.sail(0.5);
    CHECK(h.template all<link::CommandAck>(1).empty());
    return acks[0].result;
  };
  CHECK(answer_to(mav::kCmdDoSetMode, 1, 6) == mav::kTemporarilyRejected);
  CHECK(answer_to(mav::kCmdComponentArmDisarm, 1, 0) == mav::kAccepted);
  CHECK(answer_to(mav::kCmdComponentArmDisarm, 1, 0) == mav::kAccepted);
  CHECK(answer_to(mav::kCmdDoSetMode, 1, 6) == mav::kAccepted);
  CHECK(answer_to(mav::kCmdDoSetMode, 1, 77) == mav::kDenied);
  CHECK(answer_to(9999, 0, 0) == mav::kUnsupported);
  CHECK(answer_to(mav::kCmdComponentArmDisarm, 0, 0) == mav::kAccepted);
  h.tell(h.operator_,
         link::CommandLong{mav::kCmdComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0}, 9, 1, 0});
  h.step();
  CHECK(h.template all<link::CommandAck>().empty());  // it was for another boat
  CHECK(h.boat.state() == State::kDisarmed);
}

TEST_CASE_TEMPLATE(
    "a command behind a truncated message is obeyed, with its datagram or 0.3 s later", S, float,
    double) {
  const bool datagrams = std::is_same_v<S, float>;
  for (const std::size_t cut : {1U, 5U, 10U, 20U}) {
    Harbour<S> h(Parameters{}, 2);
    h.sail(2);
    testing::Bytes bytes = testing::frame_of(h.leader, Harbour<S>::state(1, 1, 1));
    bytes.resize(cut);
    const testing::Bytes command = testing::frame_of(
        h.operator_,
        link::CommandLong{mav::kCmdComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0}, {1, 1}, 0});
    bytes.insert(bytes.end(), command.begin(), command.end());
    h.boat.on_mavlink(bytes, h.now_us, 1);
    if (datagrams) h.boat.end_of_datagram(h.now_us, 1);
    h.step();
    CAPTURE(cut);
    if (datagrams) CHECK(h.boat.state() == State::kHold);
    h.sail(0.32);
    CHECK(h.boat.state() == State::kHold);
    h.disarm();
    h.step();
    CHECK(h.boat.state() == State::kDisarmed);
  }
}

TEST_CASE_TEMPLATE("a message may arrive in pieces over several ticks", S, float, double) {
  Harbour<S> h(Parameters{}, 2);
  h.sail(2);
  const testing::Bytes command = testing::frame_of(
      h.operator_,
      link::CommandLong{mav::kCmdComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0}, {1, 1}, 0});
  for (std::size_t i = 0; i < command.size(); ++i) {  // in less than 0.3 s
    h.boat.on_mavlink(std::span(command).subspan(i, 1), h.now_us, 1);
    if (i % 2 == 0) h.step();
  }
  h.step();
  CHECK(h.boat.state() == State::kHold);
}

/// A message that our dialect lacks.
testing::Bytes foreign_frame() {
  testing::Bytes out(37, 0x11);
  const std::array<std::uint8_t, 10> header{0xFD, 25, 0, 0, 0, 9, 1, 0x10, 0x27, 0};
  std::copy(header.begin(), header.end(), out.begin());
  return out;
}

TEST_CASE_TEMPLATE("on a serial line busy with another dialect no command is lost", S, float,
                   double) {
  for (int before = 10; before < 80; ++before) {
    Harbour<S> h(Parameters{}, 2);
    h.sail(2);
    testing::Bytes stream;
    const auto add = [&](const testing::Bytes& frame) {
      stream.insert(stream.end(), frame.begin(), frame.end());
    };
    for (int k = 0; k < before; ++k) add(foreign_frame());
    add(testing::frame_of(
        h.operator_,
        link::CommandLong{mav::kCmdComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0}, {1, 1}, 0}));
    for (int k = 0; k < 10; ++k) add(foreign_frame());
    for (std::size_t at = 0; at < stream.size(); at += 36) {  // the bytes of one tick
      h.boat.on_mavlink(
          std::span(stream).subspan(at, std::min<std::size_t>(36, stream.size() - at)), h.now_us,
          1);
      h.step();
    }
    CAPTURE(before);
    CHECK(h.boat.state() == State::kHold);
  }
}

TEST_CASE_TEMPLATE(
    "told to change its leader and to enter FORMATION in one tick, a boat stays in HOLD", S, float,
    double) {
  Harbour<S> h;
  h.sail(2);
  h.arm();
  h.step();
  link::ParamSet leader{55, {1, 1}, {}, mav::kParamReal32};
  std::strncpy(leader.param_id.data(), "FORM_LEADER", leader.param_id.size());
  h.tell(h.operator_, leader);
  h.mode(6);
  h.step();
  CHECK(h.boat.state() == State::kHold);
  CHECK(h.template all<link::CommandAck>().at(0).result == mav::kTemporarilyRejected);
  leader.param_value = 100;
  h.tell(h.operator_, leader);
  h.sail(2);
  h.mode(6);
  h.step();
  CHECK(h.boat.state() == State::kFormation);
}

TEST_CASE_TEMPLATE(
    "the force number does not arm a boat that fails a check, and the operator gets the reason", S,
    float, double) {
  Harbour<S> h;
  h.stbd_talks = false;
  h.sail(2);
  h.arm(21196);
  h.step();
  CHECK(h.boat.state() == State::kDisarmed);
  CHECK(h.says("PreArm: an ESC"));
  CHECK(h.arming == 0);
}

TEST_CASE_TEMPLATE("no foreign system id ever moves the own track or the leader's", S, float,
                   double) {
  Harbour<S> h, alone;
  for (int k = 0; k < 300; ++k) {
    for (const std::uint8_t system : std::initializer_list<std::uint8_t>{0, 2, 50, 99, 101, 255}) {
      link::MavlinkEncoder foreign({system, 1});
      h.tell(foreign, Harbour<S>::state(h.now_us + k, 777, 9));
      h.tell(foreign, link::GpsGlobalOrigin{1, 1, 0, 0});
    }
    link::MavlinkEncoder echo({1, 1});  // our own message, received on another link
    h.tell(echo, Harbour<S>::state(h.now_us + k, 777, 9));
    h.step();
    alone.step();
    CHECK(h.boat.snapshot().error.x == alone.boat.snapshot().error.x);
    CHECK(h.boat.snapshot().own_age_s == alone.boat.snapshot().own_age_s);
    CHECK(h.boat.snapshot().leader_age_s == alone.boat.snapshot().leader_age_s);
  }
}

TEST_CASE_TEMPLATE("without both origins no leader is followed", S, float, double) {
  Harbour<S> h;
  for (int k = 0; k < 90; ++k) {
    h.now_us += Harbour<S>::kTick_us;
    h.tell(h.navigation, Harbour<S>::state(h.now_us, 0, 0));
    h.tell(h.leader, Harbour<S>::state(h.now_us + h.leader_clock_us, 3, 0));
    h.tick();
    CHECK((h.boat.snapshot().conditions & core::kLeaderFresh) == 0);
  }
  h.sail(2);
  CHECK((h.boat.snapshot().conditions & core::kLeaderFresh) != 0);
}

TEST_CASE_TEMPLATE("every link gets a heartbeat a second with state and mode, and a change at once",
                   S, float, double) {
  Harbour<S> h(Parameters{}, 3);
  std::size_t beats = 0;
  for (int k = 0; k < 1000; ++k) {
    h.step();
    for (std::size_t link = 0; link < 3; ++link) {
      for (const auto& beat : h.template all<link::Heartbeat>(link)) {
        ++beats;
        CHECK(beat.type == mav::kTypeSurfaceBoat);
        CHECK(beat.custom_mode == 4);
        CHECK((beat.base_mode & mav::kModeFlagArmed) == 0);
      }
    }
  }
  CHECK(beats == 30);
  h.arm();
  h.step();
  CHECK(h.says("HOLD", 2));
  h.mode(6);
  h.step();
  REQUIRE_FALSE(h.template all<link::Heartbeat>(2).empty());
  CHECK(h.template all<link::Heartbeat>(2).back().custom_mode == 6);
  CHECK((h.template all<link::Heartbeat>(2).back().base_mode & mav::kModeFlagArmed) != 0);
}

TEST_CASE_TEMPLATE("followers get the state at SR_STATE while it is fresh, and never ODOMETRY", S,
                   float, double) {
  Harbour<S> h;
  h.sail(2);
  std::size_t positions = 0, attitudes = 0, origins = 0;
  for (int k = 0; k < 500; ++k) {
    h.step();
    positions += h.template all<link::LocalPositionNed>().size();
    attitudes += h.template all<link::Attitude>().size();
    origins += h.template all<link::GpsGlobalOrigin>().size();
    REQUIRE(h.template all<link::Odometry>().empty());
  }
  CHECK(positions == 50);
  CHECK(attitudes == 50);
  CHECK(origins == 5);
  h.navigation_talks = false;
  h.sail(0.6);
  for (int k = 0; k < 100; ++k) {
    h.step();
    REQUIRE(h.template all<link::LocalPositionNed>().empty());
    REQUIRE(h.template all<link::Attitude>().empty());
  }
}

TEST_CASE_TEMPLATE("a TIMESYNC request is answered once, with the sender's number", S, float,
                   double) {
  Harbour<S> h;
  h.sail(1);
  h.tell(h.operator_, link::Timesync{0, 123'456'789});
  const std::int64_t read_us = h.now_us;
  std::size_t answers = 0;
  for (int k = 0; k < 50; ++k) {
    h.step();
    for (const auto& t : h.template all<link::Timesync>()) {
      if (t.tc1 == 0) continue;
      ++answers;
      CHECK(t.ts1 == 123'456'789);
      CHECK(t.tc1 == read_us * 1000);
    }
  }
  CHECK(answers == 1);
}

TEST_CASE_TEMPLATE("CURRENT_MODE gives the present mode and the one requested", S, float, double) {
  Harbour<S> h;
  /// mode, and 100 times the intended one
  const auto current_mode = [&]() -> int {
    h.command(mav::kCmdRequestMessage, link::CurrentMode::kId);
    const auto out = h.boat.tick(h.now_us += Harbour<S>::kTick_us).links->bytes(0);
    for (std::size_t at = 0; at < out.size(); at += 12U + out[at + 1]) {
      if (out[at + 7] + 256U * out[at + 8] != link::CurrentMode::kId) continue;
      std::array<std::uint8_t, 9> payload{};  // custom mode, intended one, standard one
      std::copy_n(&out[at + 10], std::min<std::size_t>(9, out[at + 1]), payload.begin());
      return payload[0] + 100 * payload[4];
    }
    return -1;
  };
  h.sail(2);
  CHECK(current_mode() == 404);
  h.cast_off();
  CHECK(current_mode() == 606);
  h.leader_talks = false;
  h.sail(1.5);
  REQUIRE(h.boat.state() == State::kCoast);
  CHECK(current_mode() == 606);
  h.sail(5);
  REQUIRE(h.boat.state() == State::kHold);
  CHECK(current_mode() == 604);
}

TEST_CASE_TEMPLATE("noise on every wire crashes nothing and starts no propeller", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 91;
  INFO("seed ", kSeed);
  testing::AnyMessage any(kSeed);
  Harbour<S> h;
  link::MavlinkEncoder anyone({1, 2});
  for (int k = 0; k < 5000; ++k) {
    testing::Bytes noise(any.u32() % 100);
    for (auto& byte : noise) byte = any.u8();
    h.boat.on_mavlink(noise, h.now_us, 0);
    h.tell(anyone, any(1 + any.u32() % (testing::kMessages - 1)));
    h.boat.on_can(any.u32(), std::span(noise).first(std::min<std::size_t>(noise.size(), 8)),
                  h.now_us);
    h.step();
    REQUIRE(h.stopped());
  }
}

constexpr std::size_t kLinks = 2;

std::vector<std::uint8_t> said(const Boat<float>::Output& out) {
  std::vector<std::uint8_t> all;
  for (std::size_t link = 0; link < kLinks; ++link) {
    const auto bytes = out.links->bytes(link);
    all.insert(all.end(), bytes.begin(), bytes.end());
  }
  for (const link::CanFrame& frame : out.can) {
    all.insert(all.end(), frame.data.begin(), frame.data.begin() + frame.size);
  }
  return all;
}

TEST_CASE("boats that share an outbox send the same as each of them alone") {
  Outbox<kLinks> outbox;
  std::array<Room<kLinks, 0, 10, 5, 1>, 3> rooms;
  std::vector<std::unique_ptr<Boat<float>>> together, alone;
  for (std::uint8_t system = 1; system <= 3; ++system) {
    Parameters p;
    p.MAV_SYSID = system;
    together.push_back(
        std::make_unique<Boat<float>>(p, kLinks, Storage(rooms[system - 1U], outbox)));
    alone.push_back(std::make_unique<Boat<float>>(p, kLinks));
  }
  std::size_t bytes = 0;
  for (std::int64_t now_us = 0; now_us < 3'000'000; now_us += 10'000) {
    for (std::size_t i = 0; i < alone.size(); ++i) {
      const auto expected = said(alone[i]->tick(now_us));
      REQUIRE(said(together[i]->tick(now_us)) == expected);
      bytes += expected.size();
    }
  }
  CHECK(bytes > 3000);
}

TEST_CASE("a boat in the storage of an earlier one knows nothing of that boat's links") {
  Outbox<kLinks> outbox;
  Room<kLinks, 1, 10, 5, 1> room;
  const Storage storage(room, outbox);
  link::MavlinkEncoder client({255, 190});
  {
    Boat<float> first(Parameters{}, kLinks, storage);
    const auto hears = [&](const link::Message& message, std::size_t link) {
      first.on_mavlink(testing::frame_of(client, message), 0, link);
    };
    first.secure({1, 2, 3}, 1, 0);
    first.set_policy(1, SigningPolicy::kAccept);
    first.limit_link(1, 100);
    hears(link::ParamRequestList{{1, 1}}, 0);
    hears(link::RadioStatus{5}, 0);
    hears(link::CommandLong{mav::kCmdSetMessageInterval, {link::Attitude::kId, -1}, {1, 1}, 0}, 0);
    const std::array<std::uint8_t, 3> begun{0xFD, 200, 0};
    first.on_mavlink(begun, 0, 0);
    for (std::int64_t now_us = 0; now_us < 50'000; now_us += 10'000) first.tick(now_us);
  }
  Boat<float> second(Parameters{}, kLinks, storage), fresh(Parameters{}, kLinks);
  for (std::int64_t now_us = 0; now_us < 3'000'000; now_us += 10'000) {
    if (now_us == 1'000'000) {
      for (Boat<float>* boat : {&second, &fresh}) {
        link::MavlinkEncoder again({255, 190});
        const auto ping = testing::frame_of(again, link::Ping{1, 2, {}});
        boat->on_mavlink(ping, now_us, 0);
      }
    }
    REQUIRE(said(second.tick(now_us)) == said(fresh.tick(now_us)));
  }
}

TEST_CASE("a thousand boats fit into a processor's memory") {
  CHECK(sizeof(Boat<float>) + sizeof(Room<kLinks, 0, 10, 5, 1>) < 36'000);
}

}  // namespace
}  // namespace flotilla::app
