// SPDX-License-Identifier: MIT
// Keeps clear of other vessels: a barrier over the boat's turning circles.
//
//   s_w(t) = place while the boat changes to w, in five stretches at their mean velocities:
//            t_r               as now
//            |u_w − u| / 2a    its speed changes, u_w = ±|w| cos² δ
//            |δ|/r_m + t_s     turning circle, (u_w/r_m) [sin |δ|  ±(1 − cos δ)]ᵀ; its yaw rate has
//                              to change first, t_s = |r_w − r| / 2a_r, r_w = clamp(k_r δ, ±r_m)
//            (|w| − |u_w|)/2a  gathers way
//            until T           w
//   h(w)   = min over vessels and 0 ≤ t ≤ T of |p + v t − s_w(t)| − D_t
//   D_t    = min(m + D, |p| − ε); of a member m + D in the last stretch
//   T      = max(4 s, min(20 s, t_r + U/2a + π/2r_m + k_e D_min/U)): time to turn aside by a
//            quarter circle, gather way and make room; 4 s if U or r_m is 0
//   D(w)   = min over 0 ≤ t ≤ T of |p + (v − w) t| − m               predicted distance
//   D(w) < D for a vessel with right of way, for w: straight to the slot, or desired now, which a
//            turning boat keeps for a quarter circle at most: t ≤ π/2|r*|
//           ⇒ w ← argmin of |w − w_e| over all w with h(w) ≥ 0; if there is none, argmax of h(w)
//             over w = 0, w_0, w_S, the last choice and 16 courses at U and at U/2
//             a w on a closed course only if no other has h(w) ≥ 0; there, h is D_min less
//   w_e    = w_S − R(k_t τ) e / T_e                                  aim: in the slot within T_e
//   D      = D_min (k_y − (k_y − k_h) min(1, τ/T_n)), k_h D_min for a vessel without right of way
//   u* n  ≤ L((|p| − m − k_h D_min)/2) + k_v max(0, vᵀ p/|p|)        n = cos of the bearing
//   L(g)   = √((a t_r)² + 2 a g) − a t_r, 0 for g ≤ 0                speed that stops within g
//
//  symbol    meaning                                            unit    tested range
//  p, v, m   other vessel's place seen from us, velocity,       m, m/s, m  ±100, ±5, 0 … 5
//            and uncertainty of its place
//  D_min     distance to keep; 0: off                           m       0.5 … 20
//  V, u      own velocity, over ground and ahead                m/s
//  w, δ, u_w velocity; the turn to its course, bow or stern first, ±π/2; surge when that begins
//  r_m, U    LAW_R_MAX, LAW_U_MAX; if U is 0, max(D_min / 1 s, k_U |w_S|)   rad/s, m/s
//  w_S, w_0  velocity of the slot; straight to the slot         m/s
//  τ         time without progress towards the slot             s
//  a, t_r    half the full-astern deceleration; reaction time   m/s², s
//  a_r       yaw acceleration by the moment left while braking  rad/s²
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
// From a stranger the boat keeps (k_e − k_y) D_min more. It turns to port, or crosses ahead of one
// that comes from starboard or bow to bow, only if no other open course is clear or after k_p T
// without progress (COLREGs, rules 14, 15 and 17).
//
// The limit of u* applies to every boat, also with right of way. It aims at k_h D_min, but supposes
// that the boat follows u* within t_r; heavy boats and slow propellers come nearer (MAVLINK.md has
// figures). Slots must be farther apart than k_e D_min.
//
// Not in paper. Sources of the ideas: C. Lee, J. Park, J. Kim, arXiv 2504.19247 (turning circles);
// T. Paine et al., arXiv 2601.11335 (worst case); P. Fiorini, Z. Shiller, IJRR 17 (1998).
//
// Q16.16: tested within ±200 (other vessels' places, m)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/allocation.hpp"
#include "core/virtual_velocity.hpp"

namespace flotilla::core {

/// Another vessel at this instant.
template <class S>
struct OtherVessel {
  Vec2<S> p_n{};    ///< relative to us
  Vec2<S> v_n{};    ///< over ground
  S margin{};       ///< uncertainty of p_n, m
  bool has_way{};   ///< right of way: we yield
  bool stranger{};  ///< not a member: COLREGs apply
};

constexpr std::size_t kMaxVessels = 8;

/// Courses among which a yielding boat chooses, evenly spaced from north.
constexpr unsigned kCourses = 16;

template <class S>
struct Traffic {
  std::array<OtherVessel<S>, kMaxVessels> vessels{};
  std::size_t count = 0;
  std::uint16_t closed = 0;  ///< bit mask of closed courses; bit 0: north
};

/// These weights come neither from a formula nor from a search. Each is chosen by judgement;
/// tests.loop.encounters sails with all of them.
template <class S>
struct SeparationParams {
  S least{};            ///< D_min, m; 0: off
  S horizon = S(4);     ///< T, s; chosen: least value, enough for the paper's hull; horizon_of()
  S reaction = S(0.4);  ///< t_r, s; chosen: delay of messages and propellers

  // Distances, ratio to D_min.
  S hold = S(1.1);   ///< k_h; chosen: distance that approaches aim at, a margin over D_min
  S yield = S(1.4);  ///< k_y: yielding begins; chosen: above k_h, which leaves room to pass
  S end = S(1.5);    ///< k_e: yielding ends; chosen: above k_y, or it would begin again at once

  // Choice of w.
  S eager = S(1);      ///< T_e, s; chosen: short, so that a boat passes rather than waits
  S aside = S(0.3);    ///< k_t, rad/s; chosen: the aim turns by π within 10 s
  S same = S(0.1);     ///< hysteresis, ratio to U and D_min; chosen
  S nearer = S(0.05);  ///< ε, m; chosen: a clear w stays clear despite noise
  S turning = S(2);    ///< k_r, 1/s: ratio of r* to δ; chosen
  S any_rate = S(1);   ///< r_m where LAW_R_MAX is 0, rad/s; chosen
  S faster = S(1.1);   ///< k_U: ratio of U to the slot's speed; chosen: catches up with it

  // Progress towards the slot.
  S narrow = S(6);      ///< T_n, s; chosen
  S astern_s = S(2);    ///< τ from which a boat turns about, s; chosen, see tests.loop.shapes
  S patience = S(2.5);  ///< k_p: τ from which rules are broken, ratio to T; chosen

  // Limit of u*.
  S receding = S(0.8);  ///< k_v: assumed share of its receding speed; chosen
};

template <class S>
struct SeparationState {
  Vec2<S> w_n{};  ///< chosen last
  S stuck_s{};    ///< τ; decreases at half the rate at which it grows
  bool yielding = false;
  bool bow_first = false;  ///< the boat turns about: bow first, however far it must turn
};

template <class S>
struct Separation {
  bool yielding = false;  ///< ν* was changed
  bool known = false;     ///< at least one vessel is known
  S predicted{};          ///< least distance within the horizon under the unchanged ν*
};

/// Desired velocities, north-east, and the boat's limits.
template <class S>
struct Intent {
  Vec2<S> slot_n{};      ///< w_S
  Vec2<S> straight_n{};  ///< w_0
  Vec2<S> off_n{};       ///< −e, from the boat to the slot, m
  S fastest{};           ///< U
  S turning{};           ///< r_m
};

/// A boat among others at one instant.
template <class S>
struct SeparationInput {
  const Traffic<S>& traffic;
  Rotation<S> R{};  ///< R(ψ)
  Nu<S> nu{};
  S a{};    ///< m/s²
  S a_r{};  ///< rad/s²
  Intent<S> intent{};
  S dt{};  ///< since the last step, s
};

template <class S>
S dot(const Vec2<S>& a, const Vec2<S>& b) {
  return a.x * b.x + a.y * b.y;
}

/// Positive if b points to starboard of a.
template <class S>
S cross(const Vec2<S>& a, const Vec2<S>& b) {
  return a.x * b.y - a.y * b.x;
}

template <class S>
S length(const Vec2<S>& a) {
  return hypot(a.x, a.y);
}

template <class S>
Vec2<S> minus(const Vec2<S>& a, const Vec2<S>& b) {
  return {a.x - b.x, a.y - b.y};
}

/// Least |p + q t| for 0 ≤ t ≤ T.
template <class S>
S least_distance(const Vec2<S>& p, const Vec2<S>& q, S T) {
  const S speed = length(q);
  S t = S(0);
  if (S(0) < speed) {
    const S way = -dot(p, Vec2<S>{q.x / speed, q.y / speed});  // to the closest point of approach
    if (S(0) < way) t = way < T * speed ? way / speed : T;
  }
  return length(Vec2<S>{p.x + t * q.x, p.y + t * q.y});
}

/// D(w).
template <class S>
S predicted_distance(S horizon, const OtherVessel<S>& other, const Vec2<S>& w) {
  return least_distance(other.p_n, minus(other.v_n, w), horizon) - other.margin;
}

/// L(g): speed from which the boat stops within the gap.
template <class S>
S stopping_speed(S a, S reaction, S gap) {
  if (!(S(0) < gap)) return S(0);
  const S lag = a * reaction;
  return hypot(lag, sqrt(S(2) * a) * sqrt(gap)) - lag;
}

/// Clearance where there are no other vessels, m; chosen: beyond every tested place.
template <class S>
S unlimited() {
  return S(1000);
}

template <class S>
S quarter_turn() {
  return S(1.5707963267948966);
}

/// T for a boat with these limits. Its greatest value is chosen: above the 15 s that a WAM-V needs.
template <class S>
S horizon_of(const SeparationParams<S>& params, S U, S r_m, S a) {
  const S least = params.horizon, most = S(20);
  if (!(S(0) < U && S(0) < r_m && S(0) < a)) return least;
  const S gather_s = U < S(2) * a * most ? U / (S(2) * a) : most;
  const S quarter_s = quarter_turn<S>() / r_m, room_s = params.end * params.least / U;
  return max(least, min(params.reaction + gather_s + quarter_s + room_s, most));
}

/// Turn to a course, bow or stern first, and surge during the turn.
template <class S>
struct Way {
  S delta{};
  S u{};
};

template <class S>
Way<S> way_to(const Rotation<S>& R, const Vec2<S>& w_n, bool bow_first) {
  const S speed = length(w_n);
  if (!(S(0) < speed)) return {};
  const Vec2<S> w = to_body(R, w_n);
  if (bow_first && w.x < S(0)) return {atan2(w.y, w.x), S(0)};
  return {atan2(w.x < S(0) ? -w.y : w.y, abs(w.x)), w.x * abs(w.x) / speed};
}

/// Part of a path, sailed at one velocity.
template <class S>
struct Stretch {
  S time_s{};
  Vec2<S> v_n{};
};

/// s_w(t).
template <class S>
std::array<Stretch<S>, 5> path_to(const SeparationParams<S>& params, const SeparationInput<S>& in,
                                  const Vec2<S>& w, bool bow_first) {
  const S r_m = in.intent.turning, quarter = quarter_turn<S>();
  const Way<S> way = way_to(in.R, w, bow_first);
  const S T = params.horizon + max(S(0), abs(way.delta) - quarter) / r_m;
  const auto time_for = [&](S change, S rate) {
    return change < S(2) * rate * T ? change / (S(2) * rate) : T;
  };
  const S r_w = clamp(params.turning * way.delta, -r_m, r_m);
  const S speed_s = time_for(abs(way.u - in.nu.u), in.a);
  const S swing_s = time_for(abs(r_w - in.nu.r), in.a_r);
  const S turn_s = swing_s + abs(way.delta) / r_m, divisor_s = max(turn_s, S(0.01));
  const S gather_s = time_for(length(w) - abs(way.u), in.a);
  const auto [s, c] = sin_cos(way.delta);
  const S radius = way.u / r_m;
  const Vec2<S> turn = {swing_s * way.u + radius * abs(s),
                        (s < S(0) ? -radius : radius) * (S(1) - c)};
  const S half = S(0.5), gathers = half * (quarter < abs(way.delta) ? S(1) : S(1) + c * c);
  return {{{params.reaction, to_north_east(in.R, Vec2<S>{in.nu.u, in.nu.v})},
           {speed_s, to_north_east(in.R, Vec2<S>{half * (in.nu.u + way.u), in.nu.v})},
           {turn_s, to_north_east(in.R, Vec2<S>{turn.x / divisor_s, turn.y / divisor_s})},
           {gather_s, {gathers * w.x, gathers * w.y}},
           {max(T - params.reaction - speed_s - turn_s - gather_s, S(0)), w}}};
}

/// D of a vessel; `room`: k_y as room_for() reduces it, for a vessel with right of way.
template <class S>
S to_keep(const SeparationParams<S>& params, S room, const OtherVessel<S>& other) {
  if (other.stranger) return (room + params.end - params.yield) * params.least;
  return (other.has_way ? room : params.hold) * params.least;
}

/// k_y, reduced to k_h while τ = `stuck` grows to T_n; not for strangers.
template <class S>
S room_for(const SeparationParams<S>& params, S stuck, bool stranger) {
  if (stranger) return params.yield;
  return params.yield - (params.yield - params.hold) * min(S(1), stuck / params.narrow);
}

/// min over 0 ≤ t ≤ T of |p + v t − s_w(t)| − D_t. At the end of the path, the distance to a member
/// must be D again, or the two boats would stay side by side.
template <class S>
S clearance(const SeparationParams<S>& params, const std::array<Stretch<S>, 5>& path,
            const OtherVessel<S>& other, S keep) {
  Vec2<S> p = other.p_n;
  const S meanwhile = min(keep, length(p) - params.nearer);
  S least = unlimited<S>();
  for (const Stretch<S>& stretch : path) {
    const Vec2<S> q = minus(other.v_n, stretch.v_n);
    const bool whole = !other.stranger && &stretch == &path.back();
    least = min(least, least_distance(p, q, stretch.time_s) - (whole ? keep : meanwhile));
    p = {p.x + stretch.time_s * q.x, p.y + stretch.time_s * q.y};
  }
  return least;
}

/// h(w).
template <class S>
S clearance(const SeparationParams<S>& params, const SeparationState<S>& state,
            const SeparationInput<S>& in, const Vec2<S>& w) {
  const std::array<Stretch<S>, 5> path = path_to(params, in, w, state.bow_first);
  S least = unlimited<S>();
  for (std::size_t i = 0; i < in.traffic.count; ++i) {
    const OtherVessel<S>& other = in.traffic.vessels[i];
    const S room = room_for(params, state.stuck_s, other.stranger);
    const S keep = other.margin + to_keep(params, room, other);
    least = min(least, clearance(params, path, other, keep));
  }
  return least;
}

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
