// SPDX-License-Identifier: MIT
// A vessel's motion between its messages: heading and velocity of the last one, an estimate of its
// acceleration, and where all that leads after a given age.
//
//   ν̇̂ ← ν̇̂ + (Δν − ν̇̂ Δt) / (Δt + T + age)    first-order lag on the difference quotient Δν/Δt
//   ν(h) = ν + ν̇̂ h       ψ(h) = ψ + r h + ½ ṙ h²       Δp(h) = h R(ψ(h/2)) [u v]ᵀ(h/2)
//
//  symbol   meaning                                    frame  unit        tested range
//  psi      heading                                    n      rad         ±π
//  nu       velocity over ground                       body   m/s, rad/s  ±20, ±4
//  nu_dot   rate of change of the three numbers in nu  body   m/s², rad/s²
//  dt       time between two messages                         s           0 … 10
//  age      time since the last message                       s           0 … 10
//
// Not in paper: there the leader's u̇_L and ṙ_L are known. Dividing by Δt + T, not by Δt, keeps the
// estimate bounded by Δν/T for any spacing of messages. What is carried far forward must be smooth:
// noise in ν̇̂ counts `age` times, and each follower hands its share on to the next.
#pragma once

#include "core/rotation.hpp"

namespace flotilla::core {

template <class S>
struct TrackParams {
  S lag_s = S(0.02);  ///< T, beside the message's age
  S gap_s = S(2);     ///< After a longer silence the old acceleration says nothing.
};

template <class S>
struct TrackState {
  S psi{};
  Nu<S> nu{};
  Nu<S> nu_dot{};
  S dt{};  ///< between the last two messages; 0 after the first, or a gap
  bool started = false;
};

template <class S>
struct TrackMessage {
  S psi{};
  Nu<S> nu{};
  S dt{};
  S age{};
};

/// Motion at some age: displacement since the last message, heading, velocity, acceleration.
template <class S>
struct Motion {
  Vec2<S> moved_n{};
  S psi{};
  Nu<S> nu{};
  Nu<S> nu_dot{};
};

/// Takes a message that is dt seconds younger than the one before it, and was `age` old on arrival.
template <class S>
void track_update(const TrackParams<S>& params, TrackState<S>& state, const TrackMessage<S>& in) {
  const auto& [psi, nu, dt, age] = in;
  if (state.started && S(0) < dt && dt < params.gap_s) {
    const S gain = S(1) / (dt + params.lag_s + age);
    state.nu_dot.u = state.nu_dot.u + (nu.u - state.nu.u - state.nu_dot.u * dt) * gain;
    state.nu_dot.v = state.nu_dot.v + (nu.v - state.nu.v - state.nu_dot.v * dt) * gain;
    state.nu_dot.r = state.nu_dot.r + (nu.r - state.nu.r - state.nu_dot.r * dt) * gain;
    state.dt = dt;
  } else {
    state.nu_dot = Nu<S>{};
    state.dt = S(0);
  }
  state.psi = psi;
  state.nu = nu;
  state.started = true;
}

/// Takes a message of another source, whose state was true dt seconds after the last one's. What the
/// two say differs by their errors, which is no acceleration: the old one is kept.
template <class S>
void track_resume(const TrackParams<S>& params, TrackState<S>& state, const TrackMessage<S>& in) {
  const bool kept = state.started && S(0) < in.dt && in.dt < params.gap_s;
  state = {in.psi, in.nu, kept ? state.nu_dot : Nu<S>{}, kept ? in.dt : S(0), true};
}

/// The motion `age` seconds after the last message.
template <class S>
Motion<S> track_forward(const TrackState<S>& state, S age) {
  const auto velocity_at = [&](S h) {
    return Nu<S>{state.nu.u + state.nu_dot.u * h, state.nu.v + state.nu_dot.v * h,
                 state.nu.r + state.nu_dot.r * h};
  };
  const auto heading_at = [&](S h) {
    return state.psi + (state.nu.r + S(0.5) * state.nu_dot.r * h) * h;
  };
  const S half = S(0.5) * age;
  const Nu<S> middle = velocity_at(half);
  const Vec2<S> way = to_north_east(heading_at(half), Vec2<S>{middle.u * age, middle.v * age});
  return {way, heading_at(age), velocity_at(age), state.nu_dot};
}

}  // namespace flotilla::core
