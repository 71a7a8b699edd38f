// SPDX-License-Identifier: MIT
// The increment of an integrator, x ← x + a b, where a b may be far below one LSB of the scalar.
//
//   Carry<S>     a b
//   Carry<Q16>   a b to the nearest LSB; the remainder goes into the next call, so that
//                0.1 m/s × 0.01 s is exact in the long run
//
// Q16.16: tested within ±1 (what is taken at once)
#pragma once

#include <cstdint>

#include "core/scalar/fixed.hpp"

namespace flotilla::core {

template <class S>
class Carry {
 public:
  constexpr S take(S a, S b) { return a * b; }
};

template <>
class Carry<Q16> {
 public:
  constexpr Q16 take(Q16 a, Q16 b) {
    const std::int64_t sum = std::int64_t{a.raw()} * b.raw() + rest_;  // |a b| ≤ 2⁶²
    const Q16 whole = Q16::rounded(sum);
    rest_ = static_cast<std::int32_t>(static_cast<std::uint32_t>(sum) -
                                      (static_cast<std::uint32_t>(whole.raw()) << 16));
    return whole;
  }

 private:
  std::int32_t rest_ = 0;  // in 2⁻³², at most half an LSB; arbitrary after an overflow
};

}  // namespace flotilla::core
