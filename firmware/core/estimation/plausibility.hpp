// SPDX-License-Identifier: MIT
// Judges whether a vessel can have moved from one reported state to the next.
//
//   w = min(a h, V)          w_r = min(a_r h, R)
//   |Δp − ½ λ h (v₀ + v₁)| ≤ p_0 + 8 s + ½ h w            |Δψ − ½ λ h (r₀ + r₁)| ≤ ψ_0 + ½ h w_r
//   |v₁ − Λ v₀| ≤ v_0 + w + 4 h |v₀ r₀|                   |r₁ − λ r₀| ≤ r_0 + w_r + 10 h v₀²
//
//  symbol    meaning                                              frame  unit        tested range
//  Δp, Δψ    displacement and turn between the states             n      m, rad      ±15000, ±π
//  v, r      velocity over ground, yaw rate, of both states       n      m/s, rad/s  ±50, ±20
//  h         time between them                                           s           0 … 60
//  a, a_r    greatest acceleration by the propellers                     m/s², rad/s²  0 … 500
//  V, R      greatest change of v, r by the propellers                   m/s, rad/s  0 … 200
//  p_0 ψ_0 v_0 r_0  allowance for the errors of two states
//  λ, Λ      the best value in 0 … 1; Λ has one for each of the vessel's axes
//  s         usual scatter of this source's positions                    m
//
// Not in paper. A vessel may be held or stop at any deceleration, by a quay or by its drag, which
// differs between the axes: hence Λ. The last terms bound generously the effects of added mass at
// speed: (m22/m11) v r, and Munk's moment (m22 − m11) u v / m33; they stop growing after 40 m.
//
// Q16.16: tested within ±2,000 (a_r h, rad/s)
#pragma once

#include "core/rotation.hpp"

namespace flotilla::core {

template <class S>
struct PlausibilityLimits {
  S position{};
  S heading{};
  S speed{};
  S yaw_rate{};
  S a{};
  S a_r{};
  S V{};
  S R{};
};

/// From one reported state to the next, h seconds later.
template <class S>
struct Leg {
  Vec2<S> moved_n{};
  S psi_from{}, psi_to{};
  Nu<S> from{}, to{};
  S h{};
};

template <class S>
struct Innovation {
  S off{};    ///< position error, m
  S share{};  ///< greatest error over its limit; above 1 it is a jump
};

/// Distance of b from the segment between 0 and a.
template <class S>
S beyond(S a, S b) {
  return abs(b - clamp(b, min(a, S(0)), max(a, S(0))));
}

template <class S>
S beyond(const Vec2<S>& a, const Vec2<S>& b) {
  const S length = hypot(a.x, a.y);
  if (!(S(0) < length)) return hypot(b.x, b.y);
  const Vec2<S> unit = {a.x / length, a.y / length};
  const S along = clamp(unit.x * b.x + unit.y * b.y, S(0), length);
  return hypot(b.x - along * unit.x, b.y - along * unit.y);
}

template <class S>
Innovation<S> innovation_of(const PlausibilityLimits<S>& limits, const Leg<S>& leg, S scatter) {
  const S half = S(0.5) * leg.h;
  const S w = min(limits.a * leg.h, limits.V);
  const S w_r = min(limits.a_r * leg.h, limits.R);
  const Vec2<S> before = to_north_east(leg.psi_from, Vec2<S>{leg.from.u, leg.from.v});
  const Vec2<S> after = to_north_east(leg.psi_to, Vec2<S>{leg.to.u, leg.to.v});
  const Vec2<S> way = {half * (before.x + after.x), half * (before.y + after.y)};
  const auto far = [](S x) { return clamp(x, S(-15000), S(15000)); };  // a jump in any case
  const S off = beyond(way, {far(leg.moved_n.x), far(leg.moved_n.y)});
  const S speed = hypot(leg.from.u, leg.from.v);
  const S sailed = min(leg.h * speed, S(40));
  const S munk = min(S(10) * sailed * min(speed, S(70)), S(500));
  const S turned = wrap_pi(leg.psi_to - leg.psi_from);
  const S expected = half * (leg.from.r + leg.to.r);
  const S turn = min(beyond(expected, turned), abs(wrap_pi(turned - expected)));
  const Vec2<S> was = to_body(leg.psi_to, before);
  const S u = beyond(was.x, leg.to.u);
  const S v = beyond(was.y, leg.to.v);
  const S swing = S(4) * sailed * abs(leg.from.r);
  const S place = off / (limits.position + S(8) * scatter + half * w);
  const S heading = turn / (limits.heading + half * (w_r + munk));
  const S velocity = hypot(u, v) / (limits.speed + w + swing);
  const S yaw_rate = beyond(leg.from.r, leg.to.r) / (limits.yaw_rate + w_r + munk);
  return {off, max(max(place, heading), max(velocity, yaw_rate))};
}

/// Upper limits of changes that are plausible in every case.
template <class S>
struct SmallMove {
  S place{};
  S heading{};
  S change{};  ///< of speed
  S speed{};
  S yaw_rate{};
};

template <class S>
SmallMove<S> small_move(const PlausibilityLimits<S>& limits) {
  const S change = S(0.25) * limits.speed;  // a turn by 0.1 rad at `speed` adds as much again
  return {S(0.5) * limits.position, min(S(0.1), limits.heading), change, S(10) * change,
          limits.yaw_rate};
}

/// True only if the leg is certainly no jump; far cheaper than innovation_of().
template <class S>
bool hardly_moves(const SmallMove<S>& most, const Leg<S>& leg) {
  const auto within = [](S x, S limit) { return abs(x) < limit; };
  return within(leg.moved_n.x, most.place) && within(leg.moved_n.y, most.place) &&
         within(leg.psi_to - leg.psi_from, most.heading) &&
         within(leg.to.u - leg.from.u, most.change) && within(leg.to.v - leg.from.v, most.change) &&
         within(leg.from.u, most.speed) && within(leg.from.v, most.speed) &&
         within(leg.to.r - leg.from.r, most.yaw_rate);
}

}  // namespace flotilla::core
