// SPDX-License-Identifier: MIT
// The arithmetic of the law: any ordered field with sin, cos, atan, atan2, tanh, exp, sqrt, ceil.
// Large values must not be squared: a scalar's range may end at ±32768.
//
// A literal enters only as S(0.5): the build rejects every other floating literal in this folder.
//
// Q16.16: tested within ±500 (ratio_within, wrap_pi)
#pragma once

#include <cmath>

namespace flotilla::core {

// Found unqualified for float and double; a scalar of another type brings its own by ADL.
using std::abs;
using std::atan;
using std::atan2;
using std::ceil;
using std::cos;
using std::exp;
using std::sin;
using std::sqrt;
using std::tanh;

template <class S>
constexpr S clamp(S x, S low, S high) {
  return x < low ? low : (high < x ? high : x);
}

// Objects, not functions, so that argument-dependent lookup does not find them: Eigen's calls for
// our scalars then find std's.
inline constexpr auto min = []<class S>(S a, S b) -> S { return b < a ? b : a; };
inline constexpr auto max = []<class S>(S a, S b) -> S { return a < b ? b : a; };

/// √(x² + y²), √(x² + y² + z²); a scalar whose squares may overflow has its own.
template <class S>
S hypot(S x, S y) {
  return sqrt(x * x + y * y);
}
template <class S>
S hypot(S x, S y, S z) {
  return sqrt(x * x + y * y + z * z);
}

/// a b ± c d; Q16 rounds once.
template <class S>
constexpr S sum_of_products(S a, S b, S c, S d) {
  return a * b + c * d;
}
template <class S>
constexpr S difference_of_products(S a, S b, S c, S d) {
  return a * b - c * d;
}

template <class S>
struct SinCos {
  S sin{}, cos{};
};
template <class S>
SinCos<S> sin_cos(S angle) {
  return {sin(angle), cos(angle)};
}

/// a b/c; Q16 rounds once, so that b/c keeps the bits that the product needs.
template <class S>
S scaled(S a, S b, S c) {
  return a * (b / c);
}

/// a/b limited to ±most, also where a/b would overflow; b > 0.
template <class S>
S ratio_within(S a, S b, S most) {
  if (abs(a) / most < b) return clamp(a / b, -most, most);
  return a < S(0) ? -most : most;
}

/// Angle in (−π, π], rad, for any finite angle.
template <class S>
S wrap_pi(S angle) {
  const S pi = S(3.14159265358979323846);
  const S two_pi = S(6.28318530717958647693);
  if (-pi < angle && angle <= pi) return angle;
  return angle - two_pi * ceil((angle - pi) / two_pi);
}

}  // namespace flotilla::core
