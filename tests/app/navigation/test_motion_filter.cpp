// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "app/navigation/motion_filter.hpp"

namespace flotilla::app {
namespace {

template <class S>
void take(MotionFilter<S>& filter, double u, double dt, bool resumes = false) {
  filter.take({S(0), {S(u), S(0), S(0)}, S(dt)}, resumes);
}

TEST_CASE_TEMPLATE(
    "without smoothing, a track keeps its last state as it is; its fixes are as with smoothing", S,
    float, double) {
  MotionFilter<S> smooth, raw;
  raw.set_smoothing(false);
  for (int k = 0; k <= 10; ++k) {
    const double dt = k == 0 ? 0 : 0.1;
    take(smooth, 0.1 * k, dt);
    take(raw, 0.1 * k, dt);
    const auto fix = raw.take_fix(), same = smooth.take_fix();
    REQUIRE((fix && same));
    CHECK(fix->dt == same->dt);
    CHECK(fix->nu.u == same->nu.u);
    CHECK(raw.track().nu.u == fix->nu.u);
    CHECK(raw.track().nu_dot.u == S(0));
  }
  CHECK(smooth.track().nu_dot.u > S(0.5));
  raw.set_smoothing(true);
  for (int k = 11; k <= 30; ++k) take(raw, 0.1 * k, 0.1);
  CHECK(double(raw.track().nu_dot.u) == doctest::Approx(1).epsilon(0.05));
  raw.set_smoothing(false);  // an old state is not filtered with later ones
  CHECK(raw.track().nu_dot.u == S(0));
}

TEST_CASE_TEMPLATE(
    "of several fixes between two ticks, the last one is used, and its dt covers all of them", S,
    float, double) {
  MotionFilter<S> filter;
  CHECK_FALSE(filter.take_fix());
  take(filter, 2, 0);
  CHECK(filter.take_fix().value().dt == S(0));  // the first state has no predecessor
  CHECK_FALSE(filter.take_fix());
  for (const double dt : {0.1, 0.15, 0.05}) take(filter, 2, dt);
  CHECK(double(filter.take_fix().value().dt) == doctest::Approx(0.3));
  take(filter, 2, 7.7);  // a gap, and one more at once
  take(filter, 2, 0.01);
  CHECK(filter.take_fix().value().dt == S(0));
  filter.forget();
  take(filter, 2, 0);
  CHECK(filter.take_fix().value().dt == S(0));
}

TEST_CASE_TEMPLATE("a filter on standby estimates the acceleration, but produces no fixes", S,
                   float, double) {
  MotionFilter<S> filter;
  filter.stand_by(true);
  take(filter, 0, 0);
  CHECK(filter.take_fix().has_value());  // the first one restarts it
  for (int k = 1; k <= 300; ++k) {
    take(filter, 0.01 * k, 0.01);
    CHECK(std::abs(double(filter.track().nu.u) - 0.01 * k) < 0.04);  // a sudden start
    CHECK_FALSE(filter.take_fix());
  }
  CHECK(double(filter.track().nu_dot.u) == doctest::Approx(1).epsilon(0.05));
  filter.stand_by(false);
  take(filter, 3.01, 0.01);
  CHECK(double(filter.track().nu_dot.u) == doctest::Approx(1).epsilon(0.05));
  CHECK(double(filter.take_fix().value().dt) == doctest::Approx(0.01));
}

}  // namespace
}  // namespace flotilla::app
