// SPDX-License-Identifier: MIT
// How near a boat would pass other vessels if it changed to another velocity, on its own turning
// circles.
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
//   D      = D_min (k_y − (k_y − k_h) min(1, τ/T_n)), k_h D_min for a vessel without right of way;
//            from a stranger k_e D_min
//
//  symbol    meaning                                            unit    tested range
//  p, v, m   other vessel's place seen from us, velocity,       m, m/s, m  ±100, ±5, 0 … 5
//            and uncertainty of its place
//  D_min     distance to keep; 0: off                           m       0.5 … 20
//  w, δ, u_w velocity; the turn to its course, bow or stern first, ±π/2; surge when that begins
//  r_m, U    LAW_R_MAX, LAW_U_MAX; if U is 0, max(D_min / 1 s, k_U |w_S|)   rad/s, m/s
//  τ         time without progress towards the slot             s
//  a, t_r    half the full-astern deceleration; reaction time   m/s², s
//  a_r       yaw acceleration by the moment left while braking  rad/s²
//
// Not in paper. Sources of the ideas: C. Lee, J. Park, J. Kim, arXiv 2504.19247 (turning circles);
// T. Paine et al., arXiv 2601.11335 (worst case).
//
// Q16.16: tested within ±500 (other vessels' places, m)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/rotation.hpp"

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
  S hold = S(1.1);     ///< k_h; chosen: distance that approaches aim at, a margin over D_min
  S yield = S(1.4);    ///< k_y: yielding begins; chosen: above k_h, which leaves room to pass
  S end = S(1.5);      ///< k_e: yielding ends; chosen: above k_y, or it would begin again at once
  S keep_on = S(1.5);  ///< s, at most τ; yielding to members goes on that long; chosen: law and
                       ///< yielding, which may turn the boat opposite ways, do not alternate

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
  S left_s{};     ///< until the boat stops yielding to members
  bool yielding = false;
  bool bow_first = false;  ///< the boat turns about: bow first, however far it must turn
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
  const S gather_s = ratio_within(U, S(2) * a, most);
  const S quarter_s = ratio_within(quarter_turn<S>(), r_m, most);
  const S room_s = ratio_within(params.end * params.least, U, most);
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

}  // namespace flotilla::core
