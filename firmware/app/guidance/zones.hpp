// SPDX-License-Identifier: MIT
// A fence and rally points as a ground station sent them, item by item, and whether they are sound.
#pragma once

#include <optional>

#include "app/guidance/plan.hpp"

namespace flotilla::app {

constexpr float kLeastCircle_m = 1, kGreatestCircle_m = 2000;

/// One zone of a sound fence: its items, one a corner, or one for a circle.
struct ZoneItems {
  Plan items;
  float radius_m = 0;  ///< of a circle
  bool keeps_in = true;
};

/// The zone that begins with the first of these items, which it does not outreach.
ZoneItems first_zone(Plan fence);

/// Judges the last item of a fence, all others of which are sound.
PlanFault fault_of_last_zone(Plan fence);

/// Judges a whole fence, each of whose items is sound.
PlanFault fault_of_zones(Plan fence);

/// Judges the last one of rally points, all others of which are sound.
PlanFault fault_of_last_rally(Plan points);

}  // namespace flotilla::app
