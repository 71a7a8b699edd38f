// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "app/commands.hpp"

namespace flotilla::app {
namespace {

using core::Request;
namespace mav = link::mav;

PendingCommand pending(std::uint16_t command, float first, float second = 0,
                       std::uint8_t from = 255) {
  return {0, {from, 190}, {command, {first, second, 0, 0, 0, 0, 0}, 1, 1, 0}};
}

TEST_CASE("arm and disarm ask the supervisor, with the unused fields 0, NaN or the force number") {
  for (const float second : {0.0F, NAN, 21196.0F}) {
    CHECK(meaning_of(pending(mav::kCmdComponentArmDisarm, 1, second), {}).request == Request::kArm);
    CHECK(meaning_of(pending(mav::kCmdComponentArmDisarm, 0, second), {}).request ==
          Request::kDisarm);
  }
  CHECK(meaning_of(pending(mav::kCmdComponentArmDisarm, 0, 77), {}).request == Request::kDisarm);
}

TEST_CASE("an arming that is neither 0 nor 1 is denied") {
  for (const float first : {2.0F, 0.5F, -1.0F, 255.0F, NAN, INFINITY}) {
    const Asked asked = meaning_of(pending(mav::kCmdComponentArmDisarm, first), {});
    CHECK(asked.request == Request::kNone);
    CHECK(asked.result == mav::kDenied);
  }
}

TEST_CASE("modes are HOLD and FORMATION by Rover's numbers; every other one is denied") {
  CHECK(meaning_of(pending(mav::kCmdDoSetMode, 1, 4), {}).request == Request::kHold);
  CHECK(meaning_of(pending(mav::kCmdDoSetMode, 1, 6), {}).request == Request::kFormation);
  CHECK(meaning_of(pending(mav::kCmdDoSetMode, 129, 6), {}).request == Request::kFormation);
  for (const float mode : {0.0F, 5.0F, 6.5F, 10.0F, -6.0F, NAN, 1e30F}) {
    const Asked asked = meaning_of(pending(mav::kCmdDoSetMode, 1, mode), {});
    CHECK(asked.request == Request::kNone);
    CHECK(asked.result == mav::kDenied);
  }
  for (const float base : {0.0F, 128.0F, NAN, -1.0F, 1e30F}) {
    CHECK(meaning_of(pending(mav::kCmdDoSetMode, base, 6), {}).request == Request::kNone);
  }
}

TEST_CASE("an unknown command is unsupported") {
  CHECK(meaning_of(pending(22, 1), {}).result == mav::kUnsupported);
  CHECK(meaning_of(pending(22, 1), {}).request == Request::kNone);
}

TEST_CASE("where one ground station commands, no other does") {
  Parameters p;
  p.MAV_GCS_SYSID = 250;
  CHECK(meaning_of(pending(mav::kCmdComponentArmDisarm, 1, 0, 250), p).request == Request::kArm);
  CHECK(meaning_of(pending(mav::kCmdComponentArmDisarm, 1, 0, 251), p).request == Request::kNone);
  CHECK(meaning_of(pending(mav::kCmdComponentArmDisarm, 1, 0, 251), p).result == mav::kDenied);
}

TEST_CASE("a command is for us by our ids or by zeros, and for others by theirs") {
  Parameters p;
  p.MAV_SYSID = 7;
  p.MAV_COMPID = 191;
  const auto to = [&](std::uint8_t system, std::uint8_t component) {
    return addressed_to(link::CommandLong{400, {}, system, component, 0}, p);
  };
  CHECK(to(7, 191));
  CHECK(to(0, 0));
  CHECK(to(7, 0));
  CHECK_FALSE(to(8, 191));
  CHECK_FALSE(to(7, 1));
  CHECK_FALSE(to(255, 0));
}

TEST_CASE("eight commands wait in their order, the ninth is counted") {
  CommandQueue queue;
  link::Counters counters;
  for (std::uint16_t i = 0; i < 9; ++i) queue.push(pending(i, 0), counters);
  REQUIRE(queue.pending().size() == 8);
  for (std::uint16_t i = 0; i < 8; ++i) CHECK(queue.pending()[i].command.command == i);
  CHECK(counters.commands_dropped == 1);
  queue.clear();
  CHECK(queue.pending().empty());
}

}  // namespace
}  // namespace flotilla::app
