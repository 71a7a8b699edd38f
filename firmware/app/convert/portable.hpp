// SPDX-License-Identifier: MIT
// Functions of doubles from + − × ÷ alone, for geodesy and telemetry: the same bits on every
// processor, and no libm on a microcontroller. The law uses core/scalar/scalar.hpp.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace flotilla::app::portable {

constexpr double kPi = 3.14159265358979323846;

/// The nearest integer, halves away from zero; |x| under 2⁵².
constexpr std::int64_t nearest(double x) {
  return static_cast<std::int64_t>(x < 0 ? x - 0.5 : x + 0.5);
}

/// The least integer not below x; |x| under 2⁶².
constexpr std::int64_t ceil(double x) {
  const auto cut = static_cast<std::int64_t>(x);
  return static_cast<double>(cut) < x ? cut + 1 : cut;
}

/// rad, in (−π, π]
constexpr double wrap_pi(double rad) {
  constexpr double kTurn = 2 * kPi;
  return rad - kTurn * static_cast<double>(ceil((rad - kPi) / kTurn));
}

/// √x by Newton's method, starting from half the exponent; 0 for x ≤ 0 and NaN, ∞ for ∞.
constexpr double root(double x) {
  if (!(x > 0)) return 0;
  if (x > std::numeric_limits<double>::max()) return x;
  double y = std::bit_cast<double>((std::bit_cast<std::uint64_t>(x) >> 1U) + 0x1FF8'0000'0000'0000);
  for (int i = 0; i < 5; ++i) y = 0.5 * (y + x / y);
  return y;
}

/// Not inlined: the compiler counts each of the library's products as one instruction, and would
/// copy them.
[[gnu::noinline]] constexpr double hypot(double x, double y) { return root(x * x + y * y); }

struct SinCos {
  double sin, cos;
};

/// |rad| up to a million: reduces to the nearest quarter turn, then a Taylor series.
constexpr SinCos sin_cos(double rad) {
  // π/2 in two parts; the first is short enough that its product with the quarter count is exact.
  constexpr double kQuarter = 1.57079632673412561417, kRest = 6.07710050650619224932e-11;
  const std::int64_t quarters = nearest(rad * (2 / kPi));
  const auto n = static_cast<double>(quarters);
  const double r = rad - n * kQuarter - n * kRest, z = -r * r;
  struct Term {
    double of_sin, of_cos;
  };
  constexpr auto kTerms = [] {
    std::array<Term, 8> terms{};
    for (int i = 0; i < 8; ++i) {
      const int k = 16 - 2 * i;
      terms[static_cast<std::size_t>(i)] = {1.0 / (k * (k + 1)), 1.0 / (k * (k - 1))};
    }
    return terms;
  }();
  double s = 1, c = 1;
  for (const Term& term : kTerms) {
    s = 1 + s * z * term.of_sin;
    c = 1 + c * z * term.of_cos;
  }
  s *= r;
  switch (quarters & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

/// Angle of (x, y) from the x axis, rad, in (−π, π]; 0 for (0, 0).
constexpr double atan2(double y, double x) {
  const double ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
  const bool steep = ay > ax;
  const double longer = steep ? ay : ax;
  if (longer == 0) return 0;
  double t = (steep ? ax : ay) / longer;
  // Reduces t to the tangent of a quarter of the angle, under 0.2.
  for (int i = 0; i < 2; ++i) t = t / (1 + root(1 + t * t));
  constexpr auto kTerms = [] {  // 1/23 … 1/3, 1
    std::array<double, 12> terms{};
    for (int i = 0; i < 12; ++i) terms[static_cast<std::size_t>(i)] = 1.0 / (23 - 2 * i);
    return terms;
  }();
  const double z = t * t;
  double sum = 0;
  for (const double term : kTerms) sum = term - z * sum;
  double angle = 4 * t * sum;
  if (steep) angle = kPi / 2 - angle;
  if (x < 0) angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace flotilla::app::portable
