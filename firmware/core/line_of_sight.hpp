// SPDX-License-Identifier: MIT
// Line of sight: turns the bow towards the slot's course, to close the lateral error.
//
//   [e_s e_c]ᵀ = R(e_ψ) [e_x e_y]ᵀ          offset from the slot, along and across its heading
//   θ = −σ e_c / Q,   Q = √(Δ² + e_s² + e_c²),   σ = U |U| / (U² + ε²)
//   θ̇, θ̈ from  ė_s = u cos e_ψ − v sin e_ψ − u_S + r_S e_c
//              ė_c = u sin e_ψ + v cos e_ψ − v_S − r_S e_s,   ë_c ≈ U cos e_ψ ė_ψ
//
//  symbol  meaning                                         unit   tested range
//  Δ       look-ahead; 0: off                              m      0.1 … 100
//  θ       desired turn of the bow from slot's heading     rad    ±1
//  U       speed through the water, see below              m/s
//  ε       speed below which θ fades out                   m/s
//
// U is the smaller of the slot's speed and the desired speed, both through the water; 0 where one
// is ahead and the other astern. U counts a current, which the sway reveals, but not the unknown
// force: a tail wind pushes like a following current, but in it a turned bow still moves the boat
// sideways. σ̇ is omitted: it is small and noisy.
//
// Not in paper, which has no feedback of e_y and so needs a leader that keeps turning. From far
// behind, the bow points at the slot; the boat does not circle a slot at rest, since U is zero.
//
// Q16.16: tested within ±500 (distances from the slot, m)
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

/// U: of two speeds the one nearer to zero; 0 where their signs differ.
template <class S>
S smaller_of_same_sign(S a, S b) {
  if (S(0) < a && S(0) < b) return min(a, b);
  if (a < S(0) && b < S(0)) return max(a, b);
  return S(0);
}

/// The boat's offset from its slot along and across the slot's heading, and its rate.
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
