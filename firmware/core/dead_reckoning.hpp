// SPDX-License-Identifier: MIT
// The boat's own motion between two fixes: its model under the wrench that its propellers give, and
// what else accelerates it.
//
//   m11 u̇ = X + m22 v r − d11 u + m11 b_u          m22 v̇ = −m11 u r − d22 v + m22 b_v
//   m33 ṙ = N − (m22 − m11) u v − d33 r + m33 b_r
//   ν₊ = (ν + h (M⁻¹(τ − C(ν) ν) + b)) / (1 + h M⁻¹ D)      ψ₊ = ψ + h r̄      p₊ = p + h R(ψ̄) [ū v̄]ᵀ
//   b ← b + (ν − ν̂) / (Δt + T)                      at a fix, carried forward to now, that says ν
//
//  symbol  meaning                                     frame  unit         tested range
//  nu      velocity over ground                        body   m/s, rad/s   ±20, ±4
//  tau     wrench given, held over the step            body   N, N m       ±1000
//  b       acceleration that the model does not know   body   m/s², rad/s²
//  h       step                                               s            0 … 1
//  x̄, x̂   mean of a step's beginning and end; what was expected
//
// Source: paper (eq:1b). Not in paper, which has states at every instant: with k_dr = 10 the yaw
// loop needs the yaw rate more than 27 times a second, and many navigation units give it 5 times.
// Damping is taken at the step's end, which is stable for any h.
#pragma once

#include "core/track.hpp"
#include "core/vessel.hpp"

namespace flotilla::core {

template <class S>
struct ReckoningParams {
  S bias_lag_s = S(0.3);  ///< T: shorter follows wind and mistaken damping, longer ignores noise
};

template <class S>
struct Reckoning {
  Motion<S> motion{};  ///< now; moved_n: since the last fix
  Nu<S> bias{};        ///< b
};

/// A fix: heading and velocity `age` ago, `dt` after the fix before it, 0 for the first.
template <class S>
struct Fix {
  S psi{};
  Nu<S> nu{};
  S age{};
  S dt{};
};

/// One step of h seconds.
template <class S>
Motion<S> reckon_step(const Vessel<S>& m, const Reckoning<S>& now, const Tau<S>& tau, S h) {
  const auto& [u, v, r] = now.motion.nu;
  const S a_u = (tau.X + m.m22 * v * r) / m.m11 + now.bias.u;
  const S a_v = -(m.m11 * u * r) / m.m22 + now.bias.v;
  const S a_r = (tau.N - (m.m22 - m.m11) * u * v) / m.m33 + now.bias.r;
  const Nu<S> next = {(u + h * a_u) / (S(1) + h * m.d11 / m.m11),
                      (v + h * a_v) / (S(1) + h * m.d22 / m.m22),
                      (r + h * a_r) / (S(1) + h * m.d33 / m.m33)};
  const S half = S(0.5) * h;
  const S turned = half * (r + next.r);
  const Vec2<S> way = to_north_east(now.motion.psi + S(0.5) * turned,
                                    Vec2<S>{half * (u + next.u), half * (v + next.v)});
  return {
      {now.motion.moved_n.x + way.x, now.motion.moved_n.y + way.y},
      now.motion.psi + turned,
      next,
      {a_u - m.d11 / m.m11 * next.u, a_v - m.d22 / m.m22 * next.v, a_r - m.d33 / m.m33 * next.r}};
}

/// Within the reach of any boat: what is greater is no motion but an arithmetic that ran away.
template <class S>
Nu<S> bounded(const Nu<S>& nu, S most) {
  return {clamp(nu.u, -most, most), clamp(nu.v, -most, most), clamp(nu.r, -most, most)};
}

/// Carries the motion on by `time` seconds, in steps of at most 20 ms; by no more than a second.
template <class S>
void reckon_forward(const Vessel<S>& vessel, Reckoning<S>& state, const Tau<S>& tau, S time) {
  S left = smaller(time, S(1));
  while (S(0) < left) {
    const S h = smaller(left, S(0.02));
    state.motion = reckon_step(vessel, state, tau, h);
    state.motion.nu = bounded(state.motion.nu, S(50));
    left = left - h;
  }
}

/// Begins anew at a fix; the state must have been carried forward to now before.
template <class S>
void reckon_from(const ReckoningParams<S>& params, const Vessel<S>& vessel, Reckoning<S>& state,
                 const Fix<S>& fix, const Tau<S>& tau) {
  const Nu<S> expected = state.motion.nu;
  state.motion = {{}, fix.psi, fix.nu, state.motion.nu_dot};
  reckon_forward(vessel, state, tau, fix.age);
  if (S(0) < fix.dt) {
    const S gain = S(1) / (fix.dt + params.bias_lag_s);
    state.bias.u = state.bias.u + gain * (state.motion.nu.u - expected.u);
    state.bias.v = state.bias.v + gain * (state.motion.nu.v - expected.v);
    state.bias.r = state.bias.r + gain * (state.motion.nu.r - expected.r);
    state.bias = bounded(state.bias, S(50));
  } else {
    state.bias = {};
  }
}

/// The motion a moment, a millisecond or so, before.
template <class S>
Motion<S> moment_before(Motion<S> motion, S moment) {
  const Vec2<S> way =
      to_north_east(motion.psi, Vec2<S>{moment * motion.nu.u, moment * motion.nu.v});
  motion.moved_n = {motion.moved_n.x - way.x, motion.moved_n.y - way.y};
  motion.psi = motion.psi - moment * motion.nu.r;
  return motion;
}

}  // namespace flotilla::core
