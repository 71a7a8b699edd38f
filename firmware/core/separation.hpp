// SPDX-License-Identifier: MIT
// Keeps clear of other vessels: a barrier over the boat's turning circles (core/clearance.hpp).
//
//   D(w) < D for a vessel with right of way, for w: straight to the slot, or desired now, which a
//            turning boat keeps for a quarter circle at most: t ≤ π/2|r*|
//           ⇒ w ← argmin of |w − w_e| over all w with h(w) ≥ 0; if there is none, argmax of h(w)
//             over w = 0, w_0, w_S, the last choice and 16 courses at U and at U/2
//             a w on a closed course only if no other has h(w) ≥ 0; there, h is D_min less
//   w_e    = w_S − R(k_t τ) e / T_e                                  aim: in the slot within T_e
//   u* n  ≤ L((|p| − m − k_h D_min)/2) + k_v max(0, vᵀ p/|p|)        n = cos of the bearing
//   L(g)   = √((a t_r)² + 2 a g) − a t_r, 0 for g ≤ 0                speed that stops within g
//
//  symbol         meaning                                       unit    tested range
//  h, D, p, …     see core/clearance.hpp
//  w_S, w_0       velocity of the slot; straight to the slot    m/s     ±5
//
// A choice that is clear of vessels of constant velocity stays clear for the rest of its horizon,
// which moves on with time: later there may be no clear choice, for example among vessels that
// close in from all sides. Of two boats one has right of way and the other makes room, so neither
// waits endlessly. A boat without progress turns its aim to starboard until it finds a way round,
// and accepts less clearance (T_n). After 2 s without progress while going astern behind a slot
// that makes way, it turns about, |δ| ≤ π, u_w = 0, to a course that is clear and open; if there is
// none, it continues as before.
//
// A course is closed if the boat cannot stop on it within its fence (app/plan/fence_watch.hpp).
//
// Among strangers the boat turns to port, or crosses ahead of one that comes from starboard or bow
// to bow, only if no other open course is clear or after k_p T without progress (COLREGs, rules 14,
// 15 and 17).
//
// The limit of u* applies to every boat, also with right of way. It aims at k_h D_min, but supposes
// that the boat follows u* within t_r; heavy boats and slow propellers come nearer (MAVLINK.md has
// figures). Slots must be farther apart than k_e D_min.
//
// Not in paper. Source of the idea: P. Fiorini, Z. Shiller, IJRR 17 (1998).
//
// Q16.16: tested within ±200 (other vessels' places, m)
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/clearance.hpp"
#include "core/virtual_velocity.hpp"

namespace flotilla::core {

template <class S>
struct Separation {
  bool yielding = false;  ///< ν* was changed
  bool known = false;     ///< at least one vessel is known
  S predicted{};          ///< least distance within the horizon under the unchanged ν*
};

/// A choice; the greater `rank` is better, then the smaller `cost`.
template <class S>
struct Choice {
  Vec2<S> w_n{};
  int rank = -1;  ///< 4: clear; 3: clear, but against rules; 2, 1: same, but closed; 0: not clear
  S cost{};
};

/// w_e.
template <class S>
Vec2<S> aim(const SeparationParams<S>& params, const SeparationState<S>& state,
            const Intent<S>& intent) {
  const Vec2<S> q = to_north_east(params.aside * state.stuck_s, intent.off_n);
  return {intent.slot_n.x + q.x / params.eager, intent.slot_n.y + q.y / params.eager};
}

/// Whether w lies within half a course of a closed one.
template <class S>
bool is_closed(std::uint16_t closed, const Vec2<S>& w) {
  if (closed == 0 || !(S(0) < length(w))) return false;
  const S apart = S(0.39269908169872414), half = S(0.5);  // π/8
  S angle = atan2(w.y, w.x) + half * apart;
  unsigned course = angle < S(0) ? kCourses - 1 : 0;
  for (angle = abs(angle); apart < angle; angle = angle - apart) {
    course = (course + (course < kCourses / 2 ? 1 : kCourses - 1)) % kCourses;
  }
  return (closed >> course & 1U) != 0;
}

/// Whether w leads from a vessel's port side across its course, ahead of it.
template <class S>
bool crosses_ahead(const OtherVessel<S>& other, const Vec2<S>& w) {
  const Vec2<S>&p = other.p_n, &v = other.v_n;
  const S slow = S(0.1);  // m/s; its course is uncertain
  return slow < length(v) && S(0) < cross(v, p) && S(0) < cross(v, w) &&
         cross(p, minus(w, v)) < S(0);
}

/// Whether w leads to port of the boat's way, or ahead of a stranger that passes from starboard or
/// bow to bow (COLREGs, rules 14, 15 and 17). The way: straight to the slot, or the slot's if that
/// leads back.
template <class S>
bool breaks_rules(const Traffic<S>& traffic, const Intent<S>& intent, const Vec2<S>& w) {
  const Vec2<S>& straight = intent.straight_n;
  const Vec2<S>& way = dot(straight, intent.slot_n) < S(0) ? intent.slot_n : straight;
  const S rounding = S(-0.02);  // (m/s)²; so that a course straight ahead is not "to port"
  bool breaks = cross(way, w) < rounding;
  for (std::size_t i = 0; i < traffic.count; ++i) {
    const OtherVessel<S>& other = traffic.vessels[i];
    breaks = breaks || (other.stranger && crosses_ahead(other, w));
  }
  return breaks;
}

template <class S>
Choice<S> choose(const SeparationParams<S>& params, const SeparationState<S>& state,
                 const SeparationInput<S>& in, bool stranger) {
  const Intent<S>& intent = in.intent;
  const Vec2<S> w_e = aim(params, state, intent);
  const bool by_rule = stranger && state.stuck_s < params.patience * params.horizon;
  Choice<S> best{};
  const std::uint16_t closed_courses = in.traffic.closed;
  const auto consider = [&](const Vec2<S>& w, S bonus) {
    const bool closed = is_closed(closed_courses, w);
    const S h = clearance(params, state, in, w) + bonus * params.least;
    const bool against = by_rule && breaks_rules(in.traffic, intent, w);
    const int rank = h < S(0) ? 0 : (closed ? 2 : 4) - (against ? 1 : 0);
    const S cost = rank == 0 ? (closed ? params.least : S(0)) - h
                             : length(minus(w, w_e)) - bonus * intent.fastest;
    if (best.rank < rank || (best.rank == rank && cost < best.cost)) best = {w, rank, cost};
  };
  consider(Vec2<S>{}, S(0));
  consider(intent.straight_n, S(0));
  consider(intent.slot_n, S(0));
  if (state.yielding) consider(state.w_n, stranger ? S(0) : params.same);
  const S c = S(0.92387953251128674), s = S(0.38268343236508977);  // cos, sin of π/8
  Vec2<S> course = {intent.fastest, S(0)};
  for (unsigned k = 0; k < kCourses; ++k) {
    consider(course, S(0));
    consider({S(0.5) * course.x, S(0.5) * course.y}, S(0));
    course = {c * course.x - s * course.y, s * course.x + c * course.y};
  }
  return best;
}

/// Whether a boat that sails with ν* must yield, also to a stranger, and the least predicted
/// distance.
template <class S>
struct Outlook {
  Separation<S> out{};
  bool stranger = false;
};

template <class S>
Outlook<S> foresee(const SeparationParams<S>& params, const SeparationState<S>& state,
                   const SeparationInput<S>& in, const Nu<S>& desired) {
  const Vec2<S> w = to_north_east(in.R, Vec2<S>{desired.u, S(0)});
  const S quarter = quarter_turn<S>(), r = abs(desired.r);
  const S horizon = quarter < params.horizon * r ? quarter / r : params.horizon;
  Outlook<S> seen;
  Separation<S>& out = seen.out;
  for (std::size_t i = 0; i < in.traffic.count; ++i) {
    const OtherVessel<S>& other = in.traffic.vessels[i];
    const S now = predicted_distance(horizon, other, w);
    out.predicted = out.known ? min(out.predicted, now) : now;
    out.known = true;
    const S straight = predicted_distance(params.horizon, other, in.intent.straight_n);
    const S room = room_for(params, state.stuck_s, other.stranger) +
                   (state.yielding ? params.end - params.yield : S(0));
    if (!other.has_way || !(min(now, straight) < to_keep(params, room, other))) continue;
    out.yielding = true;
    seen.stranger = seen.stranger || other.stranger;
  }
  return seen;
}

/// Advances τ while the boat yields, is off its slot, comes no nearer to it, and is slow relative
/// to it or yields to a stranger; else τ decreases at half that rate. After 60 s τ starts again
/// from 0. Slow is below U/4, and half of that counts as progress; all are chosen. If τ passes
/// astern_s while the boat goes astern behind a slot that moves, the boat turns about.
template <class S>
void count_stuck(const SeparationParams<S>& params, SeparationState<S>& state,
                 const SeparationInput<S>& in, bool stranger) {
  const Intent<S>& intent = in.intent;
  const S off = length(intent.off_n), slow = intent.fastest / S(4);
  const Vec2<S> q = minus(to_north_east(in.R, Vec2<S>{in.nu.u, in.nu.v}), intent.slot_n);
  const bool stuck = state.yielding && slow < off && (stranger || length(q) < slow) &&
                     dot(q, Vec2<S>{intent.off_n.x / off, intent.off_n.y / off}) < slow / S(2);
  const bool patient = !(params.astern_s < state.stuck_s);
  state.stuck_s = stuck ? state.stuck_s + in.dt : max(S(0), state.stuck_s - in.dt / S(2));
  const bool loses = in.nu.u < S(0) && !stranger && slow < length(intent.slot_n);
  const bool begins = loses && patient && params.astern_s < state.stuck_s;
  state.bow_first = state.yielding && (state.bow_first || begins);
  if (S(60) < state.stuck_s) state.stuck_s = S(0);
}

/// L(g): speed from which the boat stops within the gap.
template <class S>
S stopping_speed(S a, S reaction, S gap) {
  if (!(S(0) < gap)) return S(0);
  const S lag = a * reaction;
  return hypot(lag, sqrt(S(2) * a) * sqrt(gap)) - lag;
}

/// Limits u so that u* n stays within its bound for every vessel. Uses half of each gap: the other
/// half is left to that vessel.
template <class S>
S held_back(const SeparationParams<S>& params, const SeparationInput<S>& in, S u) {
  for (std::size_t i = 0; i < in.traffic.count; ++i) {
    const OtherVessel<S>& other = in.traffic.vessels[i];
    const S d = max(length(other.p_n), S(0.001));
    const S gap = S(0.5) * (d - other.margin - params.hold * params.least);
    const S receding = max(S(0), dot(other.v_n, Vec2<S>{other.p_n.x / d, other.p_n.y / d}));
    const S limit = stopping_speed(in.a, params.reaction, gap) + params.receding * receding;
    const S n = to_body(in.R, other.p_n).x / d;
    if (limit < u * n) u = limit / n;
  }
  return u;
}

/// Limits w_S and w_0 to U.
template <class S>
Intent<S> intent_of(const VirtualVelocityParams<S>& limits, const SeparationParams<S>& params,
                    const Vec2<S>& slot_n, const Vec2<S>& off_n) {
  const S fastest =
      S(0) < limits.u_max ? limits.u_max : max(params.least, params.faster * length(slot_n));
  const Vec2<S> to_slot_n = {slot_n.x + limits.k_x * off_n.x, slot_n.y + limits.k_x * off_n.y};
  return {shortened(slot_n, fastest), shortened(to_slot_n, fastest), off_n, fastest,
          S(0) < limits.r_max ? limits.r_max : params.any_rate};
}

/// Changes ν* where necessary.
template <class S>
Separation<S> separate(const SeparationParams<S>& params, SeparationState<S>& state,
                       const SeparationInput<S>& in, VirtualVelocity<S>& desired) {
  Nu<S>& nu = desired.nu_star;
  auto [out, stranger] = foresee(params, state, in, nu);
  const bool member = out.yielding && !stranger;
  state.left_s = member ? min(params.keep_on, state.stuck_s) : max(S(0), state.left_s - in.dt);
  out.yielding = out.yielding || (state.yielding && S(0) < state.left_s);
  if (out.yielding) {
    Choice<S> best = choose(params, state, in, stranger);
    if (state.bow_first && !(best.rank == 4 && S(0) < length(best.w_n))) {
      state.bow_first = false;
      best = choose(params, state, in, stranger);
    }
    state.w_n = best.w_n;
    const Way<S> way = way_to(in.R, state.w_n, state.bow_first);
    nu.u = way.u;
    nu.r = clamp(params.turning * way.delta, -in.intent.turning, in.intent.turning);
    desired.r_star_dot = S(0);
  }
  state.yielding = out.yielding;
  count_stuck(params, state, in, stranger);
  const S u = held_back(params, in, nu.u);
  out.yielding = out.yielding || u < nu.u || nu.u < u;
  nu.u = u;
  if (out.yielding) desired.u_star_dot = S(0);
  return out;
}

}  // namespace flotilla::core
