// SPDX-License-Identifier: MIT
// Approach: steers the boat to a slot that it cannot follow, as the slot is at rest or too fast.
//
//   w = ŵ_S − k_x [e_s e_c]ᵀ        ŵ_S: [u_S v_S]ᵀ; |ŵ_S|, |w| ≤ u_max
//   q = w − c                       w through the water
//   θ = arg q, or arg q + π stern first
//   θ̇ = (q × q̇) / (|q| k_x max(|e|, Δ)),  q̇ ≈ −k_x [ė_s ė_c]ᵀ
//   u* = n·ŵ_S − k_x e_x            n: the bow, in the slot's axes
//
//   begins where |q_s| < ε or |w_S| > u_max, and k_x |e| + |ŵ_S − c| > 1.5 k_x Δ
//   ends   where |q_s| > 1.5 ε and |w_S| < 0.95 u_max, or |e| < 0.15 Δ and |ŵ_S − c| < 0.2 ε
//
//  symbol    meaning                                            frame  unit   tested range
//  e_s, e_c  offset from the slot along and across its heading  slot   m      ±1000
//  w_S, q_s  slot's velocity over ground, speed through the water      m/s    ±20
//  c         current                                            slot   m/s    ±2
//  Δ, ε      look-ahead, slot's speed below which it has no course     m, m/s  0: never; 0.15
//  θ         turn of the bow from the slot's heading                   rad    ±π
//
// Not in paper, where a boat abeam of a slot at rest stays there: u* = −k_x e_x is zero. Bow or
// stern points to the slot; the boat changes ends where that makes the turn smaller by 0.8 rad. An
// approach begins outside 1.5 Δ and ends within 0.15 Δ, where the boat turns to its slot's heading.
// The boat heads into or along a known current, since it cannot hold its place with the current
// abeam. It follows a slot that is too fast, and closes up as far as u_max allows.
//
// Q16.16: tested within ±2,000 (closing speed, m/s)
#pragma once

#include "core/virtual_velocity.hpp"

namespace flotilla::core {

template <class S>
struct ApproachParams {
  S k_x{};
  S Delta{};
  S epsilon{};
  S u_max{};
};

struct ApproachState {
  bool on = false;
  bool astern = false;  ///< stern first
};

/// Desired motion, in the slot's axes.
template <class S>
struct SlotWay {
  Vec2<S> slot{};  ///< ŵ_S
  S drift{};       ///< |ŵ_S − c|
  S closing{};     ///< k_x |e|
  Vec2<S> q{};
  Vec2<S> q_dot{};
};

template <class S>
SlotWay<S> slot_way(const ApproachParams<S>& params, const Slot<S>& slot,
                    const FormationError<S>& error, const Nu<S>& nu, const Vec2<S>& c_b) {
  const auto [e, e_dot] = beside_slot(slot, error, nu);
  const Vec2<S> closing = {-params.k_x * e.x, -params.k_x * e.y};
  const Vec2<S> slot_w = shortened(Vec2<S>{slot.nu.u, slot.nu.v}, params.u_max);
  const Vec2<S> w = shortened(Vec2<S>{slot_w.x + closing.x, slot_w.y + closing.y}, params.u_max);
  const Vec2<S> c = to_north_east(error.R_e, c_b);
  return {slot_w,
          hypot(slot_w.x - c.x, slot_w.y - c.y),
          hypot(closing.x, closing.y),
          {w.x - c.x, w.y - c.y},
          {-params.k_x * e_dot.x, -params.k_x * e_dot.y}};
}

/// Whether the slot has no course or is faster than u_max; on: the boat approaches (hysteresis).
template <class S>
bool cannot_be_sailed(const ApproachParams<S>& params, const Slot<S>& slot, bool on) {
  if (!(S(0) < params.k_x * params.Delta)) return false;
  if (abs(slot.pace) < (on ? S(1.5) * params.epsilon : params.epsilon)) return true;
  const S most = on ? S(0.95) * params.u_max : params.u_max;
  return S(0) < most && most < hypot(slot.nu.u, slot.nu.v);
}

/// Whether the slot is far enough for an approach; on: as above.
template <class S>
bool is_off(const ApproachParams<S>& params, const SlotWay<S>& way, bool on) {
  const S near = params.k_x * params.Delta;
  if (!on) return S(1.5) * near < way.closing + way.drift;
  return S(0.15) * near < way.closing || S(0.2) * params.epsilon < way.drift;
}

/// θ and θ̇. Changes ends with hysteresis; keeps the heading where q is too small for a direction.
template <class S>
LineOfSight<S> sight_of_way(const ApproachParams<S>& params, ApproachState& state,
                            const SlotWay<S>& way, S e_psi, S r_S) {
  const S speed = hypot(way.q.x, way.q.y);
  if (!(S(0.2) * params.epsilon < speed)) return {e_psi, -r_S, S(0)};
  const S pi = S(3.14159265358979323846);
  S theta = atan2(way.q.y, way.q.x);
  if (state.astern) theta = wrap_pi(theta + pi);
  if (S(0.5) * pi + S(0.4) < abs(theta)) {
    state.astern = !state.astern;
    theta = wrap_pi(theta + pi);
  }
  const Vec2<S> n = {way.q.x / speed, way.q.y / speed};
  return {theta,
          (n.x * way.q_dot.y - n.y * way.q_dot.x) / max(way.closing, params.k_x * params.Delta),
          S(0)};
}

}  // namespace flotilla::core
