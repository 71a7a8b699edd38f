// SPDX-License-Identifier: MIT
// Messages whose stamps lie close together: their difference is noise, not acceleration.
#include "core/arbitrary.hpp"
#include "core/estimation/track.hpp"

namespace flotilla::core {
namespace {

using testing::Random;

/// Largest error of the predicted speed (true: 1 m/s), with σ 0.02 m/s at 10 Hz; each tenth message
/// is followed by others a millisecond apart.
template <class S>
double worst_of_bursts(int in_burst, std::uint32_t seed) {
  Random random(seed);
  TrackState<S> state;
  double worst = 0;
  for (int k = 0; k < 5000; ++k) {
    const double off = std::normal_distribution<double>(0, 0.02)(random.engine);
    const double dt = k == 0 ? 0 : 10 - in_burst < k % 10 ? 0.001 : 0.1;
    track_update(TrackParams<S>{}, state, {S(0), {S(1 + off), S(0), S(0)}, S(dt)});
    worst = std::max(worst, std::abs(double(track_forward(state, S(0.1)).nu.u) - 1));
  }
  return worst;
}

TEST_CASE_TEMPLATE("messages a millisecond apart do not disturb the speed", S, float, double) {
  for (const std::uint32_t seed : {3U, 4U, 5U}) {
    INFO("seed ", seed);
    CHECK(worst_of_bursts<S>(2, seed) < 0.12);
    CHECK(worst_of_bursts<S>(3, seed) < 0.12);
  }
}

TEST_CASE_TEMPLATE("no spacing of messages takes a track beyond the limits of a vessel", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 21;
  INFO("seed ", kSeed);
  Random random(kSeed);
  double speed = 0, acceleration = 0;
  for (int run = 0; run < 500; ++run) {
    TrackState<S> state;
    const double shortest = std::pow(10, random(-3, 0));
    for (int k = 0; k < 300; ++k) {
      const Nu<S> nu{S(random(-20, 20)), S(random(-20, 20)), S(random(-4, 4))};
      track_update(TrackParams<S>{}, state, {S(random.angle()), nu, S(random(-0.2, 3) * shortest)});
      speed = std::max(speed, std::abs(double(state.nu.u)));
      acceleration = std::max(acceleration, std::abs(double(state.nu_dot.u)));
    }
  }
  CHECK(speed < 60);
  CHECK(acceleration < 1000);
}

TEST_CASE("in Q16 no spacing of messages overflows") {
  for (int raw = 1; raw < 1000; ++raw) {
    CAPTURE(raw);
    q16_overflow = false;
    TrackState<Q16> state;
    track_update(TrackParams<Q16>{}, state, {Q16(0), {}, Q16(0)});
    track_update(TrackParams<Q16>{}, state, {Q16(0), {Q16(1), Q16(0), Q16(0.1)}, Q16::of_raw(raw)});
    CHECK_FALSE(q16_overflow);
    CHECK(std::abs(state.nu_ddot.u.raw()) < 20 * 65'536);
  }
  q16_overflow = false;
}

TEST_CASE_TEMPLATE("a message right after another counts only for its share of the time", S, float,
                   double) {
  // β without cancellation: in float it is that of double for the shortest of spacings.
  for (const double dt : {1e-6, 1e-5, 1e-4, 1e-3}) {
    INFO("spacing ", dt, " s");
    TrackState<S> state;
    track_update(TrackParams<S>{}, state, {S(0), {}, S(0)});
    track_update(TrackParams<S>{}, state, {S(0), {S(1), S(0), S(0)}, S(dt)});
    const double p = dt / (0.02 + dt), q = dt / (1 + dt);
    CHECK(double(state.nu.u) == doctest::Approx(2 * p + q).epsilon(3 * p + 1e-3));
    CHECK(double(state.nu_dot.u) * dt == doctest::Approx(p * p + 2 * p * q).epsilon(2 * p + 1e-3));
    CHECK(double(state.nu_ddot.u) * dt * dt == doctest::Approx(p * p * q).epsilon(1e-3));
  }
}

}  // namespace
}  // namespace flotilla::core
