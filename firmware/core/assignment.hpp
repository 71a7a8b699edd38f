// SPDX-License-Identifier: MIT
// Gives each boat a slot so that the last boat arrives as early as possible.
//
//   min over permutations σ of  max over boats i of  T_i,σ(i)           bottleneck assignment
//   T   = t_c + |δ|/r_m                                                  time to arrive
//   t_c = (q·w + √((q·w)² + (U² − w²) q²)) / (U² − w²)                   |q + w t_c| = U t_c
//
//  symbol  meaning                                                      unit   tested range
//  q, w    slot seen from the boat, and its velocity                    m, m/s ±200, below U
//  U, r_m  LAW_U_MAX, LAW_R_MAX                                         m/s, rad/s
//  δ       turn to the course of the intercept                          rad
//
// The boat turns on the spot, then sails straight to where it meets the slot. Of all times in the
// table the least is sought (by halving) with which a perfect matching exists (by augmenting paths):
// O(n³ log n), without heap. Of several such assignments the one found first is taken.
//
// Not in paper. Source: R. Burkard, M. Dell'Amico, S. Martello, Assignment Problems, SIAM (2009), 6.2.
//
// Q16.16: tested within ±200 (distances, m)
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/rotation.hpp"

namespace flotilla::core {

constexpr std::size_t kMostSlots = 24;

/// Times to arrive, by boat and slot, s.
template <class S>
using ArrivalTable = std::array<std::array<S, kMostSlots>, kMostSlots>;

/// The slot of each boat.
using Assignment = std::array<std::uint8_t, kMostSlots>;

/// What a boat needs to know of a slot; slots are slower than U.
template <class S>
struct Approach {
  Vec2<S> q_n{};
  Vec2<S> w_n{};
  S psi{};
  S fastest{};
  S turning{};
};

/// T. U at least 0.05 m/s over the slot's speed is counted on, also where it is less.
template <class S>
S arrival_time(const Approach<S>& way) {
  const S distance = hypot(way.q_n.x, way.q_n.y);
  if (!(S(0) < distance)) return S(0);
  const S w = hypot(way.w_n.x, way.w_n.y), U = max(way.fastest, w + S(0.05));
  // Along and across the line to the slot; across it the boat keeps up with the slot.
  const Vec2<S> n = {way.q_n.x / distance, way.q_n.y / distance};
  const S away = sum_of_products(n.x, way.w_n.x, n.y, way.w_n.y);
  const S across = difference_of_products(n.x, way.w_n.y, n.y, way.w_n.x);
  const S closing = sqrt((U - across) * (U + across));
  const S course = atan2(sum_of_products(n.y, closing, n.x, across),
                         difference_of_products(n.x, closing, n.y, across));
  return distance / (closing - away) + abs(wrap_pi(course - way.psi)) / way.turning;
}

/// A matching of boats and slots with no time above a limit, grown boat by boat.
template <class S>
class Matching {
 public:
  Matching(const ArrivalTable<S>& T, std::size_t n) : T_(T), n_(n) {}

  /// Whether every boat has a slot within the limit.
  bool within(S limit) {
    boat_of_.fill(kNobody);
    for (std::size_t boat = 0; boat < n_; ++boat) {
      std::array<bool, kMostSlots> tried{};
      if (!place(boat, limit, tried)) return false;
    }
    return true;
  }

  Assignment slots() const {
    Assignment out{};
    for (std::size_t slot = 0; slot < n_; ++slot) {
      out[boat_of_[slot]] = static_cast<std::uint8_t>(slot);
    }
    return out;
  }

 private:
  static constexpr std::uint8_t kNobody = 255;

  /// Finds the boat a slot, if need be by moving others; at most n_ deep, as no slot is tried twice.
  bool place(std::size_t boat, S limit, std::array<bool, kMostSlots>& tried) {
    for (std::size_t slot = 0; slot < n_; ++slot) {
      if (tried[slot] || limit < T_[boat][slot]) continue;
      tried[slot] = true;
      if (boat_of_[slot] == kNobody || place(boat_of_[slot], limit, tried)) {
        boat_of_[slot] = static_cast<std::uint8_t>(boat);
        return true;
      }
    }
    return false;
  }

  const ArrivalTable<S>& T_;
  std::size_t n_;
  std::array<std::uint8_t, kMostSlots> boat_of_{};
};

/// The assignment of n ≤ kMostSlots boats to as many slots, and the time of the last to arrive.
template <class S>
struct Assigned {
  Assignment slots{};
  S last{};
};

template <class S>
Assigned<S> assign(const ArrivalTable<S>& T, std::size_t n) {
  std::array<S, kMostSlots * kMostSlots> times{};
  std::size_t count = 0;
  for (std::size_t boat = 0; boat < n; ++boat) {
    for (std::size_t slot = 0; slot < n; ++slot) times[count++] = T[boat][slot];
  }
  std::sort(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(count));
  Matching<S> matching(T, n);
  std::size_t low = 0, high = count;  // the answer's place is in [low, high)
  while (high - low > 1) {
    const std::size_t half = low + (high - low - 1) / 2;
    (matching.within(times[half]) ? high : low) = half + 1;
  }
  if (count == 0) return {};
  matching.within(times[low]);
  return {matching.slots(), times[low]};
}

}  // namespace flotilla::core
