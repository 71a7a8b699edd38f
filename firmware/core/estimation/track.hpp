// SPDX-License-Identifier: MIT
// Tracks a vessel between its messages: smooths heading, velocity and its two derivatives, and
// predicts the motion at a given age.
//
//   ν̂, ψ̂: the old state's prediction after Δt     p = Δt / (T + Δt)     q = Δt / (T_j + Δt)
//   α = 1 − (1 − p)² (1 − q)     β = p (p + 2q − 1.5 p q)     γ = p² q
//   ν ← ν̂ + α (ν − ν̂)      ν̇ ← ν̇̂ + β/Δt (ν − ν̂)      ν̈ ← ν̈ + γ/Δt² (ν − ν̂)      ψ ← ψ̂ + α (ψ − ψ̂)
//   ν(h) = ν + ν̇ h + ½ ν̈ h²,  ψ(h) = ψ + ∫ r,  ν̈ for at most 1 s
//   Δp(h) = h R(ψ(h/2)) [u v]ᵀ(h/2)
//   σ(h) = |[u v]| t + ½ a h²       a ← a + p ( |[u−û v−v̂]|/(Δt + T) + |u (r − r̂)| − a )
//
//  symbol   meaning                                    frame  unit        tested range
//  psi      heading                                    n      rad         ±π
//  nu       velocity over ground                       body   m/s, rad/s  ±20, ±4
//  nu_dot, nu_ddot  rates of change of the numbers in nu      m/s², rad/s², m/s³, rad/s³
//  dt       time between two messages                         s           0 … 10
//  h, age   time since the last message                       s           0 … 10
//  t        error of the sender's clock                       s
//  a        unpredicted acceleration                          m/s²
//  σ        uncertainty of the position                       m
//
// Not in paper: there the leader's u̇_L and ṙ_L are known, and the law turns an error of r_L into a
// heading error 1/k_ψ times as large. The three poles of the tracker lie at 1 − p, 1 − p, 1 − q for
// any interval of messages; it has no lag at constant jerk. T is twice the sum of the last two
// intervals, within limits: frequent messages track a sudden start at once, and two timestamps
// close together do not disturb the acceleration.
//
// Q16.16: tested within ±200 (rates of change of nu)
#pragma once

#include "core/rotation.hpp"

namespace flotilla::core {

template <class S>
struct TrackParams {
  S T = S(0.12);  ///< upper and lower limit of T
  S T_min = S(0.02);
  S T_j = S(1);
  S gap = S(2);       ///< the track restarts after a longer silence
  S a_min = S(0.05);  ///< least a: any vessel may accelerate unpredicted
};

template <class S>
struct TrackState {
  S psi{};
  Nu<S> nu{};
  Nu<S> nu_dot{};
  Nu<S> nu_ddot{};
  S dt{};  ///< between the last two messages; 0 after the first, or a gap
  S a{};
  bool started = false;
};

template <class S>
struct TrackMessage {
  S psi{};
  Nu<S> nu{};
  S dt{};
};

/// Motion at some age: displacement since the last message, heading, velocity, acceleration.
template <class S>
struct Motion {
  Vec2<S> moved_n{};
  S psi{};
  Nu<S> nu{};
  Nu<S> nu_dot{};
};

template <class S>
Nu<S> plus(const Nu<S>& a, S k, const Nu<S>& b) {
  return {a.u + k * b.u, a.v + k * b.v, a.r + k * b.r};
}

/// ν, ν̇ and ψ, h seconds after the last message.
template <class S>
Nu<S> track_velocity(const TrackState<S>& state, S h) {
  const S m = min(h, S(1));
  return plus(plus(state.nu, h, state.nu_dot), m * (h - S(0.5) * m), state.nu_ddot);
}
template <class S>
Nu<S> track_acceleration(const TrackState<S>& state, S h) {
  return plus(state.nu_dot, min(h, S(1)), state.nu_ddot);
}
template <class S>
S track_heading(const TrackState<S>& state, S h) {
  const S half = S(0.5) * h;
  const S m = min(h, S(1));
  const S twice = m * (half * (h - m) + S(0.16666666666666667) * m * m);
  return state.psi + h * (state.nu.r + half * state.nu_dot.r) + twice * state.nu_ddot.r;
}

/// The motion `age` seconds after the last message.
template <class S>
Motion<S> track_forward(const TrackState<S>& state, S age) {
  const S half = S(0.5) * age;
  const Nu<S> middle = track_velocity(state, half);
  const Vec2<S> way =
      to_north_east(track_heading(state, half), Vec2<S>{middle.u * age, middle.v * age});
  return {way, track_heading(state, age), track_velocity(state, age),
          track_acceleration(state, age)};
}

/// Uncertainty of track_forward()'s position, m; t: error of the sender's clock, s.
template <class S>
S track_uncertainty(const TrackState<S>& state, S age, S t) {
  const S speed = hypot(state.nu.u, state.nu.v);
  return speed * t + S(0.5) * state.a * age * age;
}

/// Takes a message that is dt seconds newer than the previous one.
template <class S>
void track_update(const TrackParams<S>& params, TrackState<S>& state, const TrackMessage<S>& in) {
  const auto& [psi, nu, dt] = in;
  if (!state.started || !(S(0) < dt) || !(dt < params.gap)) {
    state = TrackState<S>{};
    state.psi = psi;
    state.nu = nu;
    state.a = params.a_min;
    state.started = true;
    return;
  }
  const S psi_hat = track_heading(state, dt);
  const Nu<S> nu_hat_dot = track_acceleration(state, dt);
  const Nu<S> nu_hat = track_velocity(state, dt);
  const Nu<S> off = {nu.u - nu_hat.u, nu.v - nu_hat.v, nu.r - nu_hat.r};
  const S T = clamp(S(2) * (dt + state.dt), params.T_min, params.T);
  const S p = dt / (T + dt);
  const S q = dt / (params.T_j + dt);
  const S kept = (S(1) - p) * (S(1) - p) * (S(1) - q);  // 1 − α
  const S beta = p * (p + S(2) * q - S(1.5) * p * q);
  const S gamma = p * p * q;
  const S unforeseen = hypot(off.u, off.v) / (dt + params.T) + abs(nu.u * off.r);
  state.psi = psi - kept * wrap_pi(psi - psi_hat);
  state.nu = plus(nu, -kept, off);
  state.nu_dot = plus(nu_hat_dot, beta / dt, off);
  // In Q16 both are 0 for messages less than 3 ms apart.
  if (const S square = dt * dt; S(0) < square) {
    state.nu_ddot = plus(state.nu_ddot, gamma / square, off);
  }
  state.dt = dt;
  state.a = max(state.a + p * (unforeseen - state.a), params.a_min);
}

/// Takes a message of another source, dt seconds newer than the last one. Keeps the old
/// derivatives, because the two sources differ by their errors, not by an acceleration.
template <class S>
void track_resume(const TrackParams<S>& params, TrackState<S>& state, const TrackMessage<S>& in) {
  const bool near = state.started && S(0) < in.dt && in.dt < params.gap;
  if (!near) state = {};
  state.psi = in.psi;
  state.nu = in.nu;
  state.dt = near ? in.dt : S(0);
  state.a = max(state.a, params.a_min);
  state.started = true;
}

}  // namespace flotilla::core
