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
// U is the smaller of the slot's speed through the water and the speed that is wanted; 0 where they
// disagree about ahead and astern. An unknown force is no part of it: a tail wind pushes like a
// following current, but a bow that is turned before the wind leads aside all the same. Of a current,
// sway tells. σ̇ is left out: it is small, and full of noise.
//
// Not in paper, which has no feedback of e_y: it needs a leader that keeps turning. Seen from far
// behind, the bow points at the slot; a slot that stands still is not circled, U is zero there.
//
// Q16.16: tested within ±200 (distances from the slot, m)
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

/// U, of the slot's pace and of the speed that is wanted, through the water: the one that is nearer
/// to zero; 0 where they disagree about their sign.
template <class S>
S agreed(S a, S b) {
  if (S(0) < a && S(0) < b) return min(a, b);
  if (a < S(0) && b < S(0)) return max(a, b);
  return S(0);
}

/// Where the boat is, seen from its slot, along and across the slot's heading, with the rates.
template <class S>
struct BesideSlot {
  Vec2<S> e{};
  Vec2<S> e_dot{};
};

template <class S>
BesideSlot<S> beside_slot(const Slot<S>& slot, const FormationError<S>& error, const Nu<S>& nu) {
  const Vec2<S> e = to_north_east(error.R_e, Vec2<S>{error.e.x, error.e.y});
  const Vec2<S> v = to_north_east(error.R_e, Vec2<S>{nu.u, nu.v});
  return {e, {v.x - slot.nu.u + slot.nu.r * e.y, v.y - slot.nu.v - slot.nu.r * e.x}};
}

template <class S>
LineOfSight<S> line_of_sight(const LineOfSightParams<S>& params, const Nu<S>& nu,
                             const Slot<S>& slot, const FormationError<S>& error, S U) {
  if (!(S(0) < params.Delta)) return {};
  const auto [e, e_dot] = beside_slot(slot, error, nu);
  const auto& [e_s, e_c] = e;
  const auto& [e_s_dot, e_c_dot] = e_dot;
  const S Q = hypot(params.Delta, e_s, e_c);
  const S sigma = U * abs(U) / (U * U + params.epsilon * params.epsilon);
  const S ratio = e_c / Q;
  const S ratio_dot = (e_c_dot - ratio * (e_s / Q * e_s_dot + ratio * e_c_dot)) / Q;
  const S steepness = (S(1) - ratio * ratio) / Q;
  return {-sigma * ratio, -sigma * ratio_dot,
          -sigma * steepness * U * error.R_e.c * error.e_dot.psi};
}

}  // namespace flotilla::core
