// SPDX-License-Identifier: MIT
// Oracles: 128-bit integers for the arithmetic, the C library's long double for the functions, here
// at every 60 013th argument and near 0; fixed_exhaustive.cpp takes all.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include "core/scalar/fixed.hpp"

namespace flotilla::core {
namespace {

constexpr std::int64_t kMin = std::numeric_limits<std::int32_t>::min();
constexpr std::int64_t kMax = std::numeric_limits<std::int32_t>::max();
const Q16 kLowest = Q16::of_raw(kMin), kHighest = Q16::of_raw(kMax);

/// Of all magnitudes, and the ends of the range.
struct RandomQ16 {
  Q16 operator()() {
    if (engine() % 64 == 0) return engine() % 2 == 0 ? kLowest : kHighest;
    const auto any = static_cast<std::int32_t>(engine());
    return Q16::of_raw(any >> engine() % 31);
  }
  std::mt19937 engine;
};

bool lowered_and_risen(bool expected) {
  const bool risen = q16_overflow;
  q16_overflow = false;
  return risen == expected;
}

/// n / d to nearest, ties to even, in 128 bits; then as Q16 saturates.
__extension__ using Wide = __int128;
Wide rounded(Wide n, Wide d) {
  if (d < 0) return rounded(-n, -d);
  Wide whole = n / d;
  if (whole * d > n) --whole;
  const Wide twice = 2 * (n - whole * d);
  return whole + (twice > d || (twice == d && whole % 2 != 0) ? 1 : 0);
}

void check_saturated(Q16 result, Wide exact) {
  const Wide nearest_raw = std::clamp<Wide>(exact, kMin, kMax);
  CHECK(result.raw() == static_cast<std::int64_t>(nearest_raw));
  CHECK(lowered_and_risen(exact != nearest_raw));
}

struct Function {
  const char* name;
  Q16 (*ours)(Q16);
  long double (*exact)(long double);
};

constexpr std::array<Function, 6> kFunctions{{
    {"sin", sin, std::sin},
    {"cos", cos, std::cos},
    {"atan", atan, std::atan},
    {"tanh", tanh, std::tanh},
    {"exp", exp, std::exp},
    {"sqrt", sqrt, [](long double x) { return x < 0 ? 0 : std::sqrt(x); }},
}};

long double error_lsb(Q16 result, long double exact) {
  const auto raw = std::clamp<long double>(exact * 65536, kMin, kMax);
  return std::abs(static_cast<long double>(result.raw()) - raw);
}

long double error_lsb(const Function& function, std::int64_t raw) {
  const auto x = static_cast<long double>(raw) / 65536;
  return error_lsb(function.ours(Q16::of_raw(static_cast<std::int32_t>(raw))), function.exact(x));
}

TEST_CASE("sums, products and quotients are the nearest, ties to even, and saturate with a flag") {
  RandomQ16 random{std::mt19937(1)};
  q16_overflow = false;
  for (int i = 0; i < 100'000; ++i) {
    const Q16 a = random(), b = random();
    CAPTURE(a.raw());
    CAPTURE(b.raw());
    check_saturated(a + b, Wide{a.raw()} + b.raw());
    check_saturated(a - b, Wide{a.raw()} - b.raw());
    check_saturated(-a, -Wide{a.raw()});
    check_saturated(a * b, rounded(Wide{a.raw()} * b.raw(), 65536));
    if (b != Q16(0)) check_saturated(a / b, rounded(Wide{a.raw()} * 65536, b.raw()));
    const Q16 c = random(), d = random();
    CAPTURE(c.raw());
    CAPTURE(d.raw());
    const Wide ab = Wide{a.raw()} * b.raw(), cd = Wide{c.raw()} * d.raw();
    check_saturated(sum_of_products(a, b, c, d), rounded(ab + cd, 65536));
    check_saturated(difference_of_products(a, b, c, d), rounded(ab - cd, 65536));
  }
}

TEST_CASE("a sum of two products saturates even if it exceeds 64 bits") {
  const Q16 most = kHighest, least = kLowest;
  q16_overflow = false;
  CHECK(sum_of_products(least, least, least, least) == most);
  CHECK(lowered_and_risen(true));
  CHECK(sum_of_products(least, least, least, -Q16(1)) == most);
  CHECK(lowered_and_risen(true));
  CHECK(difference_of_products(least, most, least, least) == least);
  CHECK(lowered_and_risen(true));
  CHECK(difference_of_products(least, least, least, least) == Q16(0));
  CHECK(lowered_and_risen(false));
}

TEST_CASE("sine and cosine together are those of each alone") {
  RandomQ16 random{std::mt19937(4)};
  for (int i = 0; i < 100'000; ++i) {
    const Q16 x = random();
    const auto [s, c] = sin_cos(x);
    REQUIRE(s == sin(x));
    REQUIRE(c == cos(x));
  }
}

TEST_CASE("a division by zero gives the greatest number and raises the flag") {
  q16_overflow = false;
  CHECK(Q16(2) / Q16(0) == kHighest);
  CHECK(lowered_and_risen(true));
  CHECK(Q16(-2) / Q16(0) == kLowest);
  CHECK(lowered_and_risen(true));
  CHECK(Q16(0) / Q16(0) == Q16(0));
  CHECK(lowered_and_risen(true));
  CHECK(scaled(Q16(2), Q16(-1), Q16(0)) == kLowest);
  CHECK(lowered_and_risen(true));
  CHECK(scaled(Q16(0), Q16(-1), Q16(0)) == Q16(0));
  CHECK(lowered_and_risen(true));
}

TEST_CASE("a quotient that is rounded up to 2^32 saturates and does not wrap to zero") {
  const Q16 a = Q16::of_raw(2147422344), d = Q16::of_raw(1073680521);  // a²/d = 2³² − 0.49995
  q16_overflow = false;
  CHECK(scaled(a, a, d) == kHighest);
  CHECK(scaled(-a, a, d) == kLowest);
  CHECK(std::exchange(q16_overflow, false));
}

TEST_CASE("a result halfway between two numbers is rounded to the even one, for either sign") {
  CHECK(Q16::of_raw(1) * Q16(0.5) == Q16(0));
  CHECK(Q16::of_raw(3) * Q16(0.5) == Q16::of_raw(2));
  CHECK(Q16::of_raw(-3) * Q16(0.5) == Q16::of_raw(-2));
  CHECK(Q16::of_raw(3) / Q16(2) == Q16::of_raw(2));
  CHECK(Q16::of_raw(-5) / Q16(2) == Q16::of_raw(-2));
}

TEST_CASE("a flag stays set until it is cleared") {
  q16_overflow = false;
  CHECK(Q16(200) * Q16(200) == kHighest);
  CHECK(Q16(2) * Q16(2) == Q16(4));
  CHECK(lowered_and_risen(true));
}

TEST_CASE("a literal is rounded to the nearest number at compile time") {
  static_assert(Q16(0.1).raw() == 6554);
  static_assert(Q16(-0.1).raw() == -6554);
  static_assert(Q16(3).raw() == 196608);
  static_assert(-Q16(1.5) < Q16(-1) && Q16(0.25) * Q16(4) == Q16(1));
  CHECK(Q16(40'000) == kHighest);
  CHECK(lowered_and_risen(true));
}

TEST_CASE_TEMPLATE("a whole number of any width converts exactly or saturates with a flag", T,
                   std::int16_t, std::int32_t, std::uint32_t, std::int64_t, std::uint64_t) {
  q16_overflow = false;
  constexpr T kMinWhole = std::numeric_limits<T>::min(), kMaxWhole = std::numeric_limits<T>::max();
  std::vector<T> wholes{0, 1, 32'767, kMinWhole, kMaxWhole, kMaxWhole / 2 + 1, kMaxWhole / 3};
  for (int places = 0; places < std::numeric_limits<T>::digits; ++places) {
    const T power = static_cast<T>(T{1} << places);
    wholes.insert(wholes.end(), {power, static_cast<T>(power + 5), static_cast<T>(-power)});
  }
  for (const T whole : wholes) {
    CAPTURE(whole);
    check_saturated(Q16(whole), Wide{whole} * 65536);
  }
}

TEST_CASE("every function is within 0.7 LSB of the C library's, whatever the argument") {
  for (const Function& function : kFunctions) {
    CAPTURE(function.name);
    long double worst = 0;
    for (std::int64_t raw = kMin; raw <= kMax; raw += 60'013) {
      worst = std::max(worst, error_lsb(function, raw));
    }
    for (std::int64_t raw = -800'000; raw <= 700'000; raw += 7) {
      worst = std::max(worst, error_lsb(function, raw));
    }
    for (const std::int64_t raw : {kMin, kMin + 1, kMax - 1, kMax}) {
      worst = std::max(worst, error_lsb(function, raw));
    }
    CHECK(worst < 0.7L);
    CHECK(worst > 0.4L);  // otherwise the oracle checked nothing
  }
}

TEST_CASE("a bearing and a distance are within 0.51 LSB, wherever the other boat is") {
  RandomQ16 random{std::mt19937(2)};
  for (int i = 0; i < 300'000; ++i) {
    const Q16 y = random(), x = random();
    const long double a = y.raw(), b = x.raw();
    CAPTURE(y.raw());
    CAPTURE(x.raw());
    REQUIRE(error_lsb(atan2(y, x), std::atan2(a, b)) < 0.51L);
    REQUIRE(error_lsb(hypot(y, x), std::hypot(a, b) / 65536) < 0.51L);
  }
}

TEST_CASE("a scaled product and a distance in three dimensions are rounded once, or saturate") {
  RandomQ16 random{std::mt19937(5)};
  q16_overflow = false;
  for (int i = 0; i < 300'000; ++i) {
    const Q16 a = random(), b = random(), c = random();
    CAPTURE(a.raw());
    CAPTURE(b.raw());
    CAPTURE(c.raw());
    if (c != Q16(0)) check_saturated(scaled(a, b, c), rounded(Wide{a.raw()} * b.raw(), c.raw()));
    // Nearest is r where (2r − 1)² < 4n < (2r + 1)².
    const Wide n = Wide{a.raw()} * a.raw() + Wide{b.raw()} * b.raw() + Wide{c.raw()} * c.raw();
    const Wide r = hypot(a, b, c).raw(), four = 4 * n;
    const bool over = four > Wide{2 * kMax + 1} * (2 * kMax + 1);
    CHECK(lowered_and_risen(over));
    REQUIRE((over ? r == kMax : four < (2 * r + 1) * (2 * r + 1)));
    REQUIRE((r == 0 || over || four > (2 * r - 1) * (2 * r - 1)));
  }
}

TEST_CASE("the root of an integer is the nearest one, on either side of every half") {
  RandomQ16 random{std::mt19937(4)};
  for (int i = 0; i < 100'000; ++i) {
    // Half of them over 2³¹, whose squares reach 2⁶³.
    const std::uint64_t r =
        i % 2 == 0 ? fixed::magnitude(random().raw()) : (1U << 31) + random.engine() % 889'000'000U;
    CAPTURE(r);
    CHECK(fixed::root(r * r + r) == r);
    CHECK(fixed::root(r * r + r + 1) == r + 1);
  }
}

TEST_CASE("a boat's mirror image computes the mirror image, to the last bit") {
  RandomQ16 random{std::mt19937(3)};
  for (int i = 0; i < 100'000; ++i) {
    const Q16 x = random(), y = random();
    if (x == kLowest || y == kLowest) continue;
    CAPTURE(x.raw());
    CAPTURE(y.raw());
    CHECK(sin(-x) == -sin(x));
    CHECK(cos(-x) == cos(x));
    CHECK(atan(-x) == -atan(x));
    CHECK(tanh(-x) == -tanh(x));
    CHECK(hypot(-x, y) == hypot(x, y));
    CHECK(hypot(x, y) == hypot(y, x));
    if (y != Q16(0)) CHECK(atan2(-y, x) == -atan2(y, x));
    if (x * y != kLowest && x * y != kHighest) CHECK((-x) * y == -(x * y));
  }
}

TEST_CASE("due astern is +pi, and the angle of a zero vector is 0") {
  CHECK(atan2(Q16(0), Q16(-1)) == Q16(3.14159265358979323846));
  CHECK(atan2(Q16(0), kLowest) == Q16(3.14159265358979323846));
  CHECK(atan2(kLowest, kLowest) == Q16(-2.35619449019234492885));
  CHECK(atan2(Q16(0), Q16(0)) == Q16(0));
  CHECK(atan2(Q16(0), Q16(2)) == Q16(0));
}

TEST_CASE("functions that leave the range raise the flag, and only they") {
  q16_overflow = false;
  CHECK(exp(Q16(10.397)) < kHighest);
  CHECK(exp(kLowest) == Q16(0));
  CHECK(hypot(Q16(20'000), Q16(-20'000)) < kHighest);
  CHECK(lowered_and_risen(false));
  CHECK(exp(Q16(10.4)) == kHighest);
  CHECK(lowered_and_risen(true));
  CHECK(exp(kHighest) == kHighest);
  CHECK(lowered_and_risen(true));
  CHECK(hypot(Q16(25'000), Q16(25'000)) == kHighest);
  CHECK(lowered_and_risen(true));
  CHECK(hypot(kLowest, kLowest) == kHighest);
  CHECK(lowered_and_risen(true));
  CHECK(sqrt(Q16(-1)) == Q16(0));
  CHECK(lowered_and_risen(true));
  CHECK(abs(kLowest) == kHighest);
  CHECK(lowered_and_risen(true));
  CHECK(ceil(Q16(32'767)) == Q16(32'767));
  CHECK(lowered_and_risen(false));
  CHECK(ceil(kHighest) == kHighest);
  CHECK(lowered_and_risen(true));
}

TEST_CASE("whole numbers are rounded up") {
  CHECK(ceil(Q16(1.25)) == Q16(2));
  CHECK(ceil(Q16(-1.25)) == Q16(-1));
  CHECK(ceil(Q16::of_raw(1)) == Q16(1));
  CHECK(ceil(Q16::of_raw(-1)) == Q16(0));
  CHECK(ceil(kLowest) == kLowest);
}

TEST_CASE("a heading of many turns is wrapped like any other") {
  for (int turn = -1000; turn <= 1000; turn += 37) {
    const Q16 heading = wrap_pi(Q16(1) + Q16(turn) * Q16(6.28318530717958647693));
    CHECK(abs(heading - Q16(1)) <= Q16::of_raw(1));
  }
}

}  // namespace
}  // namespace flotilla::core
