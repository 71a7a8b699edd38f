// SPDX-License-Identifier: MIT
// A plan that the boat makes itself: to a target of GUIDED, to a stop in LOITER, home in RTL.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "app/plan/plan.hpp"

namespace flotilla::app {

/// Greatest distance to an errand's places. It keeps the planner within its tested range.
constexpr float kErrandReach_m = 2900;

/// A place to sail to.
struct Target {
  convert::GlobalPoint place{};
  float speed_mps = 0;  ///< 0: WP_SPEED
  bool operator==(const Target&) const = default;
};

class Errand {
 public:
  /// Greatest number of bends on the way to a target.
  static constexpr std::size_t kBends = 4;

  /// Sails to the target, and waits there.
  void sail_to(const Target& target);

  /// Sails by these places first, at most kBends, passing within radius_m of them.
  void sail_by(std::span<const convert::GlobalPoint> bends, float radius_m, const Target& target);

  void set_speed(float mps);

  /// The end of the errand.
  Target target() const;

  Plan plan() const { return Plan(items_).first(count_); }

 private:
  std::array<PlanItem, 2 + kBends> items_{};
  std::size_t count_ = 0;
};

}  // namespace flotilla::app
