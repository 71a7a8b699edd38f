// SPDX-License-Identifier: MIT
// The bow's angle towards the slot's course: what closes the lateral error where nothing turns.
//
//   [e_s e_c]ᵀ = R(e_ψ) [e_x e_y]ᵀ          behind and beside the slot, along its heading
//   θ = −σ e_c / Q,   Q = √(Δ² + e_s² + e_c²),   σ = U |U| / (U² + ε²)
//   θ̇, θ̈ from  ė_s = u cos e_ψ − v sin e_ψ − u_S + r_S e_c
//              ė_c = u sin e_ψ + v cos e_ψ − v_S − r_S e_s,   ë_c ≈ U cos e_ψ ė_ψ
//
//  symbol  meaning                                         unit   tested range
//  Δ       look-ahead; 0: no such angle                    m      0.1 … 100
//  θ       wanted turn of the bow from the slot's heading  rad    ±1
//  U       speed through the water that a turned bow leads aside  m/s
//  ε       speed under which it fades out                  m/s
//
// U is the least of the slot's speed through the water, the same with the unknown force taken for a
// current along the bow, which cannot be told from one, and the speed that is wanted; 0 where they
// disagree about ahead and astern. σ̇ is left out: it is small, and full of noise.
//
// Not in paper, which has no feedback of e_y: it needs a leader that keeps turning. Seen from far
// behind, the bow points at the slot; a slot that stands still is not circled, U is zero there.
//
// Q16.16: tested within ±200 (unknown force over d11, m/s)
#pragma once

#include "core/formation_error.hpp"

namespace flotilla::core {

template <class S>
struct LineOfSightParams {
  S Delta{};
  S epsilon = S(0.15);
};

template <class S>
struct LineOfSight {
  S theta{};
  S theta_dot{};
  S theta_ddot{};
};

/// The one that is nearer to zero; 0 where they disagree about their sign.
template <class S>
S agreed(S a, S b) {
  if (S(0) < a && S(0) < b) return smaller(a, b);
  if (a < S(0) && b < S(0)) return larger(a, b);
  return S(0);
}

/// U; u_star: the speed that is wanted, through the water.
template <class S>
S steering_speed(const Vessel<S>& m, const Slot<S>& slot, const Tau<S>& unknown, S u_star) {
  return agreed(agreed(slot.pace, slot.pace - unknown.X / m.d11), u_star);
}

template <class S>
LineOfSight<S> line_of_sight(const LineOfSightParams<S>& params, const Nu<S>& nu,
                             const Slot<S>& slot, const FormationError<S>& error, S U) {
  if (!(S(0) < params.Delta)) return {};
  const auto [e_s, e_c] = to_north_east(error.R_e, Vec2<S>{error.e.x, error.e.y});
  const Vec2<S> v = to_north_east(error.R_e, Vec2<S>{nu.u, nu.v});
  const S e_s_dot = v.x - slot.nu.u + slot.nu.r * e_c;
  const S e_c_dot = v.y - slot.nu.v - slot.nu.r * e_s;
  const S Q = hypot(params.Delta, e_s, e_c);
  const S sigma = U * abs(U) / (U * U + params.epsilon * params.epsilon);
  const S ratio = e_c / Q;
  const S ratio_dot = (e_c_dot - ratio * (e_s / Q * e_s_dot + ratio * e_c_dot)) / Q;
  const S steepness = (S(1) - ratio * ratio) / Q;
  return {-sigma * ratio, -sigma * ratio_dot,
          -sigma * steepness * U * error.R_e.c * error.e_dot.psi};
}

}  // namespace flotilla::core
