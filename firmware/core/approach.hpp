// SPDX-License-Identifier: MIT
// Approach: steers the boat to a slot that it cannot follow, because the slot is at rest or too
// fast, or that it reaches sooner on its own course.
//
//   w = ŵ_S − k_x [e_s e_c]ᵀ        ŵ_S: [u_S v_S]ᵀ; |ŵ_S|, |w| ≤ u_max
//   q = w − c − p                   w through the water, and against the push
//   θ = arg q, or arg q + π stern first
//   θ̇ = (q × q̇) / (|q| k_x max(|e|, Δ)),  q̇ ≈ −k_x [ė_s ė_c]ᵀ
//   u* = n·ŵ_S − k_x e_x            n: the bow, in the slot's axes
//   p₊ = p + 0.1 h (w_X n − p)      where the slot is at rest: |w_S| < ½ ε, then ε
//   w_X = min(max(|X| − X_n, 0)/D, 1 m/s), the sign that of X, D = d11 + d11q |p|
//
//   begins where |q_s| < ε or |w_S| > u_max, and k_x |e| + d > 1.5 k_x Δ    d = |ŵ_S − c − p|
//   ends   where |q_s| > 1.5 ε and |w_S| < 0.95 u_max, or |e| < 0.15 Δ and d < 0.2 ε
//   also while a slot at rest is stern to the drift: [c + p]_s > ½ ε
//   and while |e| > 6 Δ, then 3 Δ, and |θ| > 1, then 0.8, bow first
//   bow first at a slot at rest from k_x |e| < ½ d until k_x |e| > k_x Δ + 3 d
//
//  symbol    meaning                                            frame  unit   tested range
//  e_s, e_c  offset from the slot along and across its heading  slot   m      ±1000
//  w_S, q_s  slot's velocity over ground, speed through the water      m/s    ±20
//  c, p      current; push along the bow beyond it, if against  slot   m/s    ±2, ±1
//  X         wrench that neither model nor propellers hold      body   N      ±1000
//  X_n, D    force that the propellers' neutral band may hide; damping N, kg/s 0 … 50
//  Δ, ε      look-ahead, slot's speed below which it has no course     m, m/s  0: never; 0.15
//  θ         turn of the bow from the slot's heading                   rad    ±π
//
// Not in paper, where a boat abeam of a slot at rest stays there: u* = −k_x e_x is zero. Bow or
// stern points to the slot; the boat changes between them where that makes the turn smaller by 0.8
// rad. An approach begins outside 1.5 Δ and ends within 0.15 Δ, where the boat turns to its slot's
// heading. A boat cannot hold its place with a current abeam: near a slot at rest it points its bow
// into the current or push. A push from straight astern shows in X alone, because c is learnt from
// the sway; so does a propeller that stands still at a small command, hence X_n. The boat follows a
// slot that is too fast, and closes up as far as u_max allows. A line of sight turns the bow by 1
// rad at the most: a boat abeam of its slot, or ahead, would wait there at the slot's own speed.
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
  S X_n{};
};

template <class S>
struct ApproachState {
  bool on = false;
  bool astern = false;  ///< stern first
  bool waits = false;   ///< near a slot at rest: bow first
  Vec2<S> push_n{};     ///< p
  Carry<S> north_rest{}, east_rest{};
};

/// Desired motion, in the slot's axes.
template <class S>
struct SlotWay {
  Vec2<S> slot{};  ///< ŵ_S
  Vec2<S> off{};   ///< ŵ_S − c − p
  S drift{};       ///< |ŵ_S − c − p|
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
  const Vec2<S> off = {slot_w.x - c.x, slot_w.y - c.y};
  return {slot_w,
          off,
          hypot(off.x, off.y),
          hypot(closing.x, closing.y),
          {w.x - c.x, w.y - c.y},
          {-params.k_x * e_dot.x, -params.k_x * e_dot.y}};
}

/// Whether the slot is at rest; on: the boat approaches (hysteresis).
template <class S>
bool rests(const ApproachParams<S>& params, const Slot<S>& slot, bool on) {
  if (!(S(0) < params.k_x * params.Delta)) return false;
  return is_shorter(Vec2<S>{slot.nu.u, slot.nu.v}, on ? params.epsilon : S(0.5) * params.epsilon);
}

/// Advances p by h seconds; slow, so that waves do not turn the boat.
template <class S>
void push_forward(const ApproachParams<S>& params, const Vessel<S>& m, ApproachState<S>& state,
                  const ControllerInput<S>& in, const Slot<S>& slot, S h) {
  if (!rests(params, slot, state.on)) {
    state.push_n = {};
    return;
  }
  const S D = surge_damping(m, hypot(state.push_n.x, state.push_n.y));
  const S w = quotient_of(clamp(abs(in.unknown.X) - params.X_n, S(0), D), D);
  const Vec2<S> push = to_north_east(in.psi, Vec2<S>{in.unknown.X < S(0) ? -w : w, S(0)});
  const S share = S(0.1) * h;
  state.push_n = {state.push_n.x + state.north_rest.take(share, push.x - state.push_n.x),
                  state.push_n.y + state.east_rest.take(share, push.y - state.push_n.y)};
}

/// c + p; c alone where p is small, or where c and p have about the same direction, so that a gust
/// does not weaken the cross-track term.
template <class S>
Vec2<S> pushed(const ApproachParams<S>& params, const Vec2<S>& c, const Vec2<S>& p) {
  const S least = S(0.8) * params.epsilon;
  const bool together = S(0) < sum_of_products(c.x, p.x, c.y, p.y) && least < hypot(c.x, c.y);
  return together || hypot(p.x, p.y) < least ? c : Vec2<S>{c.x + p.x, c.y + p.y};
}

/// Whether the slot is at rest, stern to the drift.
template <class S>
bool lies_astern(const ApproachParams<S>& params, const Slot<S>& slot, const SlotWay<S>& way,
                 bool on) {
  return rests(params, slot, on) && way.off.x < S(-0.5) * params.epsilon;
}

/// Whether the slot has no course or is faster than u_max; on: the boat approaches (hysteresis).
template <class S>
bool cannot_be_sailed(const ApproachParams<S>& params, const Slot<S>& slot, bool on) {
  if (!(S(0) < params.k_x * params.Delta)) return false;
  if (abs(slot.pace) < (on ? S(1.5) * params.epsilon : params.epsilon)) return true;
  const S most = on ? S(0.95) * params.u_max : params.u_max;
  return S(0) < most && is_longer(Vec2<S>{slot.nu.u, slot.nu.v}, most);
}

/// Whether the slot is far enough for an approach, if not stern to the drift; on: as above.
template <class S>
bool is_off(const ApproachParams<S>& params, const SlotWay<S>& way, bool on) {
  const S near = params.k_x * params.Delta;
  if (!on) return S(1.5) * near < way.closing + way.drift;
  return S(0.15) * near < way.closing || S(0.2) * params.epsilon < way.drift;
}

/// Whether the boat is far from a slot that makes way, and the direction to the slot differs from
/// the slot's course by more than a line of sight can turn the bow; on: as above.
template <class S>
bool lies_abeam(const ApproachParams<S>& params, const SlotWay<S>& way, bool on) {
  const S far = (on ? S(3) : S(6)) * params.k_x * params.Delta;
  return S(0) < far && far < way.closing && way.q.x < (on ? S(0.97) : S(0.64)) * abs(way.q.y);
}

/// Whether the boat is so near a slot at rest that its bow points upstream; waits: it already
/// points upstream.
template <class S>
bool points_upstream(const ApproachParams<S>& params, const SlotWay<S>& way, bool waits) {
  const bool at_rest = hypot(way.slot.x, way.slot.y) < params.epsilon;
  if (!at_rest || !(S(0.2) * params.epsilon < way.drift)) return false;
  return way.closing < (waits ? params.k_x * params.Delta + S(3) * way.drift : S(0.5) * way.drift);
}

/// θ and θ̇. Changes ends with hysteresis; keeps the heading where q is too small for a direction.
template <class S>
LineOfSight<S> sight_of_way(const ApproachParams<S>& params, ApproachState<S>& state,
                            const SlotWay<S>& way, S e_psi, S r_S, bool may_back) {
  const S speed = hypot(way.q.x, way.q.y);
  if (!(S(0.2) * params.epsilon < speed)) return {e_psi, -r_S, S(0)};
  const S pi = S(3.14159265358979323846);
  S theta = atan2(way.q.y, way.q.x);
  state.waits = points_upstream(params, way, state.waits);
  const bool backs = may_back && !state.waits;
  state.astern = state.astern && backs;
  if (state.astern) theta = wrap_pi(theta + pi);
  if (backs && S(0.5) * pi + S(0.4) < abs(theta)) {
    state.astern = !state.astern;
    theta = wrap_pi(theta + pi);
  }
  const Vec2<S> n = {way.q.x / speed, way.q.y / speed};
  return {theta,
          (n.x * way.q_dot.y - n.y * way.q_dot.x) / max(way.closing, params.k_x * params.Delta),
          S(0)};
}

}  // namespace flotilla::core
