// SPDX-License-Identifier: MIT
// Who takes which place of a new shape, and how long all take to get there.
//
//   least Σ |b_σ(i) − a_i|²      a_i: boat i's place now, b: the new places
//   ⇒ (a_i − a_j) · (b_σ(i) − b_σ(j)) ≥ 0
//   ⇒ on straight ways, begun and ended together, two boats stay |a| |b| / √(a² + b²) apart,
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

/// How the fleet's root sails at one instant, over ground.
struct FleetCourse {
  float ahead_mps = 0;
  float heading_rad = 0;
  float turn_radps = 0;
};

/// How it will sail; after the last sample as in the last one.
struct FleetOutlook {
  static constexpr std::size_t kMost = 64;
  static constexpr int kEvery_s = 2;

  std::array<FleetCourse, kMost> at{};
  std::size_t count = 1;
  float most_mps = 0;  ///< LAW_U_MAX
};

/// The table with its places given anew to its members. `now`: their present places, by rank in
/// `wanted`; nothing for who has none yet. Who follows nobody, or only leads, keeps its place,
/// unless somebody's way would pass it too near: then all places are free. `root`: the rank
/// of the member whose outlook it is; `in_s`: from its first sample until the move begins.
FleetTable assigned(const FleetTable& wanted, std::span<const std::optional<FleetSlot>> now,
                    std::size_t root, const FleetOutlook& outlook, double in_s);

}  // namespace flotilla::app
