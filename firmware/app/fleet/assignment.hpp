// SPDX-License-Identifier: MIT
// Assigns members to the places of a new shape and computes the duration of the move.
//
//   least Σ |b_σ(i) − a_i|²      a_i: boat i's place now, b: the new places
//   ⇒ (a_i − a_j) · (b_σ(i) − b_σ(j)) ≥ 0
//   ⇒ on straight paths, begun and ended together, two boats stay |a| |b| / √(a² + b²) apart,
//     a and b their distances before and after: at least 0.7 of the smaller one
//   |v(t) + w d| ≤ 0.97 u_max       v: the shape's velocity there; w, d: a place's speed and
//                                   direction in it; w changes once, at T₁ (move.hpp)
//
// Source: Turpin, Michael and Kumar, CAPT: Concurrent assignment and planning of trajectories for
// multiple robots, 2014. Solved by shortest augmenting paths (Jonker and Volgenant 1987).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "app/fleet/table.hpp"

namespace flotilla::app {

/// Velocity of the fleet's root at one instant, over ground.
struct FleetCourse {
  float ahead_mps = 0;
  float heading_rad = 0;
  float turn_radps = 0;
};

/// Predicted motion; the last sample holds from then on.
struct FleetOutlook {
  static constexpr std::size_t kMax = 64;
  static constexpr int kEvery_s = 2;

  std::array<FleetCourse, kMax> at{};
  std::size_t count = 1;
  float most_mps = 0;  ///< LAW_U_MAX
};

/// The requested table with its places assigned to its members. `now`: present places by rank,
/// nullopt if none. Members without a leader, and leader-only members, keep their places unless a
/// path passes too near: then all places are assigned. `root`: rank of the member whose outlook it
/// is. `in_s`: from the outlook's first sample to the start of the move.
FleetTable assigned(const FleetTable& requested, std::span<const std::optional<FleetSlot>> now,
                    std::size_t root, const FleetOutlook& outlook, double in_s);

}  // namespace flotilla::app
