// SPDX-License-Identifier: MIT
// Whether the arithmetic has overflowed: results are then saturated, and wrong.
#pragma once

#include <utility>

#include "core/scalar/fixed.hpp"

namespace flotilla::core {

/// Whether a result in this thread has saturated since the last call. Always false for float and
/// double, whose range exceeds any quantity of a boat.
template <class S>
bool take_overflow() {
  return false;
}
template <>
inline bool take_overflow<Q16>() {
  const bool in_sum = fixed::take_saturation();
  return std::exchange(q16_overflow, false) || in_sum;
}

}  // namespace flotilla::core
