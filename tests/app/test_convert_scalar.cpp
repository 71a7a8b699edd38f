// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "app/convert_scalar.hpp"
#include "core/overflow.hpp"

namespace flotilla::app::convert {
namespace {

using core::Q16;
constexpr double kLsb = 1.0 / 65536;

TEST_CASE("a number of the wire becomes the nearest that Q16 has, ties to even, in range") {
  constexpr std::uint32_t kSeed = 1616;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  core::take_overflow<Q16>();
  for (const double most : {1e-30, 1e-5, 1e-3, 1.0, 300.0, 32767.0}) {
    std::uniform_real_distribution<double> draw(-most, most);
    for (int i = 0; i < 20'000; ++i) {
      const double x = draw(random);
      REQUIRE(q16_of(x).raw() == std::lrint(x * 65536));
      REQUIRE(scalar<Q16>(static_cast<float>(x)) == q16_of(double{static_cast<float>(x)}));
    }
  }
  for (int n = -1000; n <= 1000; ++n) {  // ties, and what is just beside them
    const double tie = (n + 0.5) * kLsb;
    for (const double x : {tie, std::nextafter(tie, 1e9), std::nextafter(tie, -1e9), n * kLsb}) {
      REQUIRE(q16_of(x).raw() == std::lrint(x * 65536));
    }
  }
  CHECK_FALSE(core::take_overflow<Q16>());
}

TEST_CASE("what Q16 has no room for is its nearest end, and raises the overflow") {
  const auto most = std::numeric_limits<std::int32_t>::max();
  for (const double x : {32768.0, 40e3, 1e30, 1e300, HUGE_VAL}) {
    core::take_overflow<Q16>();
    CHECK(q16_of(x).raw() == most);
    CHECK(core::take_overflow<Q16>());
    CHECK(q16_of(-x - kLsb).raw() == -most - 1);
    CHECK(core::take_overflow<Q16>());
  }
  CHECK(q16_of(std::nan("")) == Q16(0));
  CHECK(core::take_overflow<Q16>());
  CHECK(q16_of(32768 - kLsb).raw() == most);
  CHECK(q16_of(-32768.0).raw() == -most - 1);
  CHECK_FALSE(core::take_overflow<Q16>());
}

TEST_CASE("a number goes out as it is, whole numbers are cut towards zero") {
  for (const double x : {-32768.0, -2.75, -kLsb, 0.0, kLsb, 0.5, 32768 - kLsb}) {
    CHECK(number(q16_of(x)) == x);
    CHECK(whole(q16_of(x)) == static_cast<int>(x));
    CHECK(whole(x) == static_cast<int>(x));
  }
}

TEST_CASE("times are rounded to 15 us; in Q16 nine hours are as good as ever") {
  CHECK(number(seconds<Q16>(10'000)) == doctest::Approx(0.01).epsilon(0.001));
  CHECK(number(seconds<Q16>(-10'000)) == -number(seconds<Q16>(10'000)));
  CHECK(seconds<float>(2'500'000) == 2.5F);
  core::take_overflow<Q16>();
  CHECK(number(seconds<Q16>(INT64_MAX)) == doctest::Approx(32767));
  CHECK(number(seconds<Q16>(INT64_MIN)) == doctest::Approx(-32767));
  CHECK_FALSE(core::take_overflow<Q16>());
}

}  // namespace
}  // namespace flotilla::app::convert
