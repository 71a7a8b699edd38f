// SPDX-License-Identifier: MIT
// A 32-bit fixed-point scalar with 16 fraction bits: the same bits on every machine, without
// floating-point instructions.
//
//   value = raw / 2¹⁶      −32768 … 32767.99998      one LSB = 1.5e-5
//
// +, −, ×, / are correctly rounded, to nearest, ties to even, so that a boat and its mirror image
// sail alike. Results beyond the range saturate and set q16_overflow until take_overflow() clears
// it: a saturated number is wrong, but has the right sign and never wraps.
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/scalar/fixed_integer.hpp"
#include "core/scalar/fixed_sum.hpp"
#include "core/scalar/scalar.hpp"

namespace flotilla::core {

class Q16 {
 public:
  constexpr Q16() = default;

  template <std::integral T>
  [[gnu::always_inline]] constexpr explicit Q16(T whole) {
    if (__builtin_mul_overflow(whole, kOne, &raw_)) raw_ = fixed::end(std::cmp_less(whole, 0));
  }

  /// Compile-time literals only; one that is out of range does not compile.
  template <std::floating_point T>
  consteval explicit Q16(T literal) : raw_(nearest(literal)) {}

  static constexpr Q16 of_raw(std::int32_t raw) {
    Q16 x;
    x.raw_ = raw;
    return x;
  }
  constexpr std::int32_t raw() const { return raw_; }

  [[gnu::always_inline]] friend constexpr Q16 operator-(Q16 a) { return Q16{} - a; }
  [[gnu::always_inline]] friend constexpr Q16 operator+(Q16 a, Q16 b) {
    return of_raw(fixed::sum(a.raw_, b.raw_));
  }
  [[gnu::always_inline]] friend constexpr Q16 operator-(Q16 a, Q16 b) {
    return of_raw(fixed::difference(a.raw_, b.raw_));
  }
  [[gnu::always_inline]] friend constexpr Q16 operator*(Q16 a, Q16 b) {
    return rounded(std::int64_t{a.raw_} * b.raw_);
  }
  /// Division by zero saturates with the sign of a; 0 / 0 = 0. Both set q16_overflow.
  friend constexpr Q16 operator/(Q16 a, Q16 b) {
    const std::uint64_t n = std::uint64_t{fixed::magnitude(a.raw_)} << 16;
    return quotient(n, fixed::magnitude(b.raw_), (a.raw_ < 0) != (b.raw_ < 0));
  }

  // A sum of two products that fits stays some 2³¹ below the end: rounding cannot wrap either.
  [[gnu::always_inline]] friend constexpr Q16 sum_of_products(Q16 a, Q16 b, Q16 c, Q16 d) {
    const std::int64_t first = std::int64_t{a.raw_} * b.raw_;
    std::int64_t sum = 0;
    const bool wraps = __builtin_add_overflow(first, std::int64_t{c.raw_} * d.raw_, &sum);
    return wraps ? of_raw(fixed::end(first < 0)) : rounded(sum);
  }
  [[gnu::always_inline]] friend constexpr Q16 difference_of_products(Q16 a, Q16 b, Q16 c, Q16 d) {
    const std::int64_t first = std::int64_t{a.raw_} * b.raw_;
    std::int64_t difference = 0;
    const bool wraps = __builtin_sub_overflow(first, std::int64_t{c.raw_} * d.raw_, &difference);
    return wraps ? of_raw(fixed::end(first < 0)) : rounded(difference);
  }

  friend constexpr bool operator==(Q16 a, Q16 b) = default;
  [[gnu::always_inline]] friend constexpr auto operator<=>(Q16 a, Q16 b) {
    return a.raw_ <=> b.raw_;
  }

  /// x / 2ⁿ, n < 32, to nearest, ties to even.
  static constexpr std::int64_t halved(std::int64_t x, int n) {
    const std::int64_t whole = x >> n;
    const std::uint32_t odd = static_cast<std::uint32_t>(whole) & 1;
    const std::uint32_t rest = static_cast<std::uint32_t>(x) & ((1U << n) - 1);
    return whole + ((rest + odd + (1U << (n - 1)) - 1) >> n);
  }

  /// x / 2¹⁶ for |x| < 2⁶³ − 2¹⁶, which every product satisfies; does not wrap.
  static constexpr Q16 rounded(std::int64_t x) {
    const std::uint32_t odd = static_cast<std::uint32_t>(x) >> 16 & 1;
    const std::int64_t raw = (x + (0x7FFF + odd)) >> 16;
    const auto same = static_cast<std::int32_t>(raw);
    if (same == raw) [[likely]]
      return of_raw(same);
    return of_raw(fixed::end(x < 0));
  }

  /// The nearest raw value in range.
  [[gnu::always_inline]] static constexpr std::int32_t saturated(std::int64_t raw) {
    const auto same = static_cast<std::int32_t>(raw);
    if (same == raw) [[likely]]
      return same;
    return fixed::end(raw < 0);
  }

  /// ±n / d of raw values.
  [[gnu::always_inline]] static constexpr Q16 quotient(std::uint64_t n, std::uint32_t d,
                                                       bool negative) {
    if (n >> 32 >= d) {  // 2³² or more, or by zero
      const std::int32_t most = fixed::end(negative);
      return of_raw(n == 0 ? 0 : most);
    }
    const bool is_short = n >> 32 == 0;  // |a| < 1: one division suffices
    const int zeros = is_short ? 0 : std::countl_zero(d);
    const auto [whole, rest] = is_short ? fixed::divided(static_cast<std::uint32_t>(n), d)
                                        : fixed::divided(n << zeros, d << zeros);
    // rest > d − rest instead of 2 rest > d, which may wrap
    const std::uint32_t other = (d << zeros) - rest;
    const std::uint32_t up = rest > other || (rest == other && (whole & 1) != 0) ? 1 : 0;
    const std::uint32_t rounded = whole + up;
    // 2³¹ or more, or 2³²: the sum wraps to 0
    if (rounded >> 31 != 0 || rounded < whole) {
      return of_raw(saturated((std::int64_t{whole} + up) * (negative ? -1 : 1)));
    }
    const auto raw = static_cast<std::int32_t>(rounded);
    return of_raw(negative ? -raw : raw);
  }

 private:
  static constexpr std::int32_t kOne = 65536;

  template <std::floating_point T>
  static consteval std::int32_t nearest(T literal) {
    const double twice = double{literal} * 131072;
    // An out-of-range conversion is not a constant expression, so that it does not compile.
    return static_cast<std::int32_t>((twice + (twice < 0 ? -1 : 1)) / 2);
  }

  std::int32_t raw_ = 0;
};

/// Angles in rad; results within one LSB of the true value for the given argument.
constexpr Q16 sin(Q16 x);
constexpr Q16 cos(Q16 x);
constexpr SinCos<Q16> sin_cos(Q16 x);
constexpr Q16 atan(Q16 x);
constexpr Q16 atan2(Q16 y, Q16 x);
constexpr Q16 tanh(Q16 x);
constexpr Q16 exp(Q16 x);   ///< overflows above ln 32768
constexpr Q16 sqrt(Q16 x);  ///< negative numbers give 0 and overflow
constexpr Q16 abs(Q16 x) { return x < Q16{} ? -x : x; }
/// Overflows above 32767.
constexpr Q16 ceil(Q16 x) {
  return Q16::of_raw(Q16::saturated(((std::int64_t{x.raw()} + 65535) >> 16) * 65536));
}
/// √(x² + y²), √(x² + y² + z²), rounded once; the squares may be out of range.
constexpr Q16 hypot(Q16 x, Q16 y);
constexpr Q16 hypot(Q16 x, Q16 y, Q16 z);
/// a b / c, rounded once; c = 0 as in a division.
constexpr Q16 scaled(Q16 a, Q16 b, Q16 c);

}  // namespace flotilla::core

#include "core/scalar/fixed_functions.hpp"  // IWYU pragma: export
