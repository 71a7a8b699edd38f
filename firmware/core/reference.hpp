// SPDX-License-Identifier: MIT
// The motion that a whole formation follows: shaped by the boat that makes the reference, carried
// forward once by each boat, and what a boat adds to its slot of it.
//
//   f(h) = ∫₀ʰ 1 … 1 s, fading to 0 at 2 s      F(h) = ∫₀ʰ f
//   ν(h) = ν + f ν̇      ν̇(h) = ḟ ν̇      ψ(h) = ψ + r h + ṙ F
//   Δp(h) = (1 − Δψ²/24) R(ψ + ½ r h + ⅓ ṙ F) [u h + u̇ F   v h + v̇ F]ᵀ      Δψ = ψ(h) − ψ
//   a ← a + Δt/(T + Δt) (ν̇ − a)                                              what the maker tells as ν̇
//   s ← s + h/(T_s + h) (k clamp(e_L, s_max/k) − s)                          shift of the slot
//   b ← b − h/(T_b + h) b                                                    rest of a changed reference
//
//  symbol   meaning                                            frame  unit        tested range
//  psi, nu, nu_dot  the root's motion when it was true         n, body  rad, m/s, rad/s  ±π, ±32, ±8
//  h        age of the reference                                      s           0 … 5
//  e_L      how far the leader is from its slot of the reference  n   m           ±1000
//  k        gain from boat to boat: well below one
//
// Not in paper: there each boat differentiates and carries forward its own leader's motion, and a
// chain of boats amplifies by as much a boat. Here that is done once, whatever the depth. An
// acceleration carried on for longer than it lasts does more harm than none.
//
// Q16.16: tested within ±5,000 (separation, m)
#pragma once

#include "core/track.hpp"

namespace flotilla::core {

template <class S>
struct ReferenceMotion {
  S psi{};
  Nu<S> nu{};
  Nu<S> nu_dot{};
  S r_ddot{};
};

/// No velocity is foreseen to change by more.
template <class S>
struct ForesightLimits {
  S speed = S(0.3);
  S yaw_rate = S(0.2);
};

/// A change of velocity over h, its rate then, and what it adds to the way; within ±most.
template <class S>
struct Foresight {
  S change{};
  S rate{};
  S way{};
};
template <class S>
Foresight<S> foresight(S h, S rate, S rate_dot, S most) {
  const S m = smaller(h, S(2));
  const S half = S(0.5) * m;
  const S change = m * (rate + half * rate_dot);
  const S way = m * half * (rate + S(0.66666666666666667) * half * rate_dot) + (h - m) * change;
  const S share = most < abs(change) ? most / abs(change) : S(1);
  return {share * change, h < S(2) ? share * (rate + m * rate_dot) : S(0), share * way};
}

/// Where the root is h seconds after the motion was true.
template <class S>
Motion<S> reference_forward(const ForesightLimits<S>& limits, const ReferenceMotion<S>& at, S h) {
  const auto u = foresight(h, at.nu_dot.u, S(0), limits.speed);
  const auto v = foresight(h, at.nu_dot.v, S(0), limits.speed);
  const auto r = foresight(h, at.nu_dot.r, at.r_ddot, limits.yaw_rate);
  const S turned = at.nu.r * h + r.way;
  const S mean = at.psi + S(0.5) * at.nu.r * h + S(0.33333333333333333) * r.way;
  const S chord = larger(S(1) - S(0.041666666666666667) * turned * turned, S(0.5));
  const Vec2<S> way = to_north_east(mean, Vec2<S>{at.nu.u * h + u.way, at.nu.v * h + v.way});
  return {{chord * way.x, chord * way.y},
          at.psi + turned,
          {at.nu.u + u.change, at.nu.v + v.change, at.nu.r + r.change},
          {u.rate, v.rate, r.rate}};
}

/// The maker's track of the root is slower than that which one boat follows its leader by: its rates
/// are carried on for longer.
template <class S>
TrackParams<S> reference_track() {
  return {.T = S(0.2), .T_min = S(0.2)};
}

template <class S>
struct ShiftParams {
  S k = S(0.3);
  S most = S(0.5);
  S T = S(10);
};

/// The shift h seconds later: slowly towards where the leader really is, no farther than `most`.
template <class S>
Vec2<S> shift_forward(const ShiftParams<S>& params, const Vec2<S>& shift, const Vec2<S>& e_L, S h) {
  const S length = params.k * hypot(e_L.x, e_L.y);
  const S gain = params.most < length ? params.k * (params.most / length) : params.k;
  const S share = h / (params.T + h);
  return {shift.x + share * (gain * e_L.x - shift.x), shift.y + share * (gain * e_L.y - shift.y)};
}

/// What is left, h seconds later, of the step that another reference made.
template <class S>
Vec2<S> blend_forward(const Vec2<S>& rest, S h) {
  const S share = h / (S(3) + h);
  return {rest.x - share * rest.x, rest.y - share * rest.y};
}

}  // namespace flotilla::core
