// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <limits>
#include <random>

#include "link/dronecan/float16.hpp"

namespace flotilla::link {
namespace {

/// The value of 16 bits, by the definition of IEEE 754.
double meaning_of(unsigned h) {
  const int exponent = static_cast<int>(h >> 10U & 0x1FU);
  const double fraction = h & 0x3FFU;
  const double magnitude = exponent == 0    ? std::ldexp(fraction, -24)
                           : exponent == 31 ? double{fraction > 0 ? NAN : INFINITY}
                                            : std::ldexp(1024 + fraction, exponent - 25);
  return (h & 0x8000U) != 0 ? -magnitude : magnitude;
}

TEST_CASE("each of the 65536 patterns decodes as in IEEE 754, and encodes back, except infinity") {
  for (unsigned h = 0; h < 65536; ++h) {
    const auto pattern = static_cast<std::uint16_t>(h);
    const float x = float_from_float16(pattern);
    CAPTURE(h);
    if (std::isnan(meaning_of(h))) {
      REQUIRE(std::isnan(x));
      REQUIRE(std::isnan(float_from_float16(float16_from(x))));
    } else {
      REQUIRE(double{x} == meaning_of(h));
      REQUIRE(std::signbit(x) == ((h & 0x8000U) != 0));
      const bool infinite = (h & 0x7FFFU) == 0x7C00;
      REQUIRE(float16_from(x) == (infinite ? pattern - 1 : pattern));
    }
  }
}

TEST_CASE("a number between two patterns becomes the nearer, half way the even one") {
  constexpr std::uint32_t kSeed = 32;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (unsigned h = 0; h < 0x7BFF; ++h) {
    const double low = meaning_of(h), high = meaning_of(h + 1);
    const auto half_way = static_cast<float>(0.5 * (low + high));  // exact: float has 13 bits more
    CAPTURE(h);
    REQUIRE(float16_from(half_way) == (h % 2 == 0 ? h : h + 1));
    REQUIRE(float16_from(std::nextafter(half_way, 0.0F)) == h);
    REQUIRE(float16_from(std::nextafter(half_way, 1e9F)) == h + 1);
    const double part = std::uniform_real_distribution<double>(0, 1)(random);
    const auto between = static_cast<float>(low + part * (high - low));
    const double error = std::abs(meaning_of(float16_from(between)) - double{between});
    REQUIRE(error <= 0.5 * (high - low));
    REQUIRE(float16_from(-between) == (float16_from(between) | 0x8000U));
  }
}

TEST_CASE("too large numbers and infinity saturate; NaN and the sign of zero stay") {
  CHECK(float16_from(65504.0F) == 0x7BFF);
  CHECK(float16_from(65519.0F) == 0x7BFF);
  CHECK(float16_from(1e30F) == 0x7BFF);
  CHECK(float16_from(-std::numeric_limits<float>::max()) == 0xFBFF);
  CHECK(float16_from(INFINITY) == 0x7BFF);
  CHECK(float16_from(-INFINITY) == 0xFBFF);
  CHECK(std::isnan(float_from_float16(float16_from(NAN))));
  CHECK(float16_from(0.0F) == 0);
  CHECK(float16_from(-0.0F) == 0x8000);
  CHECK(float16_from(std::numeric_limits<float>::denorm_min()) == 0);
}

}  // namespace
}  // namespace flotilla::link
