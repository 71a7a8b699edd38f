// SPDX-License-Identifier: MIT
// Q16 as a scalar of Eigen's matrices; requires Eigen.
#pragma once

#include <Eigen/Core>

#include "core/scalar/fixed.hpp"

namespace flotilla::core {

constexpr Q16& operator+=(Q16& a, Q16 b) { return a = a + b; }
constexpr Q16& operator-=(Q16& a, Q16 b) { return a = a - b; }
constexpr Q16& operator*=(Q16& a, Q16 b) { return a = a * b; }
constexpr Q16& operator/=(Q16& a, Q16 b) { return a = a / b; }

}  // namespace flotilla::core

template <>
struct Eigen::NumTraits<flotilla::core::Q16> : Eigen::GenericNumTraits<flotilla::core::Q16> {
  using Q16 = flotilla::core::Q16;
  enum { IsInteger = 0, IsSigned = 1, RequireInitialization = 1, AddCost = 3, MulCost = 13 };

  static constexpr Q16 epsilon() { return Q16::of_raw(1); }
  /// Tolerance of isApprox: 16 LSB.
  static constexpr Q16 dummy_precision() { return Q16::of_raw(16); }
  static constexpr Q16 lowest() { return Q16::of_raw(std::numeric_limits<std::int32_t>::min()); }
  static constexpr Q16 highest() { return Q16::of_raw(std::numeric_limits<std::int32_t>::max()); }
  static constexpr int digits() { return 31; }
  static constexpr int digits10() { return 4; }
};
