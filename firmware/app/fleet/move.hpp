// SPDX-License-Identifier: MIT
// Moves places from one shape to the next along straight paths; s is the share that is covered.
// The leader's plan permits one speed before T₁ and another after it.
//
//   ṡ rises to v₁ in ρ, goes over to v₂ in ρ around T₁, and falls to 0 in ρ, until T
//   v₁ = s₁ / (T₁ − ρ/2),  v₂ = (1 − s₁) / (T − T₁ − ρ/2)
//   s₁: the share covered at T₁ if the ramp there took no time
//   ρ = min(4 s, ⅔ T₁, ⅔ (T − T₁));   without T₁: T₁ = T/2, s₁ = ½, so that v₁ = v₂
//
// The ramps give a boat time to turn to its place's new course.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace flotilla::app {

constexpr double kMoveRamp_s = 4;

/// A boat of 1.2 m turns about in some 5 s while its place moves (guidance/moving_slot.hpp), so it
/// begins half of that time before its place reverses.
constexpr double kTurnAhead_s = 2.4;

struct FleetPace {
  double all_s = 0;        ///< T
  double first_s = 0;      ///< T₁; 0: one speed
  double first_share = 0;  ///< s₁
};

struct FleetMove {
  double share = 1;
  double rate = 0;      ///< of share, 1/s
  double rate_dot = 0;  ///< 1/s²
};

/// Velocity and acceleration of a slot relative to the fleet's leader, in the slot's axes.
struct SlotMotion {
  bool moves = false;  ///< moves, or has just moved, and the boat may still turn
  std::array<float, 2> mps{}, mps2{};
  std::array<float, 2> soon_mps{};  ///< velocity in kTurnAhead_s
  bool operator==(const SlotMotion&) const = default;
};

/// t_s after the move began.
inline FleetMove move_at(double t_s, const FleetPace& pace) {
  if (!(t_s < pace.all_s)) return {};
  const bool changes = 0 < pace.first_s && pace.first_s < pace.all_s;
  const double first_s = changes ? pace.first_s : pace.all_s / 2;
  const double share = changes ? pace.first_share : 0.5;
  const double second_s = pace.all_s - first_s;
  const double ramp_s = std::min({kMoveRamp_s, first_s / 1.5, second_s / 1.5});
  const double first = share / (first_s - ramp_s / 2);
  const double second = (1 - share) / (second_s - ramp_s / 2);
  struct Knot {
    double s, rate;
  };
  const std::array knots{Knot{0, 0},
                         Knot{ramp_s, first},
                         Knot{first_s - ramp_s / 2, first},
                         Knot{first_s + ramp_s / 2, second},
                         Knot{pace.all_s - ramp_s, second},
                         Knot{pace.all_s, 0}};
  FleetMove out{.share = 0};
  for (std::size_t k = 1; k < knots.size() && knots[k - 1].s <= std::max(t_s, 0.0); ++k) {
    const Knot &from = knots[k - 1], &to = knots[k];
    const double lasts_s = to.s - from.s, dt = std::min(std::max(t_s, 0.0) - from.s, lasts_s);
    out.rate_dot = lasts_s > 0 ? (to.rate - from.rate) / lasts_s : 0;
    out.rate = from.rate + out.rate_dot * dt;
    out.share += (from.rate + out.rate) / 2 * dt;
  }
  return out;
}

}  // namespace flotilla::app
