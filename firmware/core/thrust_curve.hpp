// SPDX-License-Identifier: MIT
// One propeller: thrust from command and command from thrust, each direction with its own maximum.
//
//   T / T_max = (1 − ε) c + ε c |c|            T_max = F ahead, R astern
//   c = ± 2 t / ((1 − ε) + √((1 − ε)² + 4 ε t)),  t = |T| / T_max         the exact inverse
//
//  symbol   meaning                              unit  tested range
//  c        command                              1     −1 … 1
//  T        thrust                               N     −R … F
//  epsilon  0 linear … 1 quadratic               1     0 … 1
//  dead     a smaller thrust is not asked for    N     0 … F
//
// Not in paper. The inverse is written with the root in the denominator: it needs no case for ε =
// 0.
#pragma once

#include "core/scalar.hpp"

namespace flotilla::core {

template <class S>
struct ThrustCurveParams {
  S F{};
  S R{};
  S epsilon{};
  S dead{};
};

/// N, from a command in [−1, 1].
template <class S>
S thrust_from_command(const ThrustCurveParams<S>& params, S c) {
  const S T_max = c < S(0) ? params.R : params.F;
  return T_max * ((S(1) - params.epsilon) * c + params.epsilon * c * abs(c));
}

/// Command in [−1, 1] that gives a thrust in [−R, F]; beyond that ±1.
template <class S>
S command_from_thrust(const ThrustCurveParams<S>& params, S T) {
  const bool astern = T < S(0);
  const S t = smaller(abs(T) / (astern ? params.R : params.F), S(1));
  if (abs(T) < params.dead || t <= S(0)) return S(0);
  const S linear = S(1) - params.epsilon;
  const S root = sqrt(linear * linear + S(4) * params.epsilon * t);
  const S c = smaller(S(2) * t / (linear + root), S(1));  // rounding may exceed 1 at t = 1
  return astern ? -c : c;
}

/// The command after dt seconds on its way to `wanted`; rate in full scale per second, 0 = no
/// limit.
template <class S>
S limit_slew(S previous, S wanted, S rate, S dt) {
  if (!(S(0) < rate)) return wanted;
  return clamp(wanted, previous - rate * dt, previous + rate * dt);
}

}  // namespace flotilla::core
