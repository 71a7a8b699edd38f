// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "app/convert/convert_scalar.hpp"
#include "app/plan/plan_vessel.hpp"

namespace flotilla::app {
namespace {

constexpr convert::Position kHere{0, 0, {0, 0, 0, 0}};

/// A waypoint near the equator, where both degrees are about equally long.
PlanItem waypoint(double north_m, double east_m) {
  const auto e7 = [](double m, double degree_m) {
    return static_cast<std::int32_t>(std::lround(1e7 * m / degree_m));
  };
  PlanItem item{.x = e7(north_m, 110'574), .y = e7(east_m, 111'320)};
  item.command = link::mav::kNavWaypoint;
  return item;
}

template <class S>
struct Trip {
  explicit Trip(const std::vector<PlanItem>& items) : plan(items) {
    constexpr PlanDefaults kDefaults{.speed_mps = 5, .radius_m = 2, .fastest_mps = 5};
    vessel.start({.plan = plan, .start_m = 2900}, kDefaults, {.accel = S(0.5), .radius = S(3)},
                 kHere, {});
  }

  /// Sails until the vessel arrives, for at most an hour; returns the longest step, m.
  double sail() {
    double longest_m = 0;
    for (int k = 0; k < 36'000 && vessel.is_sound() && !vessel.has_arrived(); ++k) {
      const convert::Position before = vessel.place();
      vessel.forward(plan, {S(0), S(5), S(0)}, false, S(0.1));
      longest_m = std::max(longest_m, convert::distance_m(before, vessel.place()));
    }
    return longest_m;
  }

  std::vector<PlanItem> plan;
  PlanVessel<S> vessel;
};

TEST_CASE_TEMPLATE("a plan that leads farther than the planner's range is sailed to its end", S,
                   float, double, core::Q16) {
  Trip<S> trip({waypoint(0, 2800), waypoint(100, 5600), waypoint(100, 5700), waypoint(2900, 5700),
                waypoint(5600, 5700)});
  CHECK(trip.sail() < 0.6);  // the vessel never jumps
  CHECK(trip.vessel.is_sound());
  REQUIRE(trip.vessel.has_arrived());
  const PlanItem& end = trip.plan.back();
  CHECK(convert::distance_m(trip.vessel.place(), {0, 0, {end.x, end.y, 0, 0}}) < 1);
}

TEST_CASE("a leg beyond the planner's range ends the plan as unsound, not as complete") {
  Trip<float> trip({waypoint(0, 100), waypoint(3200, 100)});
  CHECK(trip.vessel.is_sound());
  trip.sail();
  CHECK_FALSE(trip.vessel.is_sound());
  CHECK_FALSE(trip.vessel.has_arrived());
}

}  // namespace
}  // namespace flotilla::app
