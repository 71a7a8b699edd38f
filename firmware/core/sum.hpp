// SPDX-License-Identifier: MIT
// What an integrator adds to: x ← x + a b, where a b may be far below one LSB of the scalar.
//
//   Sum<S>     x itself
//   Sum<Q16>   x in 2⁻³² (64 bits): 0.1 m/s × 0.01 s is exact, 2³² additions lose nothing
//
// Q16.16: tested within ±1 (what is taken at once; the sum itself has 64 bits, seen where it is used)
#pragma once

#include <cstdint>
#include <limits>
#include <utility>

#include "core/fixed.hpp"

namespace flotilla::core {

template <class S>
class Sum {
 public:
  constexpr Sum() = default;
  constexpr explicit Sum(S x) : x_(x) {}

  constexpr S value() const { return x_; }
  constexpr void add(S a) { x_ = x_ + a; }
  constexpr void add(S a, S b) { x_ = x_ + a * b; }

  /// The value; what it does not say stays.
  constexpr S take() { return std::exchange(x_, S(0)); }

 private:
  S x_ = S(0);
};

/// The products are exact; only value() rounds, to nearest, and saturates where Q16 ends. The sum
/// itself ends at ±2³¹. Both raise q16_overflow.
template <>
class Sum<Q16> {
 public:
  constexpr Sum() = default;
  constexpr explicit Sum(Q16 x) : raw_(x.raw() * kOne) {}

  constexpr Q16 value() const { return Q16::of_raw(Q16::saturated(Q16::halved(raw_, 16))); }
  constexpr void add(Q16 a) { add_raw(a.raw() * kOne); }
  constexpr void add(Q16 a, Q16 b) { add_raw(std::int64_t{a.raw()} * b.raw()); }
  constexpr Q16 take() {
    const Q16 whole = value();
    raw_ -= whole.raw() * kOne;
    return whole;
  }

 private:
  static constexpr std::int64_t kOne = 65536;

  constexpr void add_raw(std::int64_t raw) {
    if (!__builtin_add_overflow(raw_, raw, &raw_)) return;
    q16_overflow = true;
    raw_ = raw < 0 ? std::numeric_limits<std::int64_t>::min()
                   : std::numeric_limits<std::int64_t>::max();
  }

  std::int64_t raw_ = 0;
};

/// What a product adds to a number of the scalar's own bits, and what is left for the next time.
template <class S>
class Carry {
 public:
  constexpr S take(S a, S b) {
    sum_.add(a, b);
    return sum_.take();
  }

 private:
  Sum<S> sum_{};  // at most half an LSB
};

}  // namespace flotilla::core
