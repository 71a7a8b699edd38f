// SPDX-License-Identifier: MIT
// The wrench that the sticks command, and the thrust of one propeller in a motor test.
//
//   X = 2 F s (2 R s astern)          N = a (F + R) n
//   T = F q   (R q astern)            of the tested propeller; the other stands still
//
//  symbol  meaning                                                   unit  tested range
//  s, n    sticks: surge ahead, yaw to starboard; clamped to ±1      1     ±10
//  q       share of the propeller's maximum; clamped to ±q_max       1     ±10
//  a, F, R, X, N, T                                      as in allocation.hpp
//
// Not in paper, which has no operator. A full stick commands the maximum of that axis alone;
// allocate() gives what fits, as for the law: less yaw, where the boat brakes as it turns.
//
// Q16.16: tested within ±5,000 (N, N m, at the greatest a, F, R; no scenario has an operator)
#pragma once

#include <cstdint>

#include "core/allocation.hpp"
#include "core/scalar/scalar.hpp"

namespace flotilla::core {

enum class Propeller : std::uint8_t { kPort, kStbd };

/// q_max: enough to see which way a propeller turns, too little to tear a boat from its mooring.
template <class S>
inline const S kTestShareMost = S(0.2);

template <class S>
Tau<S> stick_wrench(const AllocationParams<S>& params, S surge, S yaw) {
  const S s = clamp(surge, S(-1), S(1));
  const S n = clamp(yaw, S(-1), S(1));
  const S T_max = s < S(0) ? params.R : params.F;
  return {S(2) * T_max * s, params.a * (params.F + params.R) * n};
}

template <class S>
Thrust<S> test_thrust(const AllocationParams<S>& params, Propeller propeller, S share) {
  const S q = clamp(share, -kTestShareMost<S>, kTestShareMost<S>);
  const S T = (q < S(0) ? params.R : params.F) * q;
  return propeller == Propeller::kPort ? Thrust<S>{T, S(0)} : Thrust<S>{S(0), T};
}

}  // namespace flotilla::core
