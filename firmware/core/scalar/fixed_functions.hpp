// SPDX-License-Identifier: MIT
// The elementary functions of fixed.hpp, in integers; tools/fixed proves their errors.
//
// Each function reduces its argument to an interval where a short polynomial is within 2⁻²⁷ of the
// function, and rounds once. Polynomials are near minimax (Lawson's iteration); their terms
// alternate in sign or are all positive, so that unsigned products suffice. Odd functions are
// computed from |x|.
#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "core/scalar/fixed.hpp"
#include "core/scalar/fixed_integer.hpp"

namespace flotilla::core {

namespace fixed {

constexpr Q16 signed_as(Q16 x, std::uint32_t raw) {
  const auto positive = static_cast<std::int32_t>(raw);
  return Q16::of_raw(x.raw() < 0 ? -positive : positive);
}

/// |x| in quarter turns of 2³⁰, modulo a turn: |raw| 2⁴⁸ / 2π without its low 32 bits.
constexpr std::uint32_t phase(Q16 x) {
  return static_cast<std::uint32_t>((magnitude(x.raw()) * 44798133900177U) >> 32);
}

/// sin of a phase, within 2⁻²⁷, then rounded.
[[gnu::always_inline]] constexpr Q16 sine_of(std::uint32_t phase) {
  constexpr std::uint32_t kQuarter = 1U << 30;
  if (phase + kQuarter > 2 * kQuarter) phase = 2 * kQuarter - phase;
  const auto turned = Q16::of_raw(static_cast<std::int32_t>(phase));
  const std::uint32_t z = magnitude(turned.raw());
  // sin(½π z) = z (c0 − z² (c1 − …)), z² in 2⁻³¹, c_k in 2⁻³¹⁻ᵏ
  const std::uint64_t square = std::uint64_t{z} * z;  // used in halves: 32-bit steps suffice
  const std::uint32_t zz = high(square) << 3 | low(square) >> 29;
  std::uint32_t p = 5182123U;
  p = 80268224U - high_product(zz, p);
  p = 684518818U - high_product(zz, p);
  p = 2774391502U - high_product(zz, p);
  p = 3373259347U - high_product(zz, p);
  const std::uint64_t sine = std::uint64_t{z} * p + (std::uint64_t{1} << 44);
  return signed_as(turned, static_cast<std::uint32_t>(sine >> 45));
}

/// atan of q / 2³² ≤ √2 − 1, in 2⁻³⁰, within 2⁻²⁹
constexpr std::uint32_t atan_of(std::uint32_t q) {
  const std::uint32_t qq = high_product(q, q);
  std::uint32_t p = 250734973U;
  p = 450140103U - high_product(qq, p);
  p = 610923425U - high_product(qq, p);
  p = 858865637U - high_product(qq, p);
  p = 1431653094U - high_product(qq, p);
  p = 4294967280U - high_product(qq, p);
  return high_product(q, p) >> 2;
}

/// 2ⁿ m / 2⁶², m in [2⁶², 2⁶³)
struct Power {
  std::uint64_t m;
  int n;
};

/// 2^(i/16) in 2⁻⁶²
inline constexpr std::array<std::uint64_t, 16> kSixteenths = {
    0x4000000000000000, 0x42D561B3E6243D8A, 0x45CAE0F1F545EB73, 0x48E1E9B9D588E19B,
    0x4C1BF828C6DC54B8, 0x4F7A993048D088D7, 0x52FF6B54D8A89C75, 0x56AC1F752150A563,
    0x5A827999FCEF3242, 0x5E8451CFAC061B5F, 0x62B39508AA836D6F, 0x6712460A8FC24072,
    0x6BA27E656B4EB57A, 0x70666F76154A7089, 0x75606373EE921C97, 0x7A92BE8A92436616};

/// e to the power raw / 2¹⁶ with a relative error within 2⁻³⁴, for |raw| < 2²².
constexpr Power exponential(std::int32_t raw) {
  // x log₂e = n + i/16 + r/16, r in 2⁻³²
  const std::int64_t binary = raw * std::int64_t{1586259972792};
  const std::uint64_t m = kSixteenths[static_cast<std::size_t>(binary >> 52 & 15)];
  const auto r = static_cast<std::uint32_t>(binary >> 20);
  // 2^(r/16) − 1 in 2⁻³⁶
  std::uint32_t p = 10299U;
  p = 931026U + high_product(r, p);
  p = 64485370U + high_product(r, p);
  p = 2977044466U + high_product(r, p);
  p = high_product(r, p);
  return {m + (((m >> 32) * p) >> 4), static_cast<int>(binary >> 56)};
}

}  // namespace fixed

constexpr Q16 sin(Q16 x) {
  const Q16 sine = fixed::sine_of(fixed::phase(x));
  return x < Q16{} ? -sine : sine;
}

constexpr Q16 cos(Q16 x) { return fixed::sine_of(fixed::phase(x) + (1U << 30)); }

constexpr SinCos<Q16> sin_cos(Q16 x) {
  const std::uint32_t phase = fixed::phase(x);
  const Q16 sine = fixed::sine_of(phase);
  return {x < Q16{} ? -sine : sine, fixed::sine_of(phase + (1U << 30))};
}

constexpr Q16 atan2(Q16 y, Q16 x) {
  constexpr std::uint32_t kPi = 3373259426U, kTanEighth = 1779033704U;
  const std::uint32_t a = fixed::magnitude(y.raw()), b = fixed::magnitude(x.raw());
  const bool steep = a > b;
  const std::uint32_t low = steep ? b : a, high = steep ? a : b;
  // Over ⅛π: atan(low / high) = ¼π − atan((high − low) / (high + low)).
  const bool over = low > fixed::high_product(high, kTanEighth);
  const std::uint32_t n = over ? high - low : low, d = over ? high + low : high;
  std::uint32_t angle = 0;
  if (n != 0) {
    const int zeros = std::countl_zero(d);
    angle = fixed::atan_of(fixed::divided(std::uint64_t{n} << (32 + zeros), d << zeros).whole);
  }
  if (over) angle = kPi / 4 - angle;
  if (steep) angle = kPi / 2 - angle;
  if (x < Q16{}) angle = kPi - angle;
  return fixed::signed_as(y, (angle + (1U << 13)) >> 14);
}

constexpr Q16 atan(Q16 x) { return atan2(x, Q16(1)); }

constexpr Q16 exp(Q16 x) {
  if (x >= Q16(11)) return Q16::of_raw(Q16::saturated(std::int64_t{1} << 32));
  if (x < Q16(-12)) return Q16{};
  const fixed::Power e = fixed::exponential(x.raw());
  if (e.n < -17) return Q16{};
  const int places = 46 - e.n;
  const std::uint64_t half = std::uint64_t{1} << (places - 1);
  return Q16::of_raw(Q16::saturated(static_cast<std::int64_t>((e.m + half) >> places)));
}

/// (1 − e) / (1 + e), e = exp(−2 |x|); 1 from |x| = 7 on, an error within ⅛ LSB.
constexpr Q16 tanh(Q16 x) {
  const std::uint32_t a = fixed::magnitude(x.raw());
  if (a == 0) return x;
  if (a >= 7U << 16) return fixed::signed_as(x, 1U << 16);
  const fixed::Power power = fixed::exponential(-2 * static_cast<std::int32_t>(a));
  const std::uint64_t e = power.m >> (30 - power.n);
  constexpr std::uint64_t kOne = std::uint64_t{1} << 32;
  const auto half_sum = static_cast<std::uint32_t>((kOne + e) >> 1);
  const std::uint32_t ratio = fixed::divided((kOne - e) << 30, half_sum).whole;
  return fixed::signed_as(x, (ratio + (1U << 14)) >> 15);
}

constexpr Q16 sqrt(Q16 x) {
  if (x < Q16{}) {
    q16_overflow = true;
    return Q16{};
  }
  const auto square = static_cast<std::uint64_t>(x.raw()) << 16;
  return Q16::of_raw(static_cast<std::int32_t>(fixed::root(square)));
}

constexpr Q16 hypot(Q16 x, Q16 y) {
  const std::uint64_t a = fixed::magnitude(x.raw()), b = fixed::magnitude(y.raw());
  return Q16::of_raw(Q16::saturated(fixed::root(a * a + b * b)));
}

constexpr Q16 hypot(Q16 x, Q16 y, Q16 z) {
  constexpr std::uint64_t kMax = std::uint64_t{1} << 63;  // from 2⁶² on, the root is out of range
  const std::uint64_t a = fixed::magnitude(x.raw()), b = fixed::magnitude(y.raw());
  const std::uint64_t c = fixed::magnitude(z.raw());
  return Q16::of_raw(Q16::saturated(fixed::root(min(a * a + b * b + c * c, kMax))));
}

constexpr Q16 scaled(Q16 a, Q16 b, Q16 c) {
  const bool negative = ((a.raw() < 0) != (b.raw() < 0)) != (c.raw() < 0);
  const std::uint64_t n = std::uint64_t{fixed::magnitude(a.raw())} * fixed::magnitude(b.raw());
  return Q16::quotient(n, fixed::magnitude(c.raw()), negative);
}

}  // namespace flotilla::core
