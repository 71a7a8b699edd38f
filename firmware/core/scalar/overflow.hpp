// SPDX-License-Identifier: MIT
// Whether the arithmetic has left its range: what came out of it then is saturated, and wrong.
#pragma once

#include <utility>

#include "core/scalar/fixed.hpp"

namespace flotilla::core {

/// Some result of this thread was out of the scalar's range since the last call. Never of float and
/// double: theirs is wider than any number of a boat.
template <class S>
bool take_overflow() {
  return false;
}
template <>
inline bool take_overflow<Q16>() {
  return std::exchange(q16_overflow, false);
}

}  // namespace flotilla::core
