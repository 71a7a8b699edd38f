// SPDX-License-Identifier: MIT
// The oracle is <cmath> in long double; with 64 bits or more it is exact compared with a double.
#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "app/convert/portable.hpp"

namespace flotilla::app::portable {
namespace {

using Exact = long double;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t kSeed = 1754;

double off(double got, Exact truth) { return static_cast<double>(std::abs(Exact{got} - truth)); }
double off_by(double got, Exact truth) {
  return off(got, truth) / std::abs(static_cast<double>(truth));
}

struct Draw {
  std::mt19937 random{kSeed};
  double operator()(double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random);
  }
  /// A number of any size between 2^−limit and 2^limit, with either sign.
  double any(double limit) { return std::copysign(std::exp2((*this)(limit)), (*this)(1)); }
};

TEST_CASE("a number becomes the nearest whole one, halves go away from zero") {
  INFO("seed ", kSeed);
  Draw draw;
  for (int k = 0; k < 200'000; ++k) {
    const double x = draw.any(50);
    REQUIRE(nearest(x) == std::llround(x));
  }
  for (double n = 1; n < 1e15; n = std::ceil(n * 1.01)) {
    const double half = n + 0.5;
    for (const double x : {n, half, std::nextafter(half, 0.0), std::nextafter(half, 1e18)}) {
      REQUIRE(nearest(x) == std::llround(x));
      REQUIRE(nearest(-x) == -nearest(x));
    }
  }
  CHECK(nearest(0.5) == 1);
  CHECK(nearest(-0.5) == -1);
  CHECK(nearest(0.4999) == 0);
  CHECK(nearest(-0.0) == 0);
}

TEST_CASE("a square root is within an ulp of the exact one; the root of a square is exact") {
  INFO("seed ", kSeed);
  Draw draw;
  for (int k = 0; k < 100'000; ++k) {
    const double n = k, x = std::abs(draw.any(1021)), y = 1 + 3e-5 * k;
    REQUIRE(off_by(root(x), std::sqrt(Exact{x})) <= kEpsilon);
    REQUIRE(off_by(root(y), std::sqrt(Exact{y})) <= kEpsilon);
    REQUIRE(root(4 * x) == 2 * root(x));
    REQUIRE(root(n * n) == n);
  }
  constexpr double kMax = std::numeric_limits<double>::max();
  CHECK(off_by(root(kMax), std::sqrt(Exact{kMax})) <= kEpsilon);
  CHECK(root(std::numeric_limits<double>::denorm_min()) < 1e-150);
  CHECK(root(kInfinity) == kInfinity);
  for (const double none : {0.0, -0.0, -1e-300, -1.0, -kInfinity, kNaN}) CHECK(root(none) == 0);
}

TEST_CASE(
    "a distance is within two ulps in any direction; one whose square overflows is infinite") {
  INFO("seed ", kSeed);
  Draw draw;
  for (int k = 0; k < 100'000; ++k) {
    const double x = draw.any(500), y = x * draw.any(10);
    REQUIRE(off_by(hypot(x, y), std::hypot(Exact{x}, Exact{y})) <= 2 * kEpsilon);
    REQUIRE(hypot(x, y) == hypot(y, -x));
  }
  CHECK(hypot(3, -4) == 5);
  CHECK(hypot(0, 0) == 0);
  CHECK(hypot(1e200, 0) == kInfinity);
  CHECK(hypot(1, -kInfinity) == kInfinity);
}

void check_turned(double rad) {
  CAPTURE(rad);
  const auto [s, c] = sin_cos(rad);
  REQUIRE(off(s, std::sin(Exact{rad})) <= kEpsilon);
  REQUIRE(off(c, std::cos(Exact{rad})) <= kEpsilon);
  REQUIRE(off(s * s + c * c, 1) <= 3 * kEpsilon);
  const auto [minus, same] = sin_cos(-rad);
  REQUIRE(minus == -s);
  REQUIRE(same == c);
}

TEST_CASE("sine and cosine are libm's, in every quadrant and after 150 000 turns") {
  INFO("seed ", kSeed);
  Draw draw;
  for (double rad = 0; rad < 20; rad += 2e-4) check_turned(rad);
  for (const double most : {1e-9, 1e-3, 1.0, 100.0, 1e4, 1e6}) {
    for (int k = 0; k < 20'000; ++k) check_turned(draw(most));
  }
  for (int eighths = 0; eighths < 1'270'000; eighths += eighths < 100 ? 1 : 37) {
    const double rad = eighths * (kPi / 4);
    for (const double x : {rad, std::nextafter(rad, 0.0), std::nextafter(rad, 1e9)}) {
      check_turned(x);
    }
  }
  CHECK(sin_cos(0).sin == 0);
  CHECK(sin_cos(0).cos == 1);
  // A small remainder has as many correct digits.
  const double half_turns = 1000 * kPi;
  CHECK(off_by(sin_cos(half_turns).sin, std::sin(Exact{half_turns})) < 1e-6);
}

TEST_CASE("a bearing is within four ulps of the exact one, on all sides") {
  INFO("seed ", kSeed);
  Draw draw;
  const auto check = [](double y, double x) {
    CAPTURE(y);
    CAPTURE(x);
    REQUIRE(off_by(atan2(y, x), std::atan2(Exact{y}, Exact{x})) <= 4 * kEpsilon);
    REQUIRE(atan2(-y, x) == -atan2(y, x));
  };
  for (int k = 0; k < 100'000; ++k) {
    check(draw(1), draw(1));
    check(draw.any(500), draw.any(500));
    const double rad = 1e-5 * kPi * (k + 0.5), far = std::abs(draw.any(60));
    const auto [s, c] = sin_cos(rad);
    check(far * s, far * c);
    REQUIRE(std::abs(atan2(far * s, far * c) - rad) <= 4 * kEpsilon);
  }
  for (const double far : {1e-300, 1.0, 1e300}) {
    CHECK(atan2(0, far) == 0);
    CHECK(atan2(far, 0) == kPi / 2);
    CHECK(atan2(-far, 0) == -kPi / 2);
    CHECK(atan2(0, -far) == kPi);
    CHECK(atan2(-0.0, -far) == kPi);  // −π is no bearing
  }
  CHECK(atan2(0, 0) == 0);
  CHECK(atan2(-0.0, -0.0) == 0);
  CHECK(atan2(1, kInfinity) == 0);
  CHECK(atan2(-kInfinity, 1) == -kPi / 2);
}

constexpr int kArguments = 100;
constexpr double argument(int k) { return 0.37 * k * k - 17.3 * k + 1e-3; }
constexpr std::array<double, 5> all_of(double x) {
  const auto [s, c] = sin_cos(x);
  return {s, c, root(x < 0 ? -x : x), hypot(x, 5), atan2(x, -40)};
}

TEST_CASE("on this processor functions give the same bits as at compile time") {
  static constexpr auto kTold = [] {
    std::array<std::array<double, 5>, kArguments> out{};
    for (int k = 0; k < kArguments; ++k) out[static_cast<std::size_t>(k)] = all_of(argument(k));
    return out;
  }();
  for (int k = 0; k < kArguments; ++k) {
    const volatile double x = argument(k);
    const auto here = all_of(x);
    for (std::size_t i = 0; i < here.size(); ++i) {
      CAPTURE(i);
      REQUIRE(std::bit_cast<std::uint64_t>(here[i]) ==
              std::bit_cast<std::uint64_t>(kTold[static_cast<std::size_t>(k)][i]));
    }
  }
}

}  // namespace
}  // namespace flotilla::app::portable
