// SPDX-License-Identifier: MIT
// A plan that the boat makes itself: to a target of GUIDED, to a stop in LOITER, home in RTL.
#pragma once

#include <array>
#include <cstddef>

#include "app/guidance/plan.hpp"

namespace flotilla::app {

/// Errands lead no farther than this; with it, the planner stays within its tested range.
constexpr float kErrandReach_m = 2900;

/// A place to sail to.
struct Target {
  convert::GlobalPoint place{};
  float speed_mps = 0;  ///< 0: WP_SPEED
};

class Errand {
 public:
  /// To the target, and waits there.
  void sail_to(const Target& target);

  Plan plan() const { return items_; }

 private:
  std::array<PlanItem, 2> items_{};
};

}  // namespace flotilla::app
