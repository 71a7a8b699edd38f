// SPDX-License-Identifier: MIT
// A corner of a route: the curve from one straight leg to the next, with continuous curvature: a
// clothoid, an arc, a clothoid.
//
//   θ = ½ |Δ|      θ_c = min(θ, θ_0)      L = 2 R (θ + θ_c)      L_c = 2 R θ_c
//   κ(s) = min(x/(R L_c), 1/R), x = min(s, L − s)      curvature at the distance s
//   χ(s) = x²/(2 R L_c), then θ_c + (x − L_c)/R        course turned in the first half
//   X = R (2 θ_c ∫ cos(θ_c y²) dy + sin θ − sin θ_c)   half of the curve, along and across the leg
//   Y = R (2 θ_c ∫ sin(θ_c y²) dy + cos θ_c − cos θ)   y = 0 … 1
//   T = X + Y tan θ        from the curve's beginning to the waypoint
//   C = Y/cos θ            from the waypoint to the curve
//
//  symbol  meaning                                             unit   tested range
//  Δ       change of course                                    rad    ±2.8
//  θ_0     turn of each clothoid in a sharp corner             rad    0 … 1
//  R       radius of the arc                                   m      0 … 500
//
// Not in paper, where the virtual leader's input is given. The clothoids keep the yaw acceleration
// finite: r = κ u, ṙ = u²/(R L_c) at a constant speed u.
//
// Q16.16: tested within ±1500 (T, m)
#pragma once

#include "core/scalar/scalar.hpp"
#include "core/types.hpp"

namespace flotilla::core {

/// T, C and L of a corner of radius 1.
template <class S>
struct CornerShape {
  S theta{};
  S clothoid{};  ///< θ_c
  S tangent{};
  S cut{};
};

/// |Δ| < π − 0.5; theta_0 within 0 … 1.
template <class S>
CornerShape<S> corner_shape(S turn, S theta_0) {
  const S theta = S(0.5) * abs(turn);
  const S c = min(theta, theta_0);
  const S c2 = c * c;
  // First terms of the integrals' series; the remainder is below 2e-6 at θ_c = 1.
  const S along = S(1) - c2 * (S(0.1) - c2 * (S(0.00462962963) - c2 * S(0.000106837607)));
  const S across =
      c * (S(0.33333333333333333) -
           c2 * (S(0.0238095238) - c2 * (S(0.000757575758) - c2 * S(0.0000132275132))));
  const auto [sin_theta, cos_theta] = sin_cos(theta);
  const auto [sin_c, cos_c] = sin_cos(c);
  const S x = S(2) * c * along + (sin_theta - sin_c);
  const S y = S(2) * c * across + (cos_c - cos_theta);
  return {theta, c, x + y * (sin_theta / cos_theta), y / cos_theta};
}

template <class S>
struct Corner {
  S turn{};  ///< Δ, to starboard positive
  S R{};
  S tangent{};   ///< T
  S clothoid{};  ///< L_c
  S length{};    ///< L
};

template <class S>
Corner<S> corner_of(const CornerShape<S>& shape, S turn, S R) {
  return {turn, R, R * shape.tangent, S(2) * R * shape.clothoid,
          S(2) * R * (shape.theta + shape.clothoid)};
}

/// κ(s), to starboard positive.
template <class S>
S curvature(const Corner<S>& corner, S s) {
  const S x = min(s, corner.length - s);
  const S share = x < corner.clothoid ? x / corner.clothoid : S(1);
  return (corner.turn < S(0) ? -share : share) / corner.R;
}

/// Course at the distance s, relative to the course at the beginning.
template <class S>
S turned(const Corner<S>& corner, S s) {
  const bool first = s < corner.length - s;
  const S x = first ? s : corner.length - s;
  const S chi = x < corner.clothoid ? S(0.5) * (x / corner.clothoid) * (x / corner.R)
                                    : (x - S(0.5) * corner.clothoid) / corner.R;
  const S half = corner.turn < S(0) ? -chi : chi;
  return first ? half : corner.turn - half;
}

}  // namespace flotilla::core
