// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "app/operator/telemetry/token_bucket.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kTick_us = 10'000, kSecond_us = 1'000'000;

/// Average bytes per second of each kind.
struct Shares {
  double state, rest;
};

/// The demand on a link: rate and frame size of each kind.
struct Traffic {
  double state_Bps, rest_Bps;
  std::size_t state_bytes = 40, rest_bytes = 40;
};

constexpr int kRun_s = 200;

Shares carried(std::uint32_t rate_Bps, const Traffic& traffic, std::uint32_t seed) {
  std::mt19937 random(seed);
  TokenBucket bucket;
  bucket.limit(rate_Bps);
  double state_queue = 0, rest_queue = 0, state = 0, rest = 0;
  std::int64_t time_us = 0;
  while (time_us < kRun_s * kSecond_us) {
    const auto dt_us = static_cast<std::int64_t>(5000 + random() % 10'000);
    time_us += dt_us;
    bucket.earn(dt_us);
    state_queue += traffic.state_Bps * double(dt_us) / 1e6;
    rest_queue += traffic.rest_Bps * double(dt_us) / 1e6;
    while (bucket.for_state() && state_queue >= double(traffic.state_bytes)) {
      bucket.spend_on_state(traffic.state_bytes);
      state_queue -= double(traffic.state_bytes);
      state += double(traffic.state_bytes);
    }
    while (bucket.for_rest() && rest_queue >= double(traffic.rest_bytes)) {
      bucket.spend_on_rest(traffic.rest_bytes);
      rest_queue -= double(traffic.rest_bytes);
      rest += double(traffic.rest_bytes);
    }
  }
  return {state / kRun_s, rest / kRun_s};
}

constexpr double kFlood = 1e6;

TEST_CASE("on a saturated link the state gets 60 % and the rest 40 %") {
  for (const std::uint32_t rate_Bps : {250U, 1000U, 5760U, 100'000U}) {
    const Shares got = carried(rate_Bps, {kFlood, kFlood}, 1);
    CAPTURE(rate_Bps);
    CHECK(got.state == doctest::Approx(0.6 * rate_Bps).epsilon(0.01));
    CHECK(got.rest == doctest::Approx(0.4 * rate_Bps).epsilon(0.01));
  }
}

TEST_CASE("bandwidth that one class leaves is available to the other, completely") {
  for (const std::uint32_t rate_Bps : {250U, 1000U, 5760U, 100'000U}) {
    CAPTURE(rate_Bps);
    CHECK(carried(rate_Bps, {kFlood, 0}, 2).state == doctest::Approx(rate_Bps).epsilon(0.01));
    CHECK(carried(rate_Bps, {0, kFlood}, 3).rest == doctest::Approx(rate_Bps).epsilon(0.01));
  }
}

TEST_CASE("each class gets its share, and what the other leaves, whatever the other sends") {
  constexpr std::uint32_t kSeed = 51;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int k = 0; k < 60; ++k) {
    const auto rate = std::uniform_real_distribution(500.0, 10'500.0)(random);
    const auto any = [&] { return rate * std::uniform_real_distribution(0.0, 1.5)(random); };
    const Traffic traffic{any(), any(), 20 + random() % 80, 20 + random() % 80};
    const Shares got =
        carried(static_cast<std::uint32_t>(rate), traffic, static_cast<std::uint32_t>(k));
    const double state_may = std::max(0.6 * rate, rate - traffic.rest_Bps);
    const double rest_may = std::max(0.4 * rate, rate - traffic.state_Bps);
    CAPTURE(rate);
    CAPTURE(traffic.state_Bps);
    CAPTURE(traffic.rest_Bps);
    // The bytes left in the queue at the end, or saved at the start, are within 1 % of the rate.
    CHECK(std::abs(got.state - std::min(traffic.state_Bps, state_may)) <= 0.02 * rate);
    CHECK(std::abs(got.rest - std::min(traffic.rest_Bps, rest_may)) <= 0.02 * rate);
    CHECK(got.state + got.rest <= rate + 0.01 * rate);
  }
}

TEST_CASE("after any sending without permission, each class may send again within 1.5 s") {
  constexpr std::uint32_t kSeed = 52;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int k = 0; k < 500; ++k) {
    TokenBucket bucket;
    bucket.limit(static_cast<std::uint32_t>(1 + random() % 20'000));
    for (auto n = random() % 100; n > 0; --n) {
      bucket.spend_on_rest(random() % 1400);
      bucket.spend_on_state(random() % 1400);
      if (random() % 2 == 0) bucket.earn(kTick_us);
    }
    std::int64_t state_us = 0, rest_us = 0;
    for (std::int64_t t = kTick_us; t <= 2 * kSecond_us; t += kTick_us) {
      bucket.earn(kTick_us);
      if (state_us == 0 && bucket.for_state()) state_us = t;
      if (rest_us == 0 && bucket.for_rest()) rest_us = t;
    }
    CAPTURE(bucket.limit());
    CHECK(state_us > 0);
    CHECK(state_us <= 850'000);
    CHECK(rest_us > 0);
    CHECK(rest_us <= 1'270'000);
  }
}

TEST_CASE("a silent link saves up half a second of credit at most, however long it is silent") {
  for (const std::int64_t gap_us :
       {kTick_us, kSecond_us, 3600 * kSecond_us, std::numeric_limits<std::int64_t>::max()}) {
    TokenBucket bucket;
    bucket.limit(1000);
    for (int k = 0; k < 500; ++k) bucket.earn(gap_us);
    int state = 0, rest = 0;
    for (; bucket.for_state() && state < 2000; ++state) bucket.spend_on_state(1);
    for (; bucket.for_rest() && rest < 2000; ++rest) bucket.spend_on_rest(1);
    CHECK(state == 300);
    CHECK(rest == 200);
  }
}

TEST_CASE("a limited link may not send before it has earned credit, an unlimited one always may") {
  TokenBucket bucket;
  CHECK(bucket.limit() == 0);
  for (int k = 0; k < 1000; ++k) {
    CHECK(bucket.for_state());
    CHECK(bucket.for_rest());
    bucket.spend_on_state(1400);
    bucket.spend_on_rest(1400);
    if (k % 3 == 0) bucket.earn(kTick_us);
  }
  bucket.limit(1000);
  CHECK(bucket.limit() == 1000);
  CHECK_FALSE(bucket.for_state());
  CHECK_FALSE(bucket.for_rest());
  bucket.earn(0);
  CHECK_FALSE(bucket.for_state());
  CHECK_FALSE(bucket.for_rest());
  bucket.earn(kTick_us);  // no earlier debt remains
  CHECK(bucket.for_state());
  CHECK(bucket.for_rest());
}

TEST_CASE("the fastest possible link counts without overflow") {
  TokenBucket bucket;
  bucket.limit(std::numeric_limits<std::uint32_t>::max());
  for (int k = 0; k < 100; ++k) {
    bucket.earn(std::numeric_limits<std::int64_t>::max());
    CHECK(bucket.for_state());
    CHECK(bucket.for_rest());
    for (int n = 0; n < 100; ++n) {
      bucket.spend_on_state(1U << 30U);
      bucket.spend_on_rest(1U << 30U);
    }
    CHECK_FALSE(bucket.for_state());
    CHECK_FALSE(bucket.for_rest());
    bucket.earn(kSecond_us);
  }
}

}  // namespace
}  // namespace flotilla::app
