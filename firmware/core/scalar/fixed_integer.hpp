// SPDX-License-Identifier: MIT
// Integer arithmetic for fixed.hpp and fixed_functions.hpp, cheap where 32 × 32 → 64 bits is one
// instruction and a 64-bit division is a long function.
#pragma once

#include <bit>
#include <cstdint>

namespace flotilla::core::fixed {

constexpr std::uint32_t high(std::uint64_t x) { return static_cast<std::uint32_t>(x >> 32); }
constexpr std::uint32_t low(std::uint64_t x) { return static_cast<std::uint32_t>(x); }

/// a b / 2³²
constexpr std::uint32_t high_product(std::uint32_t a, std::uint32_t b) {
  return high(std::uint64_t{a} * b);
}

constexpr std::uint32_t magnitude(std::int32_t x) {
  const auto bits = static_cast<std::uint32_t>(x);
  return x < 0 ? 0U - bits : bits;
}

struct Quotient {
  std::uint32_t whole, rest;
};

/// n / d, with one division and one product.
constexpr Quotient divided(std::uint32_t n, std::uint32_t d) { return {n / d, n % d}; }

/// One digit of base 2¹⁶ of n / d, n < 2¹⁶ d, d ≥ 2³¹. Schoolbook: the estimate from the leading
/// digit of d is never too low, and at most 2 too high.
[[gnu::always_inline]] constexpr Quotient digit(std::uint64_t n, std::uint32_t d) {
  std::uint32_t q = static_cast<std::uint32_t>(n >> 16) / (d >> 16);
  auto rest = static_cast<std::int64_t>(n - std::uint64_t{q} * d);
  while (rest < 0) {
    rest += d;
    --q;
  }
  return {q, static_cast<std::uint32_t>(rest)};
}

/// n / d, exactly, for n < 2³² d, d ≥ 2³¹.
[[gnu::always_inline]] constexpr Quotient divided(std::uint64_t n, std::uint32_t d) {
  const Quotient upper = digit(n >> 16, d);
  const Quotient lower = digit(std::uint64_t{upper.rest} << 16 | (n & 0xFFFF), d);
  return {upper.whole << 16 | lower.whole, lower.rest};
}

/// The integer nearest to √n, for n ≤ 2⁶³.
constexpr std::uint32_t root(std::uint64_t n) {
  if (n == 0) return 0;
  const int doublings = std::countl_zero(n) / 2;
  const std::uint64_t m = n << (2 * doublings);
  // 1/√f of f = m / 2⁶⁴ in [¼, 1): a parabola within 2.5 %, then Newton's y (3 − f y²) / 2 twice. f
  // in 2⁻³², y in 2⁻³⁰.
  const auto f = static_cast<std::uint32_t>(m >> 32);
  std::uint32_t y = 2867836833U - high_product(f, 3527762216U - high_product(f, 1759486127U));
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t twice = (3U << 28) - high_product(f, high_product(y, y));
    y = static_cast<std::uint32_t>((std::uint64_t{y} * twice) >> 29);
  }
  // s = √m within 2⁻¹⁸ of it; s + (m − s²) / 2s within one half.
  std::uint64_t s = (std::uint64_t{f} * y) >> 30;
  const auto rest = static_cast<std::int64_t>(m - s * s);
  s += static_cast<std::uint64_t>(((rest >> 16) * y + (std::int64_t{1} << 46)) >> 47);
  std::uint64_t r = (s + ((1U << doublings) >> 1)) >> doublings;
  // Nearest is r where r² − r < n ≤ r² + r.
  if (r * r - r >= n) --r;
  if (r * r + r < n) ++r;
  return static_cast<std::uint32_t>(r);
}

}  // namespace flotilla::core::fixed
