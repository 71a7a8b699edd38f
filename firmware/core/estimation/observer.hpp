// SPDX-License-Identifier: MIT
// Estimates the boat's own motion at and between its fixes, the unmodelled forces, and the current.
//
//   ν_w = ν − c_b,  c_b = R(ψ)ᵀ c                            through the water
//   m11 u̇ = X + m22 v_w r − (d11 + d11q |u_w|) u_w + m11 (b_u + r c_y)
//   m22 v̇ = −m11 u_w r − d22 v_w + m22 (b_v − r c_x)
//   m33 ṙ = N − (m22 − m11) u_w v_w − (d33 + d33u |u_w|) r + m33 b_r
//   ν₊ from there with ν of the damping at the step's end      ψ₊ = ψ + h r̄      p₊ = p + h R(ψ̄) [ū v̄]ᵀ
//   at a fix, predicted to now under the wrenches applied since, with k = Δt / (Δt + T):
//   η ← η̂ + k (η − η̂)     ν ← ν̂ + k (ν − ν̂)     b ← b + k ω (ν − ν̂) / (1 + ω Δt)
//   c ← c + ω_c Δt R(ψ) [0  (m22/d22) b_v]ᵀ
//
//  symbol  meaning                                     frame  unit         tested range
//  nu      velocity over ground                        body   m/s, rad/s   ±20, ±4
//  tau     applied wrench, constant over the step      body   N, N m       ±1000
//  b       unknown force over mass                     body   m/s², rad/s²
//  c       current                                     n      m/s          ±2
//  ω, ω_c  bandwidth of b, of c; 0: off                       rad/s        0 … 5, 0 … 1
//  h       step                                               s            0 … 1
//  x̄, x̂   mean of a step's beginning and end; prediction
//
// Source: paper (eq:1b). Not in paper, which knows the state at every instant: with k_dr = 10 the
// yaw loop needs the yaw rate at more than 27 Hz, but many navigation units give it at 5 Hz. The
// observer uses the applied wrench, so that b does not wind up where the propellers saturate. The
// current is that part of the sway error whose direction over ground is the same on every heading.
//
// Q16.16: tested within ±500 (wrench given, N)
#pragma once

#include "core/estimation/track.hpp"
#include "core/scalar/carry.hpp"
#include "core/vessel.hpp"

namespace flotilla::core {

template <class S>
struct ObserverParams {
  S omega{};    ///< ω
  S omega_c{};  ///< ω_c
  Nu<S> b_max{};
  S T = S(0.1);  ///< averaging time for the noise of fixes; not used where ω is 0
  S c_max = S(2);
};

/// The latest applied wrenches, the newest at `last`; steps shorter than 10 ms are averaged.
template <class S>
struct WrenchHistory {
  static constexpr int kLength = 64;
  Tau<S> tau[kLength]{};
  S time[kLength]{};
  int last = 0;
};

template <class S>
struct Observer {
  Motion<S> motion{};  ///< now; moved_n: since the last fix
  Nu<S> b{};
  Vec2<S> c_n{};
  WrenchHistory<S> given{};
  Nu<Carry<S>> nu_rest{}, b_rest{};
  Vec2<Carry<S>> moved_rest{}, c_rest{};
  Carry<S> psi_rest{};
};

/// A fix: heading and velocity `age` ago, `dt` after the previous fix; dt = 0 for the first.
template <class S>
struct Fix {
  Vec2<S> expected_n{};  ///< predicted position now, relative to this fix
  S psi{};
  Nu<S> nu{};
  S age{};
  S dt{};
};

/// One step of h seconds.
template <class S>
Motion<S> observer_step(const Vessel<S>& m, const Observer<S>& now, const Tau<S>& tau, S h) {
  const auto& [u, v, r] = now.motion.nu;
  const Vec2<S> c = to_body(now.motion.psi, now.c_n);
  const S u_w = u - c.x;
  const S v_w = v - c.y;
  const S d_u = m.d11_m11 + m.d11q_m11 * abs(u_w);
  const S d_r = m.d33_m33 + m.d33u_m33 * abs(u_w);
  const S a_u = (tau.X + m.m22 * v_w * r + surge_damping(m, u_w) * c.x) / m.m11 + now.b.u + r * c.y;
  const S a_v = (m.d22 * c.y - m.m11 * u_w * r) / m.m22 + now.b.v - r * c.x;
  const S a_r = (tau.N - (m.m22 - m.m11) * u_w * v_w) / m.m33 + now.b.r;
  const Nu<S> next = {(u + h * a_u) / (S(1) + h * d_u), (v + h * a_v) / (S(1) + h * m.d22_m22),
                      (r + h * a_r) / (S(1) + h * d_r)};
  const S half = S(0.5) * h;
  const S turned = half * (r + next.r);
  const Vec2<S> way = to_north_east(now.motion.psi + S(0.5) * turned,
                                    Vec2<S>{half * (u + next.u), half * (v + next.v)});
  return {{now.motion.moved_n.x + way.x, now.motion.moved_n.y + way.y},
          now.motion.psi + turned,
          next,
          {a_u - d_u * next.u, a_v - m.d22_m22 * next.v, a_r - d_r * next.r}};
}

/// Limits each component to ±most.
template <class S>
Nu<S> bounded(const Nu<S>& nu, const Nu<S>& most) {
  return {clamp(nu.u, -most.u, most.u), clamp(nu.v, -most.v, most.v), clamp(nu.r, -most.r, most.r)};
}

/// Predicts the motion over `time` seconds, at most 2 s, in steps of at most 20 ms.
template <class S>
void observer_carry(const Vessel<S>& vessel, Observer<S>& state, const Tau<S>& tau, S time) {
  S left = min(time, S(2));
  while (S(0) < left) {
    const S h = min(left, S(0.02));
    state.motion = observer_step(vessel, state, tau, h);
    // No boat reaches these: there the arithmetic has diverged.
    state.motion.nu = bounded(state.motion.nu, Nu<S>{S(50), S(50), S(50)});
    left = left - h;
  }
}

/// The same under the applied wrench, which it records for late fixes.
template <class S>
void observer_forward(const Vessel<S>& vessel, Observer<S>& state, const Tau<S>& tau, S time) {
  if (!(S(0) < time)) return;
  observer_carry(vessel, state, tau, time);
  WrenchHistory<S>& given = state.given;
  S& length = given.time[given.last];
  Tau<S>& mean = given.tau[given.last];
  if (length + time <= S(0.01)) {
    const S share = time / (length + time);
    mean = {mean.X + share * (tau.X - mean.X), mean.N + share * (tau.N - mean.N)};
    length = length + time;
    return;
  }
  given.last = (given.last + 1) % WrenchHistory<S>::kLength;
  given.tau[given.last] = tau;
  given.time[given.last] = time;
}

/// Predicts from a fix `age` ago to now, under the wrenches applied since.
template <class S>
void observer_replay(const Vessel<S>& vessel, Observer<S>& state, S age) {
  const WrenchHistory<S>& given = state.given;
  constexpr int n = WrenchHistory<S>::kLength;
  int back = 0;
  S later = S(0);  // duration of the wrenches after this one
  while (later + given.time[(given.last + n - back) % n] < age && back + 1 < n) {
    later = later + given.time[(given.last + n - back) % n];
    ++back;
  }
  S left = age;
  while (S(0) < left) {
    observer_carry(vessel, state, given.tau[(given.last + n - back) % n], left - later);
    left = later;
    if (back == 0) return;
    --back;
    later = max(later - given.time[(given.last + n - back) % n], S(0));
  }
}

/// k: the weight of a fix that came dt after the previous one.
template <class S>
S share_of_fix(const ObserverParams<S>& params, S dt) {
  return S(0) < params.omega ? dt / (dt + params.T) : S(1);
}

/// Integrates the innovation of a fix into the unknown force and the current; k: the fix's weight.
template <class S>
void observer_learn(const ObserverParams<S>& params, const Vessel<S>& m, Observer<S>& state,
                    const Nu<S>& innovation, S k, S dt) {
  const auto gain_of = [&](S omega) { return k * omega / (S(1) + omega * dt); };
  const auto learnt_of = [](S omega, S gain, S b, S off, Carry<S>& rest) {
    return S(0) < omega ? b + rest.take(gain, off) : S(0);  // off: b is not estimated
  };
  // The current integrates b_v, which must therefore be much faster.
  const S omega_v = max(params.omega, S(10) * params.omega_c);
  const S gain = gain_of(params.omega), gain_v = gain_of(omega_v);
  const Nu<S> b = {learnt_of(params.omega, gain, state.b.u, innovation.u, state.b_rest.u),
                   learnt_of(omega_v, gain_v, state.b.v, innovation.v, state.b_rest.v),
                   learnt_of(params.omega, gain, state.b.r, innovation.r, state.b_rest.r)};
  state.b = bounded(b, params.b_max);
  if (!(S(0) < params.omega_c)) {
    state.c_n = {};
    return;
  }
  const S off = m.m22_d22 * state.b.v;
  const Vec2<S> off_n = to_north_east(state.motion.psi, Vec2<S>{S(0), off});
  const S share = params.omega_c * min(dt, S(1));
  const auto within = [&](S c) { return clamp(c, -params.c_max, params.c_max); };
  state.c_n = {within(state.c_n.x + state.c_rest.x.take(share, off_n.x)),
               within(state.c_n.y + state.c_rest.y.take(share, off_n.y))};
}

/// Takes a fix; the caller has predicted the state to now. The first fix, or one after a gap
/// (dt = 0), is taken as it is.
template <class S>
void observer_correct(const ObserverParams<S>& params, const Vessel<S>& vessel, Observer<S>& state,
                      const Fix<S>& fix) {
  const Motion<S> expected = state.motion;
  state.motion = {{}, fix.psi, fix.nu, expected.nu_dot};
  observer_replay(vessel, state, fix.age);
  if (!(S(0) < fix.dt)) {
    state.b = {};
    return;
  }
  const S k = share_of_fix(params, fix.dt);
  const Motion<S> measured = state.motion;
  const Nu<S> innovation = {measured.nu.u - expected.nu.u, measured.nu.v - expected.nu.v,
                            measured.nu.r - expected.nu.r};
  if (k < S(1)) {
    const S rest = S(1) - k;
    const S psi_off = wrap_pi(expected.psi - measured.psi);
    const Vec2<S> off = {fix.expected_n.x - measured.moved_n.x,
                         fix.expected_n.y - measured.moved_n.y};
    state.motion.moved_n = {measured.moved_n.x + state.moved_rest.x.take(rest, off.x),
                            measured.moved_n.y + state.moved_rest.y.take(rest, off.y)};
    state.motion.psi = measured.psi + state.psi_rest.take(rest, psi_off);
    state.motion.nu = {expected.nu.u + state.nu_rest.u.take(k, innovation.u),
                       expected.nu.v + state.nu_rest.v.take(k, innovation.v),
                       expected.nu.r + state.nu_rest.r.take(k, innovation.r)};
  }
  observer_learn(params, vessel, state, innovation, k, fix.dt);
}

/// The wrench equivalent to b.
template <class S>
Tau<S> unknown_wrench(const Vessel<S>& m, const Observer<S>& state) {
  return {m.m11 * state.b.u, m.m33 * state.b.r};
}

/// The motion `moment` seconds earlier; only for about a millisecond.
template <class S>
Motion<S> moment_before(Motion<S> motion, S moment) {
  const Vec2<S> way =
      to_north_east(motion.psi, Vec2<S>{moment * motion.nu.u, moment * motion.nu.v});
  motion.moved_n = {motion.moved_n.x - way.x, motion.moved_n.y - way.y};
  motion.psi = motion.psi - moment * motion.nu.r;
  return motion;
}

}  // namespace flotilla::core
