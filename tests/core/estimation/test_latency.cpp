// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <deque>
#include <random>

#include "core/estimation/latency.hpp"

namespace flotilla::core {
namespace {

/// A boat that turns under a moment, with a model that is wrong by half, and a unit that sends its
/// yaw rate late.
struct Turning {
  double tau_s, period_s;
  double share = 1, damping = 2.4;  ///< of the moment; of the true boat
  double noise = 0.0035;
  std::mt19937 random{7};
  std::deque<double> r{0};  ///< at every tick, the newest first
  Latency<float> state{};
  LatencyParams<float> params{.d = 2.4F};
  int ticks = 0;

  /// One tick of 10 ms.
  void step(double n) {
    latency_forward(state, static_cast<float>(n), 0.01F);
    r.push_front(r.front() + 0.01 * (share * n - damping * r.front()));
    const auto late = static_cast<std::size_t>(std::lround(100 * tau_s));
    if (++ticks % static_cast<int>(std::lround(100 * period_s)) != 0 || r.size() <= late) return;
    const double told = r[late] + noise * std::normal_distribution<double>()(random);
    latency_correct(params, state, static_cast<float>(told), 0.0F, static_cast<float>(period_s));
  }

  /// A moment like the law's: it follows a course that changes, with noise.
  void sail(double seconds) {
    double tremble = 0;
    for (int i = 0; i < std::lround(100 * seconds); ++i) {
      if (i % 5 == 0) tremble = std::normal_distribution<double>(0, 0.5)(random);
      step(0.8 * std::sin(0.003 * i) + tremble);
    }
  }
  Late<float> late() const { return latency_of(params, state); }
};

TEST_CASE("a navigation unit's latency is found within 0.02 s, whatever its rate and the hull") {
  for (const double tau_s : {0.0, 0.07, 0.2, 0.33, 0.45}) {
    for (const double period_s : {0.02, 0.05, 0.1}) {
      for (const auto& [share, damping] : {std::pair{1.0, 2.4}, {0.67, 3.6}, {2.0, 1.2}}) {
        CAPTURE(tau_s);
        CAPTURE(period_s);
        CAPTURE(share);
        Turning boat{.tau_s = tau_s, .period_s = period_s, .share = share, .damping = damping};
        boat.sail(20);
        CHECK(boat.late().known);
        CHECK(std::abs(double{boat.late().tau} - tau_s) < 0.02);
      }
    }
  }
}

TEST_CASE("a boat at rest or on a straight course gives no estimate of the latency") {
  for (const double n : {0.0, 0.5}) {
    Turning boat{.tau_s = 0.2, .period_s = 0.05};
    for (int i = 0; i < 6000; ++i) boat.step(n);
    CHECK_FALSE(boat.late().known);
  }
}

TEST_CASE("a latency beyond all hypotheses counts as the greatest of them") {
  Turning boat{.tau_s = 0.8, .period_s = 0.05};
  boat.sail(60);
  CHECK((!boat.late().known || boat.late().tau > 0.4F));
}

TEST_CASE("the impulse between two instants does not depend on the length of the ticks") {
  // n grows by 1 rad/s² a second: 0 a second ago, 1 now
  const auto integral = [](float from, float to) {
    return from - to - 0.5F * (from * from - to * to);
  };
  for (const float tick : {0.0025F, 0.01F, 0.013F, 0.02F}) {
    Latency<float> state;
    const int count = static_cast<int>(1.0F / tick);
    for (int i = 0; i < count; ++i) {
      const float middle = 1.0F - (static_cast<float>(count - i) - 0.5F) * tick;
      latency_forward(state, middle, tick);
    }
    for (const float from : {0.05F, 0.31F, 0.9F}) {
      for (const float to : {0.0F, 0.012F, 0.04F}) {
        CAPTURE(tick);
        CAPTURE(from);
        CAPTURE(to);
        CHECK(latency_impulse(state, from, to) ==
              doctest::Approx(integral(from, to)).epsilon(0.01));
      }
    }
  }
}

}  // namespace
}  // namespace flotilla::core
