// SPDX-License-Identifier: MIT
// MAV_CMD_INJECT_FAILURE: a host that simulates the sea judges it; on other boats the command is
// unsupported.
#include <doctest/doctest.h>

#include <cmath>
#include <optional>
#include <span>
#include <variant>

#include "app/boat/boat.hpp"
#include "app/operator/requests/commands.hpp"
#include "link/any_message.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
constexpr std::uint8_t kGps = 4, kMotor = 101, kOff = 1;

link::CommandLong asking(float unit, float type, float instance) {
  return {mav::kCmdInjectFailure, {unit, type, instance, 0, 0, 0, 0}, {1, 1}, 0};
}

/// A judge that supports two GPS failures only.
std::uint8_t judge(const Failure& failure) {
  if (failure.unit != kGps) return mav::kUnsupported;
  return failure.instance <= 1 ? mav::kAccepted : mav::kDenied;
}

struct Simulated {
  explicit Simulated(const Parameters& p = Parameters{}) : boat(p, 1) {}

  Boat<float> boat;
  link::MavlinkEncoder operator_{{255, 190}};
  link::MavlinkDecoder decoder;
  std::int64_t now_us = 1'000'000;

  void ask(float unit, float type, float instance) {
    boat.on_mavlink(testing::frame_of(operator_, asking(unit, type, instance)), now_us, 0);
  }

  /// The results of the commands answered in the next tick.
  std::vector<int> answers() {
    std::vector<int> results;
    link::Counters counters;
    const auto out = boat.tick(now_us += 10'000);
    auto bytes = out.links->bytes(0);
    while (!bytes.empty()) {
      bytes = bytes.subspan(decoder.fill(bytes));
      while (const auto received = decoder.next(counters)) {
        const auto* ack = std::get_if<link::CommandAck>(&received->message);
        if (ack != nullptr && ack->command == mav::kCmdInjectFailure) {
          results.push_back(ack->result);
        }
      }
    }
    return results;
  }
};

TEST_CASE("a failure is three whole numbers, the last of which may be left out") {
  const auto meant = [](float unit, float type, float instance) {
    const DecodedCommand asked = meaning_of(*command_of(asking(unit, type, instance)));
    CHECK(asked.result == mav::kUnsupported);
    return asked.failure;
  };
  CHECK(meant(101, 1, 2) == Failure{kMotor, kOff, 2});
  CHECK(meant(4, 0, NAN) == Failure{kGps, 0, 0});
  for (const float no : {-1.0F, 0.5F, 256.0F, NAN, INFINITY}) {
    CHECK_FALSE(meant(no, 1, 0));
    CHECK_FALSE(meant(4, no, 0));
    if (!std::isnan(no)) CHECK_FALSE(meant(4, 1, no));
  }
}

TEST_CASE("a real boat does not support failure injection") {
  Simulated it;
  it.ask(kGps, kOff, 0);
  CHECK(it.answers() == std::vector<int>{mav::kUnsupported});
  CHECK_FALSE(it.boat.take_failure());
}

TEST_CASE("a simulated boat answers with its host's verdict, and the host takes it once") {
  Simulated it;
  it.boat.let_failures_be_injected(&judge);
  it.ask(kGps, kOff, 1);
  CHECK(it.answers() == std::vector<int>{mav::kAccepted});
  CHECK(it.boat.take_failure() == Failure{kGps, kOff, 1});
  CHECK_FALSE(it.boat.take_failure());
  it.ask(kMotor, kOff, 1);
  it.ask(kGps, kOff, 2);
  CHECK(it.answers() == std::vector<int>{mav::kUnsupported, mav::kDenied});
  CHECK_FALSE(it.boat.take_failure());
}

TEST_CASE("a second failure waits until the host has taken the first one") {
  Simulated it;
  it.boat.let_failures_be_injected(&judge);
  it.ask(kGps, kOff, 0);
  it.ask(kGps, 0, 0);
  CHECK(it.answers() == std::vector<int>{mav::kAccepted, mav::kTemporarilyRejected});
  CHECK(it.boat.take_failure() == Failure{kGps, kOff, 0});
  it.ask(kGps, 0, 0);
  CHECK(it.answers() == std::vector<int>{mav::kAccepted});
}

TEST_CASE("a sender that may not command cannot inject failures") {
  Parameters p;
  p.MAV_GCS_SYSID = 254;
  Simulated it(p);
  it.boat.let_failures_be_injected(&judge);
  it.ask(kGps, kOff, 0);
  CHECK(it.answers() == std::vector<int>{mav::kDenied});
  CHECK_FALSE(it.boat.take_failure());
}

}  // namespace
}  // namespace flotilla::app
