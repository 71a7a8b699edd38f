// SPDX-License-Identifier: MIT
// The arithmetic that the law is written in: any ordered field with sin, cos, atan, tanh, exp,
// sqrt, ceil.
//
// A literal enters only as S(0.5): the build rejects every other floating literal in this folder.
#pragma once

#include <cmath>

namespace flotilla::core {

// Found unqualified for float and double; a scalar of another type brings its own by ADL.
using std::abs;
using std::atan;
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

template <class S>
constexpr S smaller(S a, S b) {
  return b < a ? b : a;
}

template <class S>
constexpr S larger(S a, S b) {
  return a < b ? b : a;
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
