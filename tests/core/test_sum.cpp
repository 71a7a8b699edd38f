// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>

#include "core/sum.hpp"

namespace flotilla::core {
namespace {

TEST_CASE_TEMPLATE("a float's sum has the bits of x + a b", S, float, double) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-10, 10);
  const S start = S(any(random));
  S x = start;
  Sum<S> sum(start);
  for (int i = 0; i < 1000; ++i) {
    const S a = S(any(random)), b = S(any(random));
    x = x + a * b;
    sum.add(a, b);
    x = x + a;
    sum.add(a);
    REQUIRE(sum.value() == x);
  }
}

TEST_CASE(
    "a turn of 0.0005 rad/s is seen within a minute, though a tick's share is below one LSB") {
  const Q16 r = Q16(0.0005), tick = Q16(0.01);
  CHECK(r * tick == Q16(0));
  Sum<Q16> turned;
  for (int i = 0; i < 6000; ++i) turned.add(r, tick);
  CHECK(std::abs(turned.value().raw() - 6000.0 * r.raw() * tick.raw() / 65536) <= 0.5);
  CHECK(turned.value() > Q16(0.03));
}

TEST_CASE("port and starboard add up to mirror images, to the last bit") {
  std::mt19937 random(2);
  Sum<Q16> port, stbd;
  for (int i = 0; i < 10'000; ++i) {
    const Q16 a = Q16::of_raw(static_cast<std::int32_t>(random()) >> 14);
    const Q16 b = Q16::of_raw(static_cast<std::int32_t>(random()) >> 14);
    port.add(a, b);
    stbd.add(a, -b);
    REQUIRE(stbd.value() == -port.value());
  }
}

TEST_CASE("a sum that leaves the range says so, and keeps its sign") {
  q16_overflow = false;
  Sum<Q16> sum(Q16(32'767));
  sum.add(Q16(2));
  CHECK_FALSE(q16_overflow);
  CHECK(sum.value() == Q16::of_raw(0x7FFFFFFF));
  CHECK(q16_overflow);
  q16_overflow = false;
  for (int i = 0; i < 100; ++i) sum.add(Q16(-32'768), Q16(32'767));
  CHECK(q16_overflow);
  CHECK(sum.value() == Q16::of_raw(-0x7FFFFFFF - 1));
  for (int i = 0; i < 100; ++i) sum.add(Q16(-32'768), Q16(-32'768));
  CHECK(sum.value() == Q16::of_raw(0x7FFFFFFF));
  q16_overflow = false;
}

}  // namespace
}  // namespace flotilla::core
