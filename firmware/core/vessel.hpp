// SPDX-License-Identifier: MIT
// What the law knows of its boat: M ν̇ + C(ν) ν + D ν = [X 0 N]ᵀ with diagonal M and D.
//
//  symbol         meaning                                    unit           tested range
//  m11, m22, m33  inertia with added mass: surge, sway, yaw  kg, kg, kg m²  0.1 … 500
//  d11, d22, d33  linear damping: surge, sway, yaw           kg/s, kg/s, kg m²/s
//
// Source: paper (eq:1b); the simulated hull has a model of its own.
#pragma once

namespace flotilla::core {

template <class S>
struct Vessel {
  S m11{};
  S m22{};
  S m33{};
  S d11{};
  S d22{};
  S d33{};
};

}  // namespace flotilla::core
