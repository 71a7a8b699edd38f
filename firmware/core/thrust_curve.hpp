// SPDX-License-Identifier: MIT
// One propeller: thrust from command and command from thrust, each direction with its own maximum.
//
//   T / T_max = (1 − ε) c + ε c |c|            T_max = F ahead, R astern; here c = −1 … 1
//   c = ± 2 t / ((1 − ε) + √((1 − ε)² + 4 ε t)),  t = |T| / T_max         the exact inverse
//
//  symbol   meaning                              unit  tested range
//  c        command, −full … full; full in ESC counts preserves the resolution of T
//  T        thrust                               N     −R … F
//  epsilon  0 linear … 1 quadratic               1     0 … 1
//  dead     a smaller |T| gives command 0        N     0 … F
//
// Not in paper. The inverse has the root in its denominator, so that ε = 0 needs no special case.
//
// Q16.16: tested within ±8,192 (commands in a propeller's counts)
#pragma once

#include "core/scalar/scalar.hpp"

namespace flotilla::core {

template <class S>
struct ThrustCurveParams {
  S F{};
  S R{};
  S epsilon{};
  S dead{};
  S full = S(1);
};

/// Thrust, N, of a command within ±full.
template <class S>
S thrust_from_command(const ThrustCurveParams<S>& params, S c) {
  const S T_max = c < S(0) ? params.R : params.F;
  return scaled(T_max, c, params.full) *
         (S(1) - params.epsilon + params.epsilon * abs(c / params.full));
}

/// Command that gives a thrust in [−R, F]; beyond that ±full.
template <class S>
S command_from_thrust(const ThrustCurveParams<S>& params, S T) {
  const bool astern = T < S(0);
  const S T_max = astern ? params.R : params.F;
  const S t = min(abs(T) / T_max, S(1));
  if (abs(T) < params.dead || t <= S(0)) return S(0);
  const S linear = S(1) - params.epsilon;
  const S root = sqrt(linear * linear + S(4) * params.epsilon * t);
  const S most = scaled(params.full, min(abs(T), T_max), T_max);
  const S c =
      min(most / (S(0.5) * (linear + root)), params.full);  // rounding may exceed it at t = 1
  return astern ? -c : c;
}

/// Slew rate limit: the command after dt seconds; rate in full scale per second, 0: no limit.
template <class S>
S limit_slew(S previous, S desired, S rate, S dt, S full = S(1)) {
  if (!(S(0) < rate)) return desired;
  const S half = S(0.5) * full * min(rate * dt, S(2));
  const S way = S(0.5) * desired - S(0.5) * previous;  // halves: the difference may be 2 full
  if (abs(way) <= half) return desired;
  return way < S(0) ? previous - half - half : previous + half + half;
}

}  // namespace flotilla::core
