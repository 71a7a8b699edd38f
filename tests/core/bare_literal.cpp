// SPDX-License-Identifier: MIT
// Core-like code; compiles with -DHALF=S(0.5) only. See tests/CMakeLists.txt.
#include "core/strict_scalar.hpp"

template <class S>
S half(S x) {
  return x * HALF;
}

template flotilla::testing::Strict half(flotilla::testing::Strict);
