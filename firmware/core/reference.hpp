// SPDX-License-Identifier: MIT
// The root's motion, which the whole formation follows: each boat predicts it once, and shifts its
// own slot a little.
//
//   m = min(h, 2 s)     δ = m (ν̇ + ½ m ν̈)     c = min(1, δ_max/|δ|)
//   ν(h) = ν + c δ      ν̇(h) = c (ν̇ + m ν̈), 0 after 2 s
//   ∫δ = ½ m² (ν̇ + ⅓ m ν̈) + (h − m) δ                 ψ(h) = ψ + Δψ     Δψ = r h + c ∫δ_r
//   Δp(h) = (1 − Δψ²/24) R(ψ + ½ r h + ⅓ c ∫δ_r) [u h + c ∫δ_u   v h + c ∫δ_v]ᵀ
//   s ← s + h/(T + h) (k e_L − s), or (0 − s) where k |e_L| > s_max      shift of the slot
//   b = b_0 x² (3 − 2x)     x = 1 − t/(5 s), until it is 0     remaining step of the slot
//
//  symbol   meaning                                             frame    unit        tested range
//  psi, nu, nu_dot, r_ddot  root's motion at its timestamp    n, body  rad, m/s, rad/s  ±π, ±32, ±8
//  h        age of that motion, or a time step                           s           0 … 10
//  δ_max    largest predicted change of a velocity                       m/s, rad/s
//  e_L      leader's offset from its own slot                   n        m           ±5000
//  k        gain from boat to boat
//
// Not in paper: there each boat differentiates and predicts its own leader's motion, so that each
// boat of a chain amplifies the first boat's motion again. Here this happens once, at any depth. A
// predictor's gain must exceed one at some frequency: H(0) = 1, |H| ≤ 1 and a lead, H'(0) > 0,
// contradict each other, for |H| is greatest on the edge of the right half plane. The maker's
// slower track and δ_max keep the gain small; only the shift passes from boat to boat, with k < 1.
//
// Q16.16: tested within ±5,000 (e_L, m)
#pragma once

#include "core/estimation/track.hpp"

namespace flotilla::core {

template <class S>
struct ReferenceMotion {
  S psi{};
  Nu<S> nu{};
  Nu<S> nu_dot{};
  S r_ddot{};
};

/// δ_max
template <class S>
struct ForesightLimits {
  S speed{};
  S yaw_rate{};
};

/// c δ, its rate, and c ∫δ.
template <class S>
struct Foresight {
  S change{};
  S rate{};
  S way{};
};
template <class S>
Foresight<S> foresight(S h, S rate, S rate_dot, S most) {
  if (!(S(0) < max(abs(rate), abs(rate_dot)))) return {};  // a constant velocity
  const S m = min(h, S(2));
  const S half = S(0.5) * m;
  const S change = m * (rate + half * rate_dot);
  const S way = m * half * (rate + S(0.66666666666666667) * half * rate_dot) + (h - m) * change;
  const S share = most < abs(change) ? most / abs(change) : S(1);
  return {share * change, h < S(2) ? share * (rate + m * rate_dot) : S(0), share * way};
}

/// The root's motion h seconds after the timestamp of `at`.
template <class S>
Motion<S> reference_forward(const ForesightLimits<S>& limits, const ReferenceMotion<S>& at, S h) {
  const auto u = foresight(h, at.nu_dot.u, S(0), limits.speed);
  const auto v = foresight(h, at.nu_dot.v, S(0), limits.speed);
  const auto r = foresight(h, at.nu_dot.r, at.r_ddot, limits.yaw_rate);
  const S turned = at.nu.r * h + r.way;
  const S mean = at.psi + S(0.5) * at.nu.r * h + S(0.33333333333333333) * r.way;
  const S chord = max(S(1) - S(0.041666666666666667) * turned * turned, S(0.5));
  const Vec2<S> way = to_north_east(mean, Vec2<S>{at.nu.u * h + u.way, at.nu.v * h + v.way});
  return {{chord * way.x, chord * way.y},
          at.psi + turned,
          {at.nu.u + u.change, at.nu.v + v.change, at.nu.r + r.change},
          {u.rate, v.rate, r.rate}};
}

/// The maker's track of the root. It is slower than a boat's track of its own leader, because many
/// boats extrapolate its rates, and for longer.
template <class S>
TrackParams<S> reference_track() {
  return {.T = S(0.2)};
}

template <class S>
struct ShiftParams {
  S k = S(0.3);
  S most = S(0.15);
  S T = S(20);
};

/// The shift h seconds later. It follows k e_L slowly; where k |e_L| > `most` it returns to zero,
/// because the leader is then still closing up, or has left its slot.
template <class S>
Vec2<S> shift_forward(const ShiftParams<S>& params, const Vec2<S>& shift, const Vec2<S>& e_L, S h) {
  const S gain = params.most < params.k * hypot(e_L.x, e_L.y) ? S(0) : params.k;
  const S share = h / (params.T + h);
  return {shift.x + share * (gain * e_L.x - shift.x), shift.y + share * (gain * e_L.y - shift.y)};
}

/// The step of the slot at a change of reference: cancelled at first, then blended in.
template <class S>
struct Blend {
  Vec2<S> step{};
  S left{};  ///< time left, s
};
template <class S>
Blend<S> blend_start(const Vec2<S>& step) {
  return {step, S(5)};
}
template <class S>
void blend_forward(Blend<S>& blend, S h) {
  blend.left = max(blend.left - h, S(0));
}
template <class S>
Vec2<S> rest_of(const Blend<S>& blend) {
  const S x = blend.left / S(5);
  const S share = x * x * (S(3) - S(2) * x);
  return {share * blend.step.x, share * blend.step.y};
}

}  // namespace flotilla::core
