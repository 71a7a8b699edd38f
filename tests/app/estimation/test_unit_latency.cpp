// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>

#include "app/estimation/unit_latency.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kTick_us = 10'000;
constexpr float kInertia = 0.5F;

/// A boat that turns under a moment, and a unit that sends its yaw rate every 50 ms, 0.2 s late.
struct Turning {
  UnitLatency latency;
  std::mt19937 random{7};
  std::deque<double> r{0};  // at every tick, the newest first
  std::int64_t now_us = kTick_us;
  float fastest = 0;  // change of the lag from fix to fix, s
  bool waits = true, observes = true;

  explicit Turning(std::optional<float> named_s = {}) {
    latency.configure({.d = 2.4F}, kInertia, named_s);
  }
  std::int64_t lag_us() const { return latency.lag_us().value_or(0); }

  void sail(double seconds) {
    double tremble = 0;
    for (int i = 1; i <= std::lround(100 * seconds); ++i, now_us += kTick_us) {
      if (i % 5 == 0) tremble = std::normal_distribution<double>(0, 0.5)(random);
      const double n = 0.8 * std::sin(0.003 * i) + tremble;
      latency.look_at_clock(waits, observes, now_us);
      r.push_front(r.front() + 0.01 * (n - 2.4 * r.front()));
      if (!latency.estimates()) continue;
      latency.push(static_cast<float>(n) * kInertia * 0.01F, 0.01F);
      if (i % 5 != 0 || r.size() < 21) continue;
      const std::int64_t before_us = lag_us();
      const bool moved = latency.correct(static_cast<float>(r[20]), 0.05F, before_us);
      REQUIRE((moved || lag_us() == before_us));
      fastest = std::max(fastest, std::abs(static_cast<float>(lag_us() - before_us)) * 1e-6F);
    }
  }
};

TEST_CASE("a unit that is 0.2 s late is compensated for, by a fifth of a second a second at most") {
  Turning boat;
  CHECK_FALSE(boat.latency.lag_us());
  CHECK(boat.latency.uncompensated_s() == 0.3F);  // no estimate yet
  boat.sail(30);
  REQUIRE(boat.latency.found_s());
  CHECK(*boat.latency.found_s() == doctest::Approx(0.2).epsilon(0.1));
  CHECK(static_cast<double>(boat.lag_us()) == doctest::Approx(2e5).epsilon(0.1));
  CHECK(boat.latency.uncompensated_s() < 0.01F);
  CHECK(boat.fastest <= 0.2F * 0.05F + 2e-6F);
  CHECK(boat.fastest > 0.005F);
  CHECK(boat.latency.is_bearable());
}

TEST_CASE("a boat whose unit answers TIMESYNC, or that has no observer, estimates no latency") {
  for (const bool answers : {true, false}) {
    Turning boat(0.05F);
    boat.waits = !answers;
    boat.observes = answers;
    boat.sail(5);
    CHECK_FALSE(boat.latency.estimates());
    CHECK_FALSE(boat.latency.found_s());
    CHECK(boat.latency.lag_us() == 50'000);
  }
}

TEST_CASE("an estimate is discarded when TIMESYNC is answered, or another latency is set") {
  for (const bool answers : {true, false}) {
    Turning boat;
    boat.sail(30);
    REQUIRE(boat.latency.found_s());
    if (answers) {
      boat.waits = false;
      boat.sail(0.01);
    } else {
      boat.latency.configure({.d = 2.4F}, kInertia, 0.1F);
    }
    CHECK_FALSE(boat.latency.found_s());
    CHECK(boat.latency.lag_us() == (answers ? std::nullopt : std::optional(100'000)));
  }
}

TEST_CASE("a known latency of 0.4 s is more than can be compensated") {
  CHECK_FALSE(Turning(0.4F).latency.is_bearable());
  CHECK(Turning(0.35F).latency.is_bearable());
}

}  // namespace
}  // namespace flotilla::app
