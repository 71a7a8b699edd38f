// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "app/convert/convert_scalar.hpp"
#include "app/convert/metres.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::app {
namespace {

using convert::number;
using core::Q16;

constexpr double kLsb = 1.0 / 4294967296, kEnd = 1024.0 * 1024 * 1024;

double drawn(std::mt19937& random, double least, double most) {
  const double size =
      std::exp(std::uniform_real_distribution(std::log(least), std::log(most))(random));
  return random() % 2 == 0 ? size : -size;
}

TEST_CASE("a float from the wire is exact from a centimetre to a thousand kilometres") {
  std::mt19937 random(1);
  for (int i = 0; i < 100'000; ++i) {
    const auto x = static_cast<float>(drawn(random, 0.01, 1e6));
    REQUIRE(number(Metres(x)) == double{x});
    REQUIRE(Metres(x) == Metres(double{x}));
  }
}

TEST_CASE("any number becomes the nearest representable one") {
  std::mt19937 random(2);
  for (int i = 0; i < 100'000; ++i) {
    const double x = drawn(random, 1e-14, 1e9);
    REQUIRE(std::abs(number(Metres(x)) - x) <= kLsb / 2);
    const auto f = static_cast<float>(x);
    REQUIRE(std::abs(number(Metres(f)) - double{f}) <= kLsb / 2);
  }
  CHECK(Metres(0.0F) == Metres());
  CHECK(Metres(-0.0) == Metres());
  CHECK(Metres(std::numeric_limits<float>::denorm_min()) == Metres());
  CHECK(number(Metres(-7)) == -7);
}

TEST_CASE("numbers beyond the range saturate; sums of two limits do not change sign") {
  for (const float x : {1.1e9F, 1e30F, HUGE_VALF}) {
    CHECK(number(Metres(x)) == kEnd);
    CHECK(number(Metres(-x)) == -kEnd);
    CHECK(number(Metres(double{x})) == kEnd);
    CHECK(number(Metres(-double{x})) == -kEnd);
    CHECK(Metres(x) - Metres(-x) > Metres(x));
    CHECK(Metres(-x) - Metres(x) < Metres(-x));
  }
  CHECK(std::abs(number(Metres(std::nan("")))) == kEnd);
  CHECK(std::abs(number(Metres(std::nanf("")))) == kEnd);
}

TEST_CASE("differences become the law's numbers, rounded once, with the overflow of Q16") {
  std::mt19937 random(3);
  core::take_overflow<Q16>();
  for (int i = 0; i < 100'000; ++i) {
    const auto a = static_cast<float>(drawn(random, 0.01, 1e4));
    const auto b = static_cast<float>(drawn(random, 0.01, 1e4));
    const double exact = double{a} - double{b};
    const Metres apart = Metres(a) - Metres(b);
    REQUIRE(convert::scalar<Q16>(apart) == convert::q16_of(exact));
    REQUIRE(convert::scalar<float>(apart) == static_cast<float>(exact));
    REQUIRE(convert::scalar<double>(apart) == exact);
    REQUIRE(convert::scalar<Q16>(Metres(convert::q16_of(exact))) == convert::q16_of(exact));
  }
  CHECK_FALSE(core::take_overflow<Q16>());
  CHECK(convert::scalar<Q16>(Metres(40e3)).raw() == std::numeric_limits<std::int32_t>::max());
  CHECK(core::take_overflow<Q16>());
  CHECK(convert::scalar<Q16>(Metres(-40e3)).raw() == std::numeric_limits<std::int32_t>::min());
  CHECK(core::take_overflow<Q16>());
}

}  // namespace
}  // namespace flotilla::app
