// SPDX-License-Identifier: MIT
// Motion of a vessel along a route, made for boats to follow: straight legs, rounded corners, and
// limited speed, acceleration, yaw rate and yaw acceleration.
//
//   θ_0 = ½ r_max²/ṙ_max        ρ = min(r_max, √(2 θ_c ṙ_max))         yaw rate of the corner
//   R = max(R_min, u/ρ), less where T or C would be too long            u_c = min(u, R ρ, u R/(R + b))
//   u_j = min(u_c,j, √(u_(j+1)² + 2 a l_j))                             speed into corner j, l_j apart
//   u ← min(u_leg, √(u_j² + 2 a (l − u h))) within u ± u̇_max h    a = 0.9 u̇_max
//   at rest: r ← ±min(r_max, √(2 · 0.9 ṙ_max |Δψ|)) within r ± ṙ_max h
//
//  symbol       meaning                                              unit      tested range
//  u_leg        speed of the leg                                     m/s       0.05 … 5
//  l            distance to the next corner                          m         0 … 3000
//  b            distance of the outermost slot from the leader       m         0 … 100
//
// At a waypoint with a wait, at the last one, and before a turn of more than 160° the vessel stops
// on the waypoint, waits, and turns on the spot.
//
// Not in paper, where the virtual leader's input is given.
//
// Q16.16: tested within ±3000 (places, m)
#pragma once

#include <cstddef>
#include <span>

#include "core/corner.hpp"
#include "core/estimation/track.hpp"
#include "core/scalar/carry.hpp"

namespace flotilla::core {

template <class S>
struct RouteParams {
  S accel = S(0.1);       ///< u̇_max
  S yaw_rate = S(0.35);   ///< r_max
  S yaw_accel = S(0.15);  ///< ṙ_max
  S radius{};             ///< R_min
  S half_width{};         ///< b
};

template <class S>
struct Waypoint {
  Vec2<S> place{};
  S speed{};  ///< of the leg that ends here
  S reach{};  ///< how far the curve may pass from it
  S wait{};   ///< s; 0: does not stop here
};

/// The vessel starts at the first waypoint; successive ones are at least kShortestLeg apart.
template <class S>
using Waypoints = std::span<const Waypoint<S>>;
inline constexpr int kShortestLeg_mm = 100;

enum class RoutePhase { kLeg, kCorner, kWait, kTurn, kArrived };

template <class S>
struct RouteState {
  RoutePhase phase = RoutePhase::kArrived;
  std::size_t next = 0;  ///< waypoint ahead, or where the vessel turns or waits
  Motion<S> motion{};    ///< moved_n: position in the waypoints' frame
  Corner<S> corner{};    ///< at `next`
  S speed_at_end{};      ///< at the end of the straight part
  Vec2<S> from{};        ///< where the straight part or the corner begins
  S course{};            ///< at `from`
  S length{};            ///< of the straight part or the corner
  S way{};               ///< distance covered on it
  S left{};              ///< rest of the wait, s
  Carry<S> way_rest{}, north_rest{}, east_rest{};
};

namespace route {

template <class S>
struct Leg {
  S length{};
  S course{};
};

/// The leg from waypoint i − 1 to i.
template <class S>
Leg<S> leg(Waypoints<S> points, std::size_t i) {
  const Vec2<S>&a = points[i - 1].place, &b = points[i].place;
  const S north = b.x - a.x, east = b.y - a.y;
  return {hypot(north, east), atan2(east, north)};
}

template <class S>
S turn_at(Waypoints<S> points, std::size_t i) {
  return wrap_pi(leg(points, i + 1).course - leg(points, i).course);
}

/// Whether the vessel stops at waypoint i.
template <class S>
bool stops_at(Waypoints<S> points, std::size_t i) {
  return i == 0 || i + 1 >= points.size() || S(0) < points[i].wait ||
         S(2.8) < abs(turn_at(points, i));
}

/// The corner at waypoint i, where the vessel does not stop, and the speed in it.
template <class S>
struct Rounding {
  Corner<S> corner{};
  S speed{};
};

template <class S>
Rounding<S> rounding(const RouteParams<S>& params, Waypoints<S> points, std::size_t i) {
  const S speed = min(points[i].speed, points[i + 1].speed);
  const S turn = turn_at(points, i);
  if (abs(turn) < S(0.004)) return {Corner<S>{turn, S(1)}, speed};
  const S theta_0 = min(S(0.5) * params.yaw_rate * (params.yaw_rate / params.yaw_accel), S(1));
  const CornerShape<S> shape = corner_shape(turn, theta_0);
  const S rho = min(params.yaw_rate, sqrt(S(2) * shape.clothoid * params.yaw_accel));
  // Each end may use half of a leg: the other half is for the next corner, or for stopping.
  const S room = S(0.5) * min(leg(points, i).length, leg(points, i + 1).length);
  S R = max(params.radius, speed / rho);
  if (room < R * shape.tangent) R = room / shape.tangent;
  if (points[i].reach < R * shape.cut) R = points[i].reach / shape.cut;
  return {corner_of(shape, turn, R),
          min(min(speed, R * rho), scaled(speed, R, R + params.half_width))};
}

/// The corner at waypoint i, and the speed into it from which all later ones can be reached.
template <class S>
Rounding<S> ahead(const RouteParams<S>& params, Waypoints<S> points, std::size_t i) {
  constexpr std::size_t kHorizon = 8;  // beyond it a stop is assumed
  std::size_t j = points.size() - 1 < i + kHorizon ? points.size() - 1 : i + kHorizon;
  Rounding<S> out{};
  for (; j >= i; --j) {
    const Rounding<S> later = out;
    out = stops_at(points, j) || j == i + kHorizon ? Rounding<S>{} : rounding(params, points, j);
    if (!(S(0) < out.speed)) continue;
    const S straight =
        max(leg(points, j + 1).length - out.corner.tangent - later.corner.tangent, S(0));
    const S possible = sqrt(later.speed * later.speed + S(1.8) * params.accel * straight);
    out.speed = min(out.speed, possible);
  }
  return out;
}

/// Begins the straight part from `from` towards waypoint `next`.
template <class S>
void begin_leg(const RouteParams<S>& params, Waypoints<S> points, RouteState<S>& state,
               const Vec2<S>& from) {
  const auto [corner, speed] = ahead(params, points, state.next);
  const Vec2<S>& end = points[state.next].place;
  state.phase = RoutePhase::kLeg;
  state.corner = corner;
  state.speed_at_end = speed;
  state.from = from;
  state.course = leg(points, state.next).course;
  state.length = max(hypot(end.x - from.x, end.y - from.y) - corner.tangent, S(0));
  state.way = S(0);
}

/// Begins the part of the route that follows the straight part, corner or turn just ended.
template <class S>
void begin_next(const RouteParams<S>& params, Waypoints<S> points, RouteState<S>& state) {
  Motion<S>& motion = state.motion;
  const Waypoint<S>& here = points[state.next];
  if (state.phase == RoutePhase::kLeg && !(S(0) < state.speed_at_end)) {
    motion.moved_n = here.place;
    state.left = here.wait;
    state.phase = RoutePhase::kWait;
  } else if (state.phase == RoutePhase::kLeg) {
    state.phase = RoutePhase::kCorner;
    state.from = motion.moved_n;
    state.length = state.corner.length;
    state.way = S(0);
  } else {
    // Set the corner's end exactly, to discard the rounding errors of its integration.
    const S course = leg(points, state.next + 1).course;
    const Vec2<S> on = to_north_east(course, Vec2<S>{state.corner.tangent, S(0)});
    ++state.next;
    begin_leg(params, points, state, {here.place.x + on.x, here.place.y + on.y});
  }
}

/// Moves the vessel by ds along the present part; ds must not exceed the rest of it.
template <class S>
void move(RouteState<S>& state, S ds) {
  Motion<S>& motion = state.motion;
  const S middle = state.way + S(0.5) * ds;
  state.way = state.way + ds;
  if (state.phase == RoutePhase::kLeg) {
    motion.psi = state.course;
    const Vec2<S> on = to_north_east(state.course, Vec2<S>{state.way, S(0)});
    motion.moved_n = {state.from.x + on.x, state.from.y + on.y};
    return;
  }
  const auto [s, c] = sin_cos(state.course + turned(state.corner, middle));
  motion.moved_n = {motion.moved_n.x + state.north_rest.take(c, ds),
                    motion.moved_n.y + state.east_rest.take(s, ds)};
  motion.psi = wrap_pi(state.course + turned(state.corner, state.way));
}

template <class S>
S towards(S from, S to, S most) {
  return clamp(to, from - most, from + most);
}

/// h seconds of a turn on the spot, at waypoint `next`; at pace 0 the vessel stops turning.
template <class S>
void turn(const RouteParams<S>& params, Waypoints<S> points, RouteState<S>& state, S pace, S h) {
  Motion<S>& motion = state.motion;
  const S before = motion.nu.r, dr = params.yaw_accel * h;
  const S off = wrap_pi(leg(points, state.next + 1).course - motion.psi);
  const S most = min(params.yaw_rate, sqrt(S(1.8) * params.yaw_accel * abs(off)));
  motion.nu.r = towards(before, pace <= S(0) ? S(0) : off < S(0) ? -most : most, dr);
  const S step = S(0.5) * (before + motion.nu.r) * h;
  motion.psi = wrap_pi(motion.psi + step);
  if (S(0.01) < abs(off) || S(2) * dr < abs(before)) return;
  motion.nu.r = S(0);
  const Vec2<S> here = motion.moved_n;
  ++state.next;
  begin_leg(params, points, state, here);
}

/// h seconds on a leg or in a corner.
template <class S>
void sail(const RouteParams<S>& params, Waypoints<S> points, RouteState<S>& state, S pace, S h) {
  using enum RoutePhase;
  Motion<S>& motion = state.motion;
  const S before = motion.nu.u, du = params.accel * h;
  const bool rounds = state.phase == kCorner;
  const S left = state.length - state.way;
  const S at_end = state.speed_at_end;
  const S leg_speed = points[state.next].speed;
  const S after = max(left - before * h, S(0));
  const S possible = rounds ? at_end : sqrt(at_end * at_end + S(1.8) * params.accel * after);
  motion.nu.u = towards(before, min(pace * leg_speed, possible), du);
  S ds = state.way_rest.take(S(0.5) * (before + motion.nu.u), h);
  const bool at_stop = left < S(0.001) && before < S(2) * du;
  if (!rounds && !(S(0) < at_end) && (at_stop || !(ds < left))) {
    motion.nu.u = S(0);
    begin_next(params, points, state);
    motion.nu.r = S(0);
    return;
  }
  while (!(ds < state.length - state.way) && (state.phase == kLeg || state.phase == kCorner)) {
    const S rest = state.length - state.way;
    move(state, rest);
    ds = ds - rest;
    begin_next(params, points, state);
  }
  if (state.phase == kWait) {
    motion.nu = {};
    return;
  }
  move(state, ds);
  motion.nu.r = state.phase == kCorner && S(0) < state.corner.length
                    ? motion.nu.u * curvature(state.corner, state.way)
                    : S(0);
}

}  // namespace route

/// The vessel at rest at the first waypoint, heading for the second.
template <class S>
RouteState<S> route_start(const RouteParams<S>& params, Waypoints<S> points) {
  RouteState<S> state;
  if (points.empty()) return state;
  state.motion.moved_n = points[0].place;
  if (points.size() < 2) return state;
  state.next = 1;
  route::begin_leg(params, points, state, points[0].place);
  state.motion.psi = state.course;
  return state;
}

/// Advances by h seconds. pace: share of the legs' speeds, 0 … 1; below 1, lagging boats catch up.
/// At 0 the vessel also stops turning, and no wait runs out.
template <class S>
void route_forward(const RouteParams<S>& params, Waypoints<S> points, RouteState<S>& state, S pace,
                   S h) {
  using enum RoutePhase;
  Motion<S>& motion = state.motion;
  const Nu<S> before = motion.nu;
  switch (state.phase) {
    case kArrived:
      break;
    case kWait:
      if (pace <= S(0)) break;
      state.left = state.left - h;
      if (S(0) < state.left) break;
      state.phase = state.next + 1 < points.size() ? kTurn : kArrived;
      break;
    case kTurn:
      route::turn(params, points, state, pace, h);
      break;
    case kLeg:
    case kCorner:
      route::sail(params, points, state, pace, h);
      break;
  }
  motion.nu_dot = {(motion.nu.u - before.u) / h, S(0), (motion.nu.r - before.r) / h};
}

}  // namespace flotilla::core
