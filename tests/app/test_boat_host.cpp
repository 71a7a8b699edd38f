// SPDX-License-Identifier: MIT
// The host's reports to the boat, and the boat's output to its host.
#include <doctest/doctest.h>

#include <algorithm>

#include "app/harbour.hpp"

namespace flotilla::app {
namespace {

using core::State;
namespace mav = link::mav;

template <class S>
using Harbour = testing::Harbour<S>;

constexpr link::SigningKey kKey{1, 2, 3};
constexpr std::int64_t kUnix_us = 1'800'000'000'000'000;

TEST_CASE_TEMPLATE(
    "the CAN bus goes down: FAULT within a tick, until the bus is up and the operator disarms", S,
    float, double) {
  Harbour<S> h;
  h.cast_off();
  h.boat.on_host({.bus_up = false});
  h.step();
  CHECK(h.boat.state() == State::kFault);
  CHECK(h.stopped());
  CHECK(h.arming == 0);
  CHECK(h.says("CAN bus is down"));
  h.boat.on_host({});
  h.sail(1);
  CHECK(h.boat.state() == State::kFault);
  h.disarm();
  h.cast_off();
  CHECK(h.pushes());
}

TEST_CASE_TEMPLATE(
    "a boat whose parameters fell back to defaults cannot be armed before they are saved", S, float,
    double) {
  Harbour<S> h;
  h.boat.on_host({.why_not_to_arm = kParametersUnsaved});
  h.step();
  CHECK(h.says("parameters are default or old: check and save them"));
  h.sail(2);
  h.arm();
  h.step();
  CHECK(h.boat.state() == State::kDisarmed);
  CHECK(h.says("PreArm: parameters or fence are not saved"));
  h.command(mav::kCmdPreflightStorage, 1);
  h.step();
  CHECK(h.boat.take_save_request() == SaveRequest::kConfirmed);
  CHECK(h.boat.take_save_request() == SaveRequest::kNone);
  h.boat.on_host({});
  h.arm();
  h.step();
  CHECK(h.boat.state() == State::kHold);
}

TEST_CASE_TEMPLATE("a boat that lost its fence cannot be armed before the fence is sent or cleared",
                   S, float, double) {
  Harbour<S> h;
  const auto report = [&] {
    h.boat.on_host({.why_not_to_arm = h.boat.fence_is_lost() ? kFenceLost : ""});
    h.step();
  };
  h.boat.lose_fence();
  report();
  CHECK(h.says("stored fence is not usable: send or clear it"));
  h.sail(2);
  h.arm();
  h.step();
  CHECK(h.boat.state() == State::kDisarmed);
  CHECK(h.says("PreArm: parameters or fence are not saved"));
  const std::uint32_t lost = h.boat.stored_id(Stored::kFence);
  constexpr auto kFence = static_cast<std::uint8_t>(Stored::kFence);
  SUBCASE("cleared") { h.tell(h.operator_, link::MissionClearAll{{1, 1}, kFence}); }
  SUBCASE("sent") {
    const link::GpsGlobalOrigin here{410'000'000, 20'000'000, 0, 0};
    h.tell(h.operator_, link::MissionCount{{1, 1}, 1, kFence, 0});
    h.step();
    link::MissionItemInt circle{};
    circle.target = {1, 1};
    circle.frame = mav::kFrameGlobal;
    circle.command = mav::kFenceCircleInclusion;
    circle.param[0] = 100;
    circle.x = here.latitude;
    circle.y = here.longitude;
    circle.mission_type = kFence;
    h.tell(h.operator_, circle);
  }
  h.step();
  CHECK(h.boat.stored_id(Stored::kFence) != lost);  // so the host saves the new fence, or none
  report();
  h.arm();
  h.step();
  CHECK(h.boat.state() == State::kHold);
}

TEST_CASE_TEMPLATE("a disk that cannot store the parameters is reported once", S, float, double) {
  Harbour<S> h;
  h.sail(1);
  h.boat.on_host({.save_failed = true});
  h.step();
  CHECK(h.says("parameters could not be saved"));
  for (int k = 0; k < 300; ++k) {
    h.step();
    REQUIRE_FALSE(h.says("could not be saved"));
  }
  h.boat.on_host({});
  h.step();
  h.boat.on_host({.save_failed = true});
  h.step();
  CHECK(h.says("could not be saved"));
}

TEST_CASE_TEMPLATE("a link whose device is missing is reported on the others", S, float, double) {
  Harbour<S> h;
  h.boat.on_host({.closed_links = 0b100});
  h.step();
  CHECK(h.says("MAVLink link 2 is not open"));
}

TEST_CASE_TEMPLATE("when its host exits, a boat sends zeros and ArmingStatus 0", S, float, double) {
  Harbour<S> h;
  h.cast_off();
  REQUIRE(h.pushes());
  h.boat.disarm();
  h.step();
  CHECK(h.stopped());
  CHECK(h.arming == 0);
  CHECK(h.boat.state() == State::kDisarmed);
}

TEST_CASE_TEMPLATE("the host's clock is broadcast to all", S, float, double) {
  Harbour<S> h;
  h.boat.on_host({.unix_us = kUnix_us});
  bool told = false;
  for (int k = 0; k < 200; ++k) {
    h.step();
    for (const auto& time : h.template all<link::SystemTime>()) {
      told = true;
      CHECK(time.time_unix_usec == kUnix_us);
    }
  }
  CHECK(told);
}

TEST_CASE_TEMPLATE(
    "with a key a boat signs, and ignores unsigned messages where it requires signatures", S, float,
    double) {
  Harbour<S> h(Parameters{}, 2);
  const std::uint64_t clock = link::signing_time(kUnix_us);
  h.boat.secure(kKey, clock - 1000, 0);
  h.boat.on_host({.unix_us = kUnix_us});
  CHECK(h.boat.signing_timestamp() == clock);
  h.boat.set_policy(1, SigningPolicy::kRequired);
  h.sail(2);
  h.command(mav::kCmdComponentArmDisarm, 1, 0, 1);
  h.step();
  CHECK(h.boat.state() == State::kDisarmed);
  CHECK(h.boat.snapshot().counters.mavlink_unsigned_refused == 1);

  link::Signing operators;
  operators.start(kKey, clock, 0);
  std::array<std::uint8_t, 300> frame;
  const link::CommandLong arm{mav::kCmdComponentArmDisarm, {1}, {1, 1}, 0};
  const std::size_t size = h.operator_.encode(arm, frame, &operators, 7);
  h.boat.on_mavlink(std::span(frame).first(size), h.now_us, 1);
  h.step();
  CHECK(h.boat.state() == State::kHold);
  CHECK(h.boat.signing_timestamp() > clock);

  const auto out = h.boat.tick(h.now_us += 1'000'000);
  const auto bytes = out.links->bytes(1);
  REQUIRE(bytes.size() > 10);
  CHECK((bytes[2] & 1U) == 1);
  CHECK((out.links->bytes(0)[2] & 1U) == 0);
}

TEST_CASE_TEMPLATE("a limited link carries less telemetry, the others as much as before", S, float,
                   double) {
  Harbour<S> h(Parameters{}, 2);
  h.boat.limit_link(1, 300);
  std::size_t free = 0, limited = 0;
  for (int k = 0; k < 1000; ++k) {
    h.now_us += Harbour<S>::kTick_us;
    h.talk();
    const auto out = h.boat.tick(h.now_us);
    free += out.links->bytes(0).size();
    limited += out.links->bytes(1).size();
  }
  CHECK(limited < 10 * 300 + 300);
  CHECK(free > 3 * limited);
}

TEST_CASE_TEMPLATE("values that a slow link cannot carry at once are sent in later ticks, in order",
                   S, float, double) {
  Parameters p;
  p.FS_SEP_M = 0;  // DEPTH is sent before all others
  Harbour<S> h(p, 2);
  h.boat.limit_link(1, 300);
  h.sail(5);
  std::vector<link::Text<10>> names[2];
  for (int k = 0; k < 6000; ++k) {
    h.step();
    for (std::size_t link = 0; link < 2; ++link) {
      for (const link::Message& message : h.received[link]) {
        const auto* value = std::get_if<link::NamedValueFloat>(&message);
        if (value != nullptr) names[link].push_back(value->name);
      }
    }
  }
  REQUIRE(names[1].size() > 50);
  REQUIRE(names[0].size() > names[1].size());
  auto next = std::find(names[0].begin(), names[0].end(), names[1].front());
  for (const auto& name : names[1]) {
    CHECK(name == *next);
    ++next;
  }
}

TEST_CASE_TEMPLATE(
    "after the origin moves, only the new one is sent, even on a link that had no credit then", S,
    float, double) {
  constexpr std::int32_t kMoved = 410'000'005;  // 6 cm: a plausible place of the boat
  int told = 0;
  for (int k = 10; k < 90; ++k) {
    Parameters p;
    p.SR_STATE = 1;
    Harbour<S> h(p);
    h.boat.limit_link(0, 60);
    h.sail(4);
    for (int i = 0; i < k; ++i) h.step();
    h.tell(h.navigation, link::GpsGlobalOrigin{kMoved, 20'000'000, 0, 0});
    for (int i = k; i < 98; ++i) {  // until the harbour's unit sends its own origin again
      h.step();
      for (const link::Message& message : h.received[0]) {
        const auto* origin = std::get_if<link::GpsGlobalOrigin>(&message);
        if (origin == nullptr) continue;
        CHECK(origin->latitude == kMoved);
        ++told;
      }
    }
  }
  CHECK(told >= 80);
}

TEST_CASE_TEMPLATE("node ids assigned earlier stay assigned", S, float, double) {
  Harbour<S> h;
  CHECK(h.boat.node_ids().restore({{7}, 125}));
  CHECK(h.boat.node_ids().table().size() == 1);
}

TEST_CASE_TEMPLATE(
    "host's clock set back by an hour: FAULT, and after a second the boat follows the new time", S,
    float, double) {
  constexpr std::int64_t kHour_us = 3'600'000'000;
  Harbour<S> h;
  h.now_us = 2 * kHour_us;
  h.cast_off();
  REQUIRE(h.pushes());
  h.now_us -= kHour_us;
  h.leader_clock_us += kHour_us;
  h.sail(1.1);
  // While time stands still, no data can be trusted, including the ESCs'.
  CHECK(h.stopped());
  CHECK(h.boat.state() == State::kFault);
  const std::uint32_t counted = h.boat.snapshot().counters.clock_went_back;
  CHECK(counted > 100);
  h.sail(3);
  CHECK(h.boat.snapshot().counters.clock_went_back == counted);
  CHECK(h.boat.snapshot().own_age_s.value() < 0.1);
  h.disarm();
  h.cast_off();
  CHECK(h.pushes());
}

}  // namespace
}  // namespace flotilla::app
