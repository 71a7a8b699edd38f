// SPDX-License-Identifier: MIT
// How places move from one shape to the next: as a share s of their ways, in a time T.
//
//   ṡ rises to 1 / (T − ρ) in ρ, stays there, and falls to 0 in ρ      ρ = min(4 s, T/2)
//
// The ramps give a boat time to turn to its place's new course.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace flotilla::app {

constexpr double kMoveRamp_s = 4;

/// A boat of 1.2 m turns about in some 5 s while its place moves (guidance/moving_slot.hpp). It begins
/// half of that time before its place reverses.
constexpr double kTurnAhead_s = 2.4;

struct FleetMove {
  double share = 1;
  double rate = 0;      ///< of share, 1/s
  double rate_dot = 0;  ///< 1/s²
};

/// Velocity and acceleration of a slot relative to the fleet's leader, in the slot's axes.
struct SlotMotion {
  bool moves = false;  ///< or has just done so, and the boat may still turn
  std::array<float, 2> mps{}, mps2{};
  std::array<float, 2> soon_mps{};  ///< velocity in kTurnAhead_s
  bool operator==(const SlotMotion&) const = default;
};

/// t_s after the move began.
inline FleetMove move_at(double t_s, double all_s) {
  if (!(t_s < all_s)) return {};
  const double ramp_s = std::min(kMoveRamp_s, all_s / 2);
  const double most = 1 / (all_s - ramp_s);
  const double t = std::max(t_s, 0.0), left = all_s - t;
  const double most_dot = most / ramp_s;
  if (t < ramp_s) return {most_dot * t * t / 2, most_dot * t, most_dot};
  if (left < ramp_s) return {1 - most_dot * left * left / 2, most_dot * left, -most_dot};
  return {most * (t - ramp_s / 2), most};
}

}  // namespace flotilla::app
