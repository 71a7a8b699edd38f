// SPDX-License-Identifier: MIT
// Keeps clear of other vessels: changes ν* if the law would lead the boat too near to one.
//
//   D(w)    = min over 0 ≤ t ≤ T of |p + (v − w) t| − m               predicted distance
//   D(w) < k_y D_min for a vessel with right of way, w: desired now, or straight to the slot
//           ⇒ w ← argmin of |w − w_0|/U + c_s (1 − |w − w_S|/U) + c_b |w − w_before|/U + c_d s(w)
//             over w = 0, w_0, w_S, the last choice and 16 courses at U and at U/2;
//             r* ← k_δ δ, δ: turn to that course;    ends at k_e D_min
//   s(w)    : relative shortfall of d² below (k_y D_min + m)², summed over 8 times up to T, sooner
//             ones weighted more; the boat first turns bow or stern to its course, on the spot
//   u* n ≤ L((|p| − m − k_h D_min)/2) + k_v max(0, vᵀ p/|p|)           n = cos of the bearing
//   L(g)    = √((a t_r)² + 2 a g) − a t_r, 0 for g ≤ 0                  speed that stops within g
//
//  symbol  meaning                                            unit   tested range
//  p, v    other vessel's position relative to us, velocity   m, m/s ±100, ±5
//  m       uncertainty of that position                       m      0 … 5
//  D_min   distance to keep; 0: off                           m      0.5 … 20
//  T       horizon                                            s
//  w_S     the slot's velocity                                m/s
//  w_0     velocity that leads straight to the slot           m/s
//  U       LAW_U_MAX; if that is 0, max(D_min / 1 s, k_U |w_S|)   m/s
//  a, t_r  half the full-astern deceleration; reaction time   m/s², s
//
// Only the yielding boat chooses w. The limit of u* binds every boat, also one with right of way:
// where both obey it, they stay k_h D_min apart, and the way is free again once the yielding boat
// has made room up to k_y D_min. Slots must be farther apart than that.
//
// The factors k and c were chosen by hand. With them, boats in 200 chance meetings stay D_min apart
// and all arrive, two boats bow to bow stop, and a vessel at rest is passed: test_separation.cpp.
//
// Not in paper. Source of the idea: P. Fiorini, Z. Shiller, Motion planning in dynamic environments
// using velocity obstacles, IJRR 17 (1998).
//
// Q16.16: tested within ±200 (other vessels' places, m)
#pragma once

#include <array>
#include <cstddef>

#include "core/allocation.hpp"
#include "core/virtual_velocity.hpp"

namespace flotilla::core {

/// Another vessel at this instant.
template <class S>
struct OtherVessel {
  Vec2<S> p_n{};   ///< relative to us
  Vec2<S> v_n{};   ///< over ground
  S margin{};      ///< uncertainty of p_n, m
  bool has_way{};  ///< right of way: we yield
};

constexpr std::size_t kMaxVessels = 8;

template <class S>
struct Traffic {
  std::array<OtherVessel<S>, kMaxVessels> vessels{};
  std::size_t count = 0;
};

template <class S>
struct SeparationParams {
  S least{};            ///< D_min, m
  S horizon = S(4);     ///< T, s
  S reaction = S(0.4);  ///< t_r, s

  // Distances over D_min.
  S hold = S(1.1);   ///< k_h: no boat approaches further
  S yield = S(1.4);  ///< k_y: yielding begins; above k_h, or nobody would have room to pass
  S end = S(1.5);    ///< k_e: yielding ends; above k_y, or it would begin again at once

  // Costs of a velocity: of a difference of U, and of s(w) = 1.
  S settling = S(0.5);  ///< c_s: of settling for w_S, with which a boat passes nobody in formation
  S change = S(0.3);    ///< c_b: of another choice than before
  S danger = S(10);     ///< c_d: far above the others

  S receding = S(0.8);  ///< k_v: share of another vessel's speed away from us that is relied on
  S faster = S(1.1);    ///< k_U: over the slot's speed, to catch up with it
  S turning = S(2);     ///< k_δ, 1/s
  S any_rate = S(1);    ///< greatest yaw rate where LAW_R_MAX is 0, rad/s
};

template <class S>
struct SeparationState {
  Vec2<S> w_n{};  ///< chosen last
  bool yielding = false;
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
  S fastest{};           ///< U
  S turning{};           ///< greatest yaw rate
};

/// A boat among others at one instant.
template <class S>
struct SeparationInput {
  const Traffic<S>& traffic;
  Rotation<S> R{};  ///< R(ψ)
  S a{};            ///< m/s²
  Intent<S> intent{};
};

template <class S>
S dot(const Vec2<S>& a, const Vec2<S>& b) {
  return a.x * b.x + a.y * b.y;
}

template <class S>
S length(const Vec2<S>& a) {
  return hypot(a.x, a.y);
}

template <class S>
Vec2<S> minus(const Vec2<S>& a, const Vec2<S>& b) {
  return {a.x - b.x, a.y - b.y};
}

/// D(w).
template <class S>
S predicted_distance(S horizon, const OtherVessel<S>& other, const Vec2<S>& w) {
  const Vec2<S> q = minus(other.v_n, w);
  const S speed = length(q);
  S t = S(0);
  if (S(0) < speed) {
    const S way =
        -dot(other.p_n, Vec2<S>{q.x / speed, q.y / speed});  // to the closest point of approach
    if (S(0) < way) t = way < horizon * speed ? way / speed : horizon;
  }
  return length(Vec2<S>{other.p_n.x + t * q.x, other.p_n.y + t * q.y}) - other.margin;
}

/// Speed from which the boat stops within the gap.
template <class S>
S stopping_speed(S a, S reaction, S gap) {
  if (!(S(0) < gap)) return S(0);
  const S lag = a * reaction;
  return hypot(lag, sqrt(S(2) * a) * sqrt(gap)) - lag;
}

/// Turn and surge that bring a boat onto a course, bow or stern first.
template <class S>
struct Way {
  S delta{};
  S u{};  ///< also during the turn
};

template <class S>
Way<S> way_to(const Rotation<S>& R, const Vec2<S>& w_n) {
  const S speed = length(w_n);
  if (!(S(0) < speed)) return {};
  const Vec2<S> w = to_body(R, w_n);
  return {atan2(w.x < S(0) ? -w.y : w.y, abs(w.x)), w.x * abs(w.x) / speed};
}

/// 1 − (|p|/keep)², 0 beyond; does not overflow for a distant p.
template <class S>
S lacking(const Vec2<S>& p, S keep) {
  if (!(abs(p.x) < keep && abs(p.y) < keep)) return S(0);
  const Vec2<S> share = {p.x / keep, p.y / keep};
  return max(S(0), S(1) - dot(share, share));
}

/// s(w) for one vessel.
template <class S>
S shortfall(const SeparationParams<S>& params, const OtherVessel<S>& other, const Vec2<S>& w,
            S turning_s) {
  const S keep = params.yield * params.least + other.margin;
  S sum = S(0);
  for (int k = 1; k <= 8; ++k) {
    const S t = params.horizon * S(k) / S(8);
    const S under_way = max(S(0), t - turning_s);
    const Vec2<S> p = {other.p_n.x + t * other.v_n.x - under_way * w.x,
                       other.p_n.y + t * other.v_n.y - under_way * w.y};
    sum = sum + S(9 - k) / S(8) * lacking(p, keep);
  }
  return sum;
}

template <class S>
S cost_of(const SeparationParams<S>& params, const SeparationState<S>& state,
          const SeparationInput<S>& in, const Vec2<S>& w) {
  const Intent<S>& intent = in.intent;
  const S turning_s = abs(way_to(in.R, w).delta) / intent.turning;
  S cost = length(minus(w, intent.straight_n)) / intent.fastest +
           params.settling * (S(1) - length(minus(w, intent.slot_n)) / intent.fastest);
  if (state.yielding) cost = cost + params.change * length(minus(w, state.w_n)) / intent.fastest;
  for (std::size_t i = 0; i < in.traffic.count; ++i) {
    const OtherVessel<S>& other = in.traffic.vessels[i];
    if (other.has_way) cost = cost + params.danger * shortfall(params, other, w, turning_s);
  }
  return cost;
}

/// The velocity of least cost; of equals the first.
template <class S>
Vec2<S> choose(const SeparationParams<S>& params, const SeparationState<S>& state,
               const SeparationInput<S>& in) {
  Vec2<S> best{};
  S least = cost_of(params, state, in, best);
  const auto consider = [&](const Vec2<S>& w) {
    const S cost = cost_of(params, state, in, w);
    if (!(cost < least)) return;
    least = cost;
    best = w;
  };
  consider(in.intent.straight_n);
  consider(in.intent.slot_n);
  if (state.yielding) consider(state.w_n);
  const S c = S(0.92387953251128674), s = S(0.38268343236508977);  // cos, sin of π/8
  Vec2<S> course = {in.intent.fastest, S(0)};
  for (int k = 0; k < 16; ++k) {
    consider(course);
    consider({S(0.5) * course.x, S(0.5) * course.y});
    course = {c * course.x - s * course.y, s * course.x + c * course.y};
  }
  return best;
}

/// Whether a boat that sails with w must yield, and the least predicted distance.
template <class S>
Separation<S> foresee(const SeparationParams<S>& params, const SeparationState<S>& state,
                      const SeparationInput<S>& in, const Vec2<S>& w) {
  const S keep = (state.yielding ? params.end : params.yield) * params.least;
  Separation<S> out;
  for (std::size_t i = 0; i < in.traffic.count; ++i) {
    const OtherVessel<S>& other = in.traffic.vessels[i];
    const S now = predicted_distance(params.horizon, other, w);
    out.predicted = out.known ? min(out.predicted, now) : now;
    out.known = true;
    const S straight = predicted_distance(params.horizon, other, in.intent.straight_n);
    out.yielding = out.yielding || (other.has_way && min(now, straight) < keep);
  }
  return out;
}

/// Limits u so that u* n stays within its bound for every vessel.
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
                    const Vec2<S>& slot_n, const Vec2<S>& to_slot_n) {
  const S fastest =
      S(0) < limits.u_max ? limits.u_max : max(params.least, params.faster * length(slot_n));
  return {shortened(slot_n, fastest), shortened(to_slot_n, fastest), fastest,
          S(0) < limits.r_max ? limits.r_max : params.any_rate};
}

/// Changes ν* where necessary.
template <class S>
Separation<S> separate(const SeparationParams<S>& params, SeparationState<S>& state,
                       const SeparationInput<S>& in, VirtualVelocity<S>& desired) {
  Nu<S>& nu = desired.nu_star;
  Separation<S> out = foresee(params, state, in, to_north_east(in.R, Vec2<S>{nu.u, S(0)}));
  if (out.yielding) {
    state.w_n = choose(params, state, in);
    const Way<S> way = way_to(in.R, state.w_n);
    nu.u = way.u;
    nu.r = clamp(params.turning * way.delta, -in.intent.turning, in.intent.turning);
    desired.r_star_dot = S(0);
  }
  state.yielding = out.yielding;
  const S u = held_back(params, in, nu.u);
  out.yielding = out.yielding || u < nu.u || nu.u < u;
  nu.u = u;
  if (out.yielding) desired.u_star_dot = S(0);
  return out;
}

}  // namespace flotilla::core
