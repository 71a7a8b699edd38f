// SPDX-License-Identifier: MIT
// The vectors of the law, with the letters of Fossen and of the paper.
//
//  symbol        meaning                                          frame   unit
//  nu = [u v r]  velocity: surge, sway, yaw rate                  body    m/s, m/s, rad/s
//  tau = [X N]   wrench of the two propellers: surge, yaw         body    N, N m
//  e             formation error                                  body    m, m, rad
//
// Q16.16: tested within ±500 (wrench, N)
#pragma once

namespace flotilla::core {

template <class S>
struct Vec2 {
  S x{};
  S y{};
};

template <class S>
struct Nu {
  S u{};
  S v{};
  S r{};
};

template <class S>
struct Tau {
  S X{};
  S N{};
};

/// ∫τ dt, and the time of integration, s.
template <class S>
struct Impulse {
  Tau<S> sum{};
  S time{};
};

template <class S>
void impulse_forward(Impulse<S>& state, const Tau<S>& tau, S h) {
  state.sum = {state.sum.X + h * tau.X, state.sum.N + h * tau.N};
  state.time = state.time + h;
}

template <class S>
struct Error {
  S x{};
  S y{};
  S psi{};
};

/// The limits that acted: 0, or a combination of these bits.
using Limits = unsigned;
constexpr Limits kSurgeLimit = 1U << 0U;    ///< of the propellers' thrust
constexpr Limits kYawLimit = 1U << 1U;      ///< of the propellers' moment
constexpr Limits kSpeedLimit = 1U << 2U;    ///< u_max
constexpr Limits kYawRateLimit = 1U << 3U;  ///< r_max
constexpr Limits kSlewLimit = 1U << 4U;     ///< of a command's change

}  // namespace flotilla::core
