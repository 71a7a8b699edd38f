// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <set>

#include "app/operator/requests/commands.hpp"

namespace flotilla::app {
namespace {

using core::Request;
namespace mav = link::mav;

DecodedCommand meaning(std::uint16_t command, std::array<float, 7> param) {
  return meaning_of(*command_of(link::CommandLong{command, param, {1, 1}, 0}));
}
DecodedCommand meaning(std::uint16_t command, float first, float second = 0) {
  return meaning(command, {first, second, 0, 0, 0, 0, 0});
}
bool asks_nothing(const DecodedCommand& asked) {
  return asked.request == Request::kNone && !asked.save_parameters && !asked.motor_test &&
         !asked.message && !asked.rate && !asked.item && !asked.paused;
}
bool denied(const DecodedCommand& asked) {
  return asked.result == mav::kDenied && asks_nothing(asked);
}

TEST_CASE(
    "arm and disarm requests reach the supervisor, with unused fields 0, NaN or the force number") {
  for (const float second : {0.0F, NAN, 21196.0F}) {
    CHECK(meaning(mav::kCmdComponentArmDisarm, 1, second).request == Request::kArm);
    CHECK(meaning(mav::kCmdComponentArmDisarm, 0, second).request == Request::kDisarm);
  }
  CHECK(meaning(mav::kCmdComponentArmDisarm, 0, 77).request == Request::kDisarm);
  CHECK(denied(meaning(mav::kCmdComponentArmDisarm, 1, 77)));
}

TEST_CASE("an arming that is neither 0 nor 1 is denied") {
  for (const float first : {2.0F, 0.5F, -1.0F, 255.0F, NAN, INFINITY}) {
    CHECK(denied(meaning(mav::kCmdComponentArmDisarm, first)));
  }
}

TEST_CASE("modes have Rover's numbers; every other one is denied") {
  CHECK(meaning(mav::kCmdDoSetMode, 1, 0).request == Request::kManual);
  CHECK(meaning(mav::kCmdDoSetMode, 1, 4).request == Request::kHold);
  CHECK(meaning(mav::kCmdDoSetMode, 1, 6).request == Request::kFormation);
  CHECK(meaning(mav::kCmdDoSetMode, 1, 10).request == Request::kAuto);
  CHECK(meaning(mav::kCmdDoSetMode, 1, 5).request == Request::kLoiter);
  CHECK(meaning(mav::kCmdDoSetMode, 1, 11).request == Request::kReturn);
  CHECK(meaning(mav::kCmdDoSetMode, 1, 15).request == Request::kGuided);
  for (const float mode : {3.0F, 6.5F, 12.0F, -6.0F, NAN, 1e30F, INFINITY}) {
    CHECK(denied(meaning(mav::kCmdDoSetMode, 1, mode)));
  }
  for (const float base : {0.0F, 128.0F, NAN, -1.0F, 1e30F, 1.5F}) {
    CHECK(denied(meaning(mav::kCmdDoSetMode, base, 6)));
  }
  for (int mode = -300; mode < 300; ++mode) {
    constexpr std::array kKnown{0, 4, 5, 6, 10, 11, 15};
    const bool known = std::ranges::find(kKnown, mode) != kKnown.end();
    const DecodedCommand asked = meaning(mav::kCmdDoSetMode, 1, static_cast<float>(mode));
    CHECK(denied(asked) != known);
    CHECK(asked.why.empty() == known);
  }
}

TEST_CASE("mode 6 is FOLLOW as Rover's clients ask for it, and OFFBOARD in every other form") {
  CHECK(meaning(mav::kCmdDoSetMode, {1, 6, 0, 0, 0, 0, 0}).request == Request::kFormation);
  for (const float base : {129.0F, 29.0F, 33.0F, 217.0F}) {
    CHECK(denied(meaning(mav::kCmdDoSetMode, {base, 6, 0, 0, 0, 0, 0})));
  }
  for (std::size_t unused = 2; unused < 7; ++unused) {
    std::array<float, 7> param{1, 6, 0, 0, 0, 0, 0};
    for (const float value : {NAN, 1.0F, -0.5F}) {
      param[unused] = value;
      CHECK(denied(meaning(mav::kCmdDoSetMode, param)));
    }
  }
  for (const float base : {1.0F, 129.0F}) {  // MAVSDK's offboard.start(), disarmed and armed
    CHECK(denied(meaning(mav::kCmdDoSetMode, {base, 6, 0, NAN, NAN, NAN, NAN})));
  }
}

TEST_CASE(
    "sub modes are denied with a text, except PX4's (4, 3): HOLD, (4, 4): AUTO and (4, 5): RTL") {
  for (const float base : {1.0F, 129.0F}) {
    for (float main = 0; main < 10; ++main) {
      for (float sub = 1; sub < 12; ++sub) {
        const DecodedCommand asked =
            meaning(mav::kCmdDoSetMode, {base, main, sub, NAN, NAN, NAN, NAN});
        const bool known = main == 4 && sub >= 3 && sub <= 5;
        CHECK(asked.request == (!known     ? Request::kNone
                                : sub == 3 ? Request::kHold
                                : sub == 4 ? Request::kAuto
                                           : Request::kReturn));
        CHECK(denied(asked) != known);
        CHECK(asked.why.empty() == known);
        CHECK(asked.why.size() <= 41);  // "Refused: " before it, 50 in all
      }
    }
  }
}

TEST_CASE("no flag of the base mode requests MANUAL, but HOLD can be requested in any form") {
  CHECK(denied(meaning(mav::kCmdDoSetMode, 33, 0)));  // pymavlink: set_mode_flag(HIL, True)
  CHECK(denied(meaning(mav::kCmdDoSetMode, 192, 0)));
  CHECK(meaning(mav::kCmdDoSetMode, 129, 0).request == Request::kManual);
  for (const float base : {1.0F, 129.0F, 29.0F, 217.0F}) {
    for (const float sub : {0.0F, 3.0F, NAN}) {
      const DecodedCommand asked = meaning(mav::kCmdDoSetMode, {base, 4, sub, NAN, NAN, NAN, NAN});
      CHECK(asked.request == Request::kHold);
    }
  }
}

TEST_CASE("SET_MODE uses Rover's modes, whatever heartbeat flags it repeats") {
  const auto set_mode = [](std::uint8_t base, std::uint32_t mode) {
    return meaning_of(*command_of(link::SetMode{mode, 1, base}));
  };
  for (const std::uint8_t base : std::initializer_list<std::uint8_t>{1, 129, 141, 193}) {
    CHECK(set_mode(base, 0).request == Request::kManual);
    CHECK(set_mode(base, 4).request == Request::kHold);
    CHECK(set_mode(base, 6).request == Request::kFormation);
    for (const std::uint32_t px4 : {6U << 16U, 4U << 16U | 3U << 24U, 4U << 16U | 5U << 24U}) {
      CHECK(denied(set_mode(base, px4)));
    }
  }
  for (const std::uint32_t mode : {0U, 1U, 6U})
    CHECK(denied(set_mode(128, mode)));  // safety switch
}

TEST_CASE("every unknown command number is unsupported and requests nothing") {
  const std::set<unsigned> known{20,  176, 185, 192, 193, 207, 209, 224, 245,
                                 262, 300, 400, 410, 510, 511, 512, 519, 520};
  for (unsigned id = 0; id <= UINT16_MAX; ++id) {
    const DecodedCommand asked = meaning(static_cast<std::uint16_t>(id), 1);
    if (known.count(id) != 0) {
      REQUIRE(asked.result != mav::kUnsupported);
    } else {
      REQUIRE(asked.result == mav::kUnsupported);
      REQUIRE(asks_nothing(asked));
    }
  }
  CHECK(meaning(mav::kCmdDoSetStandardMode, 1).result == mav::kFailed);
  CHECK(meaning(mav::kCmdDoSetStandardMode, 6).request == Request::kAuto);
  CHECK(meaning(mav::kCmdDoSetStandardMode, 5).request == Request::kReturn);
  CHECK(meaning(mav::kCmdNavReturnToLaunch, 0).request == Request::kReturn);
}

TEST_CASE("DO_REPOSITION requests GUIDED to a position, only in COMMAND_INT and a global frame") {
  const auto reposition = [](float speed, float flags, std::int32_t x, std::uint8_t frame) {
    link::CommandInt c{};
    c.command = mav::kCmdDoReposition;
    c.param = {speed, flags, NAN, NAN};
    c.x = x;
    c.y = 20'000'000;
    c.z = NAN;
    c.frame = frame;
    return meaning_of(*command_of(c));
  };
  const DecodedCommand asked = reposition(1.5F, 1, 410'000'000, 6);
  CHECK(asked.result == mav::kAccepted);
  CHECK(asked.request == Request::kGuided);
  REQUIRE(asked.target);
  CHECK(asked.target->place.latitude == 410'000'000);
  CHECK(asked.target->place.longitude == 20'000'000);
  CHECK(asked.target->speed_mps == 1.5F);
  for (const float none : {NAN, -1.0F, 0.0F}) {
    CHECK(reposition(none, 1, 410'000'000, 0).target->speed_mps == 0);
  }
  CHECK(reposition(NAN, 0, 410'000'000, 3).request == Request::kNone);  // for a boat in GUIDED
  CHECK(denied(reposition(NAN, 2, 410'000'000, 3)));
  CHECK(denied(reposition(NAN, 1, 899'000'000, 3)));
  for (const std::uint8_t local : std::initializer_list<std::uint8_t>{1, 7, 8, 12}) {
    CHECK(reposition(NAN, 1, 410'000'000, local).result == mav::kUnsupportedFrame);
  }
  CHECK(meaning(mav::kCmdDoReposition, {-1, 1, 0, NAN, 41, 2, 0}).result == mav::kCommandIntOnly);
}

TEST_CASE("a motor test is one propeller, up to 20 percent either way, for up to 5 seconds") {
  const auto test = [](float propeller, float kind, float percent, float s, float count) {
    return meaning(mav::kCmdDoMotorTest, {propeller, kind, percent, s, count, 0, NAN});
  };
  const DecodedCommand port = test(1, 0, 20, 5, 0), stbd = test(2, 0, -12.5F, 0.5F, NAN);
  CHECK(port.result == mav::kAccepted);
  CHECK(port.request == Request::kTest);
  CHECK(port.motor_test == MotorTest{false, 0.2, 5'000'000});
  CHECK(stbd.motor_test == MotorTest{true, -0.125, 500'000});
  CHECK(test(2, 0, 0, 1, 1).request == Request::kTest);
  for (const float nonsense : {0.0F, 3.0F, -1.0F, 1.5F, NAN, INFINITY, 1e30F}) {
    CHECK(denied(test(nonsense, 0, 5, 1, 0)));
  }
  for (const float kind : {1.0F, 2.0F, 3.0F, -1.0F, NAN}) CHECK(denied(test(1, kind, 5, 1, 0)));
  for (const float percent : {20.001F, -20.001F, 100.0F, 1100.0F, NAN, -INFINITY}) {
    CHECK(denied(test(1, 0, percent, 1, 0)));
  }
  for (const float s : {-1.0F, 5.001F, NAN, INFINITY}) CHECK(denied(test(1, 0, 5, s, 0)));
  for (const float count : {2.0F, -1.0F, 0.5F, INFINITY}) CHECK(denied(test(1, 0, 5, 1, count)));
}

TEST_CASE("only the value 1 requests termination or saving") {
  CHECK(meaning(mav::kCmdDoFlightTermination, 1).request == Request::kTerminate);
  CHECK(meaning(mav::kCmdPreflightStorage, 1).save_parameters);
  CHECK(meaning(mav::kCmdPreflightStorage, 1).request == Request::kNone);
  for (const float first : {0.0F, 2.0F, 0.5F, -1.0F, NAN, INFINITY}) {
    CHECK(denied(meaning(mav::kCmdDoFlightTermination, first)));
    CHECK(denied(meaning(mav::kCmdPreflightStorage, first)));
  }
}

TEST_CASE("a message is requested by its number, directly or by the older commands") {
  for (unsigned id = 0; id <= UINT16_MAX; ++id) {
    const DecodedCommand asked = meaning(mav::kCmdRequestMessage, static_cast<float>(id), NAN);
    REQUIRE(asked.message);
    REQUIRE(asked.message->id == id);
    REQUIRE(asked.message->index == 0);
    REQUIRE(asked.reads_only());
    const DecodedCommand interval =
        meaning(mav::kCmdGetMessageInterval, static_cast<float>(id), NAN);
    REQUIRE(interval.message);
    REQUIRE(interval.message->id == link::MessageInterval::kId);
    REQUIRE(interval.message->index == id);
  }
  CHECK(meaning(mav::kCmdRequestMessage, 435, 2).message->index == 2);
  CHECK(meaning(mav::kCmdRequestAutopilotCapabilities, 1).message->id == 148);
  CHECK(meaning(mav::kCmdRequestProtocolVersion, 1).message->id == 300);
  CHECK(meaning(mav::kCmdGetHomePosition, 0).message->id == link::HomePosition::kId);
  for (const float id : {-1.0F, 0.5F, 65536.0F, 1e30F, NAN, INFINITY, -INFINITY}) {
    CHECK(denied(meaning(mav::kCmdRequestMessage, id)));
    CHECK(denied(meaning(mav::kCmdSetMessageInterval, id, 1e6F)));
  }
}

TEST_CASE("an interval is −1, 0 or a number of microseconds; any other value is denied") {
  const auto interval = [](float us) { return meaning(mav::kCmdSetMessageInterval, 30, us); };
  CHECK(interval(-1).rate->interval_us == -1);
  CHECK(interval(0).rate->interval_us == 0);
  CHECK(interval(100'000).rate->interval_us == 100'000);
  CHECK(interval(0.25F).rate->interval_us == 1);  // the fastest, not the default
  CHECK(interval(1e6F).rate->id == 30);
  CHECK_FALSE(interval(1e6F).reads_only());
  for (const float us : {-2.0F, -1.001F, 1e10F, NAN, INFINITY, -INFINITY})
    CHECK(denied(interval(us)));
}

TEST_CASE("COMMAND_INT and SET_MODE have the same effect as COMMAND_LONG") {
  const Command as_long =
      *command_of(link::CommandLong{209, {1, 0, 10, 2, 1, 0, NAN}, {7, 191}, 3});
  for (unsigned frame = 0; frame < 256; ++frame) {
    const Command as_int = *command_of(link::CommandInt{
        209, {1, 0, 10, 2}, 1, 0, NAN, {7, 191}, static_cast<std::uint8_t>(frame)});
    CHECK(as_int.id == as_long.id);
    CHECK(as_int.target == as_long.target);
    CHECK(as_int.wants_ack);
    CHECK(meaning_of(as_int).motor_test == meaning_of(as_long).motor_test);
  }
  const auto extreme =
      command_of(link::CommandInt{512, {30, 0, 0, 0}, INT32_MIN, INT32_MAX, INFINITY, {1, 1}, 0});
  CHECK(meaning_of(*extreme).message->id == 30);
  const Command mode = *command_of(link::SetMode{6, 7, 1});
  CHECK(mode.target == link::Address{7, 0});
  CHECK_FALSE(mode.wants_ack);
  CHECK(meaning_of(mode).request == Request::kFormation);
  CHECK(denied(meaning_of(*command_of(link::SetMode{UINT32_MAX, 7, 1}))));
  CHECK(denied(meaning_of(*command_of(link::SetMode{6, 7, 0}))));
  CHECK_FALSE(command_of(link::Ping{}).has_value());
  CHECK_FALSE(command_of(RequestMessage{}).has_value());
}

TEST_CASE("any bit pattern in a command's fields gives a valid request or none") {
  constexpr std::uint32_t kSeed = 11;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  constexpr std::array<std::uint16_t, 11> kKnown{176, 185, 209, 245, 262, 400,
                                                 510, 511, 512, 519, 520};
  constexpr std::array kTypical{0.0F, 1.0F, 2.0F, 4.0F, 6.0F, -1.0F, NAN, INFINITY, 1e38F};
  for (int k = 0; k < 200'000; ++k) {
    std::array<float, 7> param{};
    for (float& x : param) {
      const auto bits = static_cast<std::uint32_t>(random());
      std::memcpy(&x, &bits, sizeof x);
      if (random() % 2 == 0) x = kTypical[random() % kTypical.size()];
    }
    const std::uint16_t id = kKnown[random() % kKnown.size()];
    const DecodedCommand asked = meaning(id, param);
    REQUIRE(asked.result <= mav::kFailed);
    if (asked.result != mav::kAccepted) REQUIRE(asks_nothing(asked));
    REQUIRE(asked.motor_test.has_value() == (asked.request == Request::kTest));
    const Command command = *command_of(link::CommandLong{id, param, {1, 1}, 0});
    REQUIRE(is_disarm(command) == (asked.request == Request::kDisarm));
    if (asked.motor_test) {
      REQUIRE(std::abs(asked.motor_test->share) <= 0.2);
      REQUIRE(asked.motor_test->duration_us >= 0);
      REQUIRE(asked.motor_test->duration_us <= 5'000'000);
    }
    if (asked.rate) REQUIRE(asked.rate->interval_us >= -1);
  }
}

}  // namespace
}  // namespace flotilla::app
