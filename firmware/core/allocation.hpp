// SPDX-License-Identifier: MIT
// Allocates a wrench to the two propellers; at a limit, yaw has priority over surge ahead.
//
//   D = clamp(N / 2a, ±D_max)         m = clamp(X / 2, −R + |D|, F − |D|)
//   T_port = m + D                    T_stbd = m − D
//   X_given = T_port + T_stbd         N_given = a (T_port − T_stbd)
//   D_max = (F + R)/2; a boat that brakes as it turns: clamp(R + X/2, R/2, (F + R)/2)
//
//  symbol  meaning                                        unit   tested range
//  a       half the distance between the propellers       m      0.05 … 5
//  F, R    forward and reverse maximum of one propeller   N      0.1 … 500
//  X, N    wrench, positive ahead and to starboard        N, N m ±10 000
//
// Not in paper, which assumes unlimited thrust. A turn with full thrust also drives the boat ahead,
// with F − R. A boat that must brake as it turns would then overshoot its slot or hit another boat,
// so its turn is limited; but half of the reverse thrust is always reserved for the turn.
//
// Q16.16: tested within ±1,000 (F + R, N)
#pragma once

#include "core/scalar/scalar.hpp"
#include "core/types.hpp"

namespace flotilla::core {

template <class S>
struct AllocationParams {
  S a{};
  S F{};
  S R{};
  bool brakes = false;  ///< limits the turn, so that the boat can brake as it turns
};

template <class S>
struct Thrust {
  S port{};
  S stbd{};
};

template <class S>
struct Allocation {
  Thrust<S> thrust{};
  Tau<S> given{};
  Tau<S> missing{};   ///< asked − given
  Limits limits = 0;  ///< kSurgeLimit, kYawLimit
};

template <class S>
Tau<S> wrench_of(const AllocationParams<S>& params, const Thrust<S>& thrust) {
  return {thrust.port + thrust.stbd, params.a * (thrust.port - thrust.stbd)};
}

template <class S>
Allocation<S> allocate(const AllocationParams<S>& params, const Tau<S>& tau) {
  const S D_asked = tau.N / (S(2) * params.a);
  const S m_asked = S(0.5) * tau.X;
  const S D_all = S(0.5) * (params.F + params.R);
  const S D_max = params.brakes ? clamp(params.R + m_asked, S(0.5) * params.R, D_all) : D_all;
  const S D = clamp(D_asked, -D_max, D_max);
  const S m = clamp(m_asked, abs(D) - params.R, params.F - abs(D));
  Allocation<S> out;
  // m ± D may exceed a limit by rounding: clamp again.
  out.thrust = {clamp(m + D, -params.R, params.F), clamp(m - D, -params.R, params.F)};
  out.given = wrench_of(params, out.thrust);
  out.missing = {tau.X - out.given.X, tau.N - out.given.N};
  if (m < m_asked || m_asked < m) out.limits |= kSurgeLimit;
  if (D < D_asked || D_asked < D) out.limits |= kYawLimit;
  return out;
}

}  // namespace flotilla::core
