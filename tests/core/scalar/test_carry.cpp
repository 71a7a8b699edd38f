// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <tuple>

#include "core/scalar/carry.hpp"

namespace flotilla::core {
namespace {

TEST_CASE_TEMPLATE("a carried float product is the plain product, to the last bit", S, float,
                   double) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-10, 10);
  Carry<S> carry;
  for (int i = 0; i < 1000; ++i) {
    const S a = S(any(random)), b = S(any(random));
    REQUIRE(carry.take(a, b) == a * b);
  }
}

TEST_CASE(
    "a turn of 0.0005 rad/s is seen within a minute, though a tick's share is below one LSB") {
  const Q16 r = Q16(0.0005), tick = Q16(0.01);
  CHECK(r * tick == Q16(0));
  Carry<Q16> carry;
  Q16 turned;
  for (int i = 0; i < 6000; ++i) turned = turned + carry.take(r, tick);
  CHECK(std::abs(turned.raw() - 6000.0 * r.raw() * tick.raw() / 65536) <= 0.5);
  CHECK(turned > Q16(0.03));
}

TEST_CASE("a sum of products of any sign is never more than half an LSB off") {
  std::mt19937 random(3);
  Carry<Q16> carry;
  std::int64_t sum = 0, exact = 0;
  for (int i = 0; i < 10'000; ++i) {
    const Q16 a = Q16::of_raw(static_cast<std::int32_t>(random()) >> 14);
    const Q16 b = Q16::of_raw(static_cast<std::int32_t>(random()) >> 14);
    sum += carry.take(a, b).raw();
    exact += std::int64_t{a.raw()} * b.raw();
    REQUIRE(std::abs(exact - sum * 65536) <= 32768);
  }
}

TEST_CASE("sums for port and starboard are mirror images, to the last bit") {
  std::mt19937 random(2);
  Carry<Q16> port, stbd;
  for (int i = 0; i < 10'000; ++i) {
    const Q16 a = Q16::of_raw(static_cast<std::int32_t>(random()) >> 14);
    const Q16 b = Q16::of_raw(static_cast<std::int32_t>(random()) >> 14);
    REQUIRE(stbd.take(a, -b) == -port.take(a, b));
  }
}

TEST_CASE("an overflowing product raises the flag and keeps its sign") {
  const Q16 least = Q16::of_raw(-0x7FFFFFFF - 1), most = Q16::of_raw(0x7FFFFFFF);
  for (const auto& [a, b, end] : {std::tuple{least, most, least}, {least, least, most}}) {
    q16_overflow = false;
    Carry<Q16> carry;
    for (int i = 0; i < 100; ++i) REQUIRE(carry.take(a, b) == end);
    CHECK(q16_overflow);
  }
  q16_overflow = false;
}

}  // namespace
}  // namespace flotilla::core
