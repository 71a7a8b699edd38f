// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "app/boat/conditions.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kTick_us = 10'000;
const link::GpsGlobalOrigin kLake{410'000'000, 20'000'000, 500'000, 0};

bool has(core::Conditions met, core::Conditions desired) { return (met & desired) == desired; }

/// Limits, and their inputs tick by tick.
struct Watch {
  Parameters p;
  FailsafeLimits limits;
  FailsafeLimits::Seen seen{.sure = true};

  void voltages(float port, float stbd) {
    seen.escs = {link::EscStatus{}, link::EscStatus{}};
    seen.escs[0]->voltage = port;
    seen.escs[1]->voltage = stbd;
  }
  void at(double north_m, double east_m = 0) {
    seen.place = convert::Position{north_m, east_m, kLake};
  }
  void pass(double seconds) {
    for (int k = 0; k < std::lround(seconds * 100); ++k) {
      seen.now_us += kTick_us;
      limits.look(configuration_of(p).failsafes, seen);
    }
  }
  bool good() const { return has(limits.conditions(), core::kBatteryGood); }
  bool inside() const { return has(limits.conditions(), core::kInsideFence); }
};

TEST_CASE("without limits any battery is good and any position is inside, even an unknown one") {
  Watch watch;
  watch.pass(0.01);
  CHECK(watch.good());
  CHECK(watch.inside());
  CHECK_FALSE(watch.limits.home());
  watch.voltages(NAN, 0);
  watch.at(1e6);
  watch.pass(3);
  CHECK(watch.good());
  CHECK(watch.inside());
}

TEST_CASE("the lower of two voltages decides, after two seconds below or above the limit") {
  for (const bool port : {true, false}) {
    Watch watch;
    watch.p.FS_BATT_V = 11;
    watch.voltages(12, 12);
    watch.pass(1.9);
    CHECK_FALSE(watch.good());  // not known for long enough
    watch.pass(0.2);
    CHECK(watch.good());
    watch.voltages(port ? 10.9F : 12, port ? 12 : 10.9F);
    watch.pass(1.9);
    CHECK(watch.good());
    watch.voltages(11, 11);  // a propeller that starts draws it down for a moment
    watch.pass(0.1);
    watch.voltages(port ? 10.9F : 12, port ? 12 : 10.9F);
    watch.pass(1.9);
    CHECK(watch.good());
    watch.pass(0.2);
    CHECK_FALSE(watch.good());
    watch.voltages(12, 12);
    watch.pass(1.9);
    CHECK_FALSE(watch.good());
    watch.pass(0.2);
    CHECK(watch.good());
  }
}

TEST_CASE("an unknown or invalid voltage does not count as above the limit") {
  Watch watch;
  watch.p.FS_BATT_V = 11;
  watch.pass(3);
  CHECK_FALSE(watch.good());
  watch.voltages(12, 12);
  watch.pass(3);
  CHECK(watch.good());
  watch.voltages(12, NAN);
  watch.pass(3);
  CHECK_FALSE(watch.good());
  watch.voltages(12, 12);
  watch.seen.escs[0].reset();
  watch.pass(3);
  CHECK_FALSE(watch.good());
}

TEST_CASE("home is the first position after arming that the navigation unit reports as good") {
  Watch watch;
  watch.p.FS_FENCE_M = 100;
  watch.seen.sure = false;
  watch.at(60);
  watch.pass(1);
  CHECK_FALSE(watch.limits.home());
  watch.seen.armed = true;
  watch.pass(1);
  CHECK_FALSE(watch.inside());  // the fence has no centre yet
  watch.seen.sure = true;
  watch.at(0);
  watch.pass(0.01);
  CHECK(watch.limits.home()->latitude == 410'000'000);
  CHECK(watch.inside());
  watch.at(50);
  watch.pass(1);
  CHECK(watch.limits.home()->latitude == 410'000'000);
}

TEST_CASE(
    "home is the first known position, then the position of arming, where the boat is inside") {
  Watch watch;
  watch.p.FS_FENCE_M = 100;
  watch.pass(1);
  CHECK_FALSE(watch.inside());  // unknown position
  watch.at(0);
  watch.pass(1);
  REQUIRE(watch.limits.home());
  CHECK(watch.limits.home()->latitude == 410'000'000);
  CHECK(watch.limits.home()->altitude_mm == 500'000);
  CHECK(watch.inside());
  watch.at(5000);  // carried there
  watch.pass(1);
  CHECK(watch.inside());
  CHECK(watch.limits.home()->latitude == 410'000'000);
  watch.seen.armed = true;
  watch.pass(0.01);
  CHECK(watch.inside());
  CHECK(watch.limits.home()->latitude > 410'000'000);
}

TEST_CASE("an armed boat is inside up to the fence, in any direction, and inside again within it") {
  for (const double north : {-1.0, 0.0, 1.0}) {
    for (const double east : {-1.0, 0.0, 1.0}) {
      const double d = std::hypot(north, east);
      if (d == 0) continue;
      Watch watch;
      watch.p.FS_FENCE_M = 100;
      watch.at(20, 30);
      watch.seen.armed = true;
      watch.pass(0.01);
      const auto sail_to = [&](double distance_m) {
        watch.at(20 + north / d * distance_m, 30 + east / d * distance_m);
        watch.pass(0.01);
      };
      sail_to(99.9);
      CHECK(watch.inside());
      sail_to(100.1);
      CHECK_FALSE(watch.inside());
      sail_to(99.9);
      CHECK(watch.inside());
      watch.seen.place.reset();
      watch.pass(0.01);
      CHECK_FALSE(watch.inside());
    }
  }
}

TEST_CASE(
    "a fence still holds after the navigation unit changes its origin, and across the globe") {
  Watch watch;
  watch.p.FS_FENCE_M = 1000;
  watch.at(0);
  watch.seen.armed = true;
  watch.pass(0.01);
  const auto seen_from = [&](std::int32_t latitude, double north_m) {
    watch.seen.place = convert::Position{north_m, 0, {latitude, 20'000'000, 500'000, 0}};
    watch.pass(0.01);
  };
  seen_from(410'100'000, -1110.5 - 900);  // 0.01° are 1110.6 m there
  CHECK(watch.inside());
  seen_from(410'100'000, -1110.5 - 1100);
  CHECK_FALSE(watch.inside());
  seen_from(-410'000'000, 0);
  CHECK_FALSE(watch.inside());
}

TEST_CASE("each failsafe's parameter selects its reaction") {
  using enum core::Reaction;
  Parameters p;
  CHECK(configuration_of(p).failsafes.choices ==
        core::Choices{kCoast, kHold, kHold, kReturn, kHold});
  p.FS_LEADER_ACT = 2;
  p.FS_GCS_ACT = 3;
  p.FS_BATT_ACT = 2;
  p.FS_FENCE_ACT = 0;
  p.FS_COAST_ACT = 1;
  CHECK(configuration_of(p).failsafes.choices ==
        core::Choices{kManual, kLoiter, kReturn, kHold, kLoiter});
  p.FS_LEADER_ACT = 4;
  p.FS_GCS_ACT = 1;
  CHECK(configuration_of(p).failsafes.choices ==
        core::Choices{kReturn, kCoast, kReturn, kHold, kLoiter});
}

TEST_CASE("home is near if it is no farther than a target may be; this is checked once a second") {
  Watch watch;
  const auto near = [&] { return has(watch.limits.conditions(), core::kHomeNear); };
  watch.pass(0.1);
  CHECK_FALSE(near());
  watch.at(0);
  watch.pass(0.1);
  CHECK(near());
  watch.at(2950);
  watch.pass(0.5);
  CHECK(near());
  watch.pass(0.6);
  CHECK_FALSE(near());
  watch.at(2850);
  watch.pass(1.1);
  CHECK(near());
}

}  // namespace
}  // namespace flotilla::app
