// SPDX-License-Identifier: MIT
// The vectors of the law, with the letters of Fossen and of the paper.
//
//  symbol        meaning                                          frame   unit
//  nu = [u v r]  velocity: surge, sway, yaw rate                  body    m/s, m/s, rad/s
//  tau = [X N]   wrench of the two propellers: surge, yaw         body    N, N m
//  e             formation error                                  body    m, m, rad
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

template <class S>
struct Error {
  S x{};
  S y{};
  S psi{};
};

}  // namespace flotilla::core
