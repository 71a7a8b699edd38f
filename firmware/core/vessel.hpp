// SPDX-License-Identifier: MIT
// The law's model of its boat: M ν̇ + C(ν) ν + D ν = [X 0 N]ᵀ with diagonal M and D.
//
//  symbol         meaning                                    unit           tested range
//  m11, m22, m33  inertia with added mass: surge, sway, yaw  kg, kg, kg m²  0.1 … 500
//  d11, d22, d33  linear damping: surge, sway, yaw           kg/s, kg/s, kg m²/s
//  a_b            the quotient a / b
//
// Source: paper (eq:1b); the simulated hull has a model of its own.
//
// Q16.16: tested within ±1,000 (damping, kg/s)
#pragma once

namespace flotilla::core {

/// a / b; 0 for b ≤ 0, as in a default vessel.
template <class S>
constexpr S quotient_of(S a, S b) {
  return S(0) < b ? a / b : S(0);
}

/// Do not change a member after construction: the quotients would no longer match.
template <class S>
struct Vessel {
  constexpr Vessel() = default;
  constexpr Vessel(S m11_, S m22_, S m33_, S d11_, S d22_, S d33_)
      : m11(m11_), m22(m22_), m33(m33_), d11(d11_), d22(d22_), d33(d33_) {}

  S m11{};
  S m22{};
  S m33{};
  S d11{};
  S d22{};
  S d33{};

  S d11_m11 = quotient_of(d11, m11);
  S d22_m22 = quotient_of(d22, m22);
  S d33_m33 = quotient_of(d33, m33);
  S m11_m22 = quotient_of(m11, m22);
  S m11_d22 = quotient_of(m11, d22);
  S m22_d22 = quotient_of(m22, d22);
};

}  // namespace flotilla::core
