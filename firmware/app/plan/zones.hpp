// SPDX-License-Identifier: MIT
// A fence and rally points as a ground station sent them, item by item, and whether they are sound.
#pragma once

#include <optional>

#include "app/plan/plan.hpp"

namespace flotilla::app {

constexpr float kLeastCircle_m = 1, kGreatestCircle_m = 2000;

/// One zone of a sound fence: its items, one for each corner, or one for a circle.
struct ZoneItems {
  Plan items;
  float radius_m = 0;  ///< of a circle
  bool keeps_in = true;
};

/// The zone that begins with the first item; it takes no more items than there are.
ZoneItems first_zone(Plan fence);

/// Judges the last item of a fence whose other items are sound.
PlanFault fault_of_last_zone(Plan fence);

/// Judges a whole fence whose items are each sound.
PlanFault fault_of_zones(Plan fence);

/// Judges the last rally point; the others are sound.
PlanFault fault_of_last_rally(Plan points);

}  // namespace flotilla::app
