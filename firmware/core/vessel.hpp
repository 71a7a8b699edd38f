// SPDX-License-Identifier: MIT
// The law's model of its boat: M ν̇ + C(ν) ν + D(u) ν = [X 0 N]ᵀ with diagonal M and D.
//
//   D(u) = diag( d11 + d11q |u|,  d22,  d33 + d33u |u| )
//
//  symbol         meaning                                    unit           tested range
//  m11, m22, m33  inertia with added mass: surge, sway, yaw  kg, kg, kg m²  0.1 … 500
//  d11, d22, d33  linear damping: surge, sway, yaw           kg/s, kg/s, kg m²/s
//  d11q           quadratic drag ahead                       kg/m           0 … 500
//  d33u           yaw damping that grows with speed          kg m           0 … 500
//  a_b            the quotient a / b
//
// Source: paper (eq:1b), whose D is constant; the simulated hull has a model of its own. Not in
// paper: d11q and d33u. While a hull turns, a strip of it x metres ahead of the centre moves abeam
// by x r; at speed u that gives it a lift proportional to |u| x r, and all strips together a moment
// proportional to |u| r ∫ x² dx against the turn.
//
// Q16.16: tested within ±1,000 (damping, kg/s)
#pragma once

#include "core/scalar/scalar.hpp"

namespace flotilla::core {

/// a / b; 0 for b ≤ 0, as b is in a default-constructed vessel.
template <class S>
constexpr S quotient_of(S a, S b) {
  return S(0) < b ? a / b : S(0);
}

/// Do not change a member after construction: the quotients would no longer match.
template <class S>
struct Vessel {
  constexpr Vessel() = default;
  constexpr Vessel(S m11_, S m22_, S m33_, S d11_, S d22_, S d33_, S d11q_ = S{}, S d33u_ = S{})
      : m11(m11_),
        m22(m22_),
        m33(m33_),
        d11(d11_),
        d22(d22_),
        d33(d33_),
        d11q(d11q_),
        d33u(d33u_) {}

  S m11{};
  S m22{};
  S m33{};
  S d11{};
  S d22{};
  S d33{};
  S d11q{};
  S d33u{};

  S d11_m11 = quotient_of(d11, m11);
  S d22_m22 = quotient_of(d22, m22);
  S d33_m33 = quotient_of(d33, m33);
  S m11_m22 = quotient_of(m11, m22);
  S m11_d22 = quotient_of(m11, d22);
  S m22_d22 = quotient_of(m22, d22);
  S d11q_m11 = quotient_of(d11q, m11);
  S d33u_m33 = quotient_of(d33u, m33);
};

/// Damping at speed u through the water.
template <class S>
S surge_damping(const Vessel<S>& m, S u) {
  return m.d11 + m.d11q * abs(u);
}

template <class S>
S yaw_damping(const Vessel<S>& m, S u) {
  return m.d33 + m.d33u * abs(u);
}

}  // namespace flotilla::core
