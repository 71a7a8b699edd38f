// SPDX-License-Identifier: MIT
// Prediction of a vessel between its messages; test_track_messages.cpp: updates by messages.
#include "core/arbitrary.hpp"
#include "core/estimation/track.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::kPi;
using testing::Random;

template <class S>
TrackState<S> arbitrary_state(Random& random) {
  TrackState<S> state;
  state.psi = S(random.angle());
  state.nu = testing::arbitrary_nu<S>(random);
  state.nu_dot = testing::arbitrary_nu<S>(random);
  state.nu_ddot = testing::arbitrary_nu<S>(random);
  state.started = true;
  return state;
}

TEST_CASE_TEMPLATE("a leader at constant velocity is carried forward along its straight line", S,
                   float, double) {
  TrackState<S> state;
  state.psi = S(0.7);
  state.nu = {S(1.5), S(-0.2), S(0)};
  const Motion<S> m = track_forward(state, S(2));
  const Vec2<S> way = to_north_east(S(0.7), Vec2<S>{S(3), S(-0.4)});
  CHECK(m.moved_n.x == approx(way.x));
  CHECK(m.moved_n.y == approx(way.y));
  CHECK(m.psi == approx(S(0.7)));
  CHECK(m.nu.u == approx(S(1.5)));
  CHECK(m.nu_dot.u == approx(S(0)));
}

TEST_CASE_TEMPLATE("a turning leader is carried forward along its circle", S, float, double) {
  constexpr std::uint32_t kSeed = 19;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const double u = random(-3, 3), v = random(-1, 1), r = random(-1, 1), psi = random.angle();
    const double h = random(0, 1);
    TrackState<S> state;
    state.psi = S(psi);
    state.nu = {S(u), S(v), S(r)};
    const Motion<S> m = track_forward(state, S(h));
    const double chord = std::abs(r) < 1e-9 ? h : 2 / r * std::sin(0.5 * r * h);
    const auto exact = to_north_east(psi + 0.5 * r * h, Vec2<double>{u * chord, v * chord});
    const double bound = r * r * h * h / 24 * h * std::hypot(u, v) + 1e-5;
    CHECK(std::abs(double(m.moved_n.x) - exact.x) <= bound);
    CHECK(std::abs(double(m.moved_n.y) - exact.y) <= bound);
    CHECK(m.psi == approx(S(psi + r * h), 4));
  }
}

TEST_CASE("at any age, the derivative of velocity is the acceleration, of heading the yaw rate") {
  constexpr std::uint32_t kSeed = 51;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const auto state = arbitrary_state<double>(random);
    const double age = random(0.01, 10);
    constexpr double h = 1e-4;
    const Motion<double> before = track_forward(state, age - h);
    const Motion<double> now = track_forward(state, age);
    const Motion<double> after = track_forward(state, age + h);
    // Where the jerk ends, after a second, the acceleration has a corner: half a step's worth.
    const double corner = std::abs(age - 1) < h ? 2 * h : 0;
    CHECK(std::abs((after.nu.u - before.nu.u) / (2 * h) - now.nu_dot.u) < 1e-6 + corner);
    CHECK(std::abs((after.nu.v - before.nu.v) / (2 * h) - now.nu_dot.v) < 1e-6 + corner);
    CHECK(std::abs((after.nu.r - before.nu.r) / (2 * h) - now.nu_dot.r) < 1e-6 + corner);
    CHECK(std::abs((after.psi - before.psi) / (2 * h) - now.nu.r) < 1e-5 + corner);
  }
}

TEST_CASE_TEMPLATE("a leader's jerk is extrapolated for no longer than a second", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 52;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 200; ++i) {
    const auto state = arbitrary_state<S>(random);
    const Nu<S> young = track_forward(state, S(0.5)).nu_dot;
    CHECK(young.u == approx(state.nu_dot.u + S(0.5) * state.nu_ddot.u, 5));
    CHECK(young.r == approx(state.nu_dot.r + S(0.5) * state.nu_ddot.r, 5));
    const Nu<S> at_a_second = track_forward(state, S(1)).nu_dot;
    CHECK(at_a_second.v == approx(state.nu_dot.v + state.nu_ddot.v, 5));
    const Nu<S> old = track_forward(state, S(random(1, 10))).nu_dot;
    CHECK(old.u == at_a_second.u);
    CHECK(old.v == at_a_second.v);
    CHECK(old.r == at_a_second.r);
  }
}

TEST_CASE_TEMPLATE("a message of age zero gives the position without uncertainty", S, float,
                   double) {
  Random random(53);
  const auto state = arbitrary_state<S>(random);
  const Motion<S> m = track_forward(state, S(0));
  CHECK(m.moved_n.x == S(0));
  CHECK(m.moved_n.y == S(0));
  CHECK(m.psi == state.psi);
  CHECK(m.nu.r == state.nu.r);
  CHECK(m.nu_dot.r == state.nu_dot.r);
  const Motion<S> never_heard = track_forward(TrackState<S>{}, S(10));
  CHECK(never_heard.moved_n.x == S(0));
  CHECK(never_heard.nu.u == S(0));
}

TEST_CASE_TEMPLATE("the older the message, the less certain the leader's position", S, float,
                   double) {
  Random random(54);
  for (int i = 0; i < 200; ++i) {
    auto state = arbitrary_state<S>(random);
    state.a = S(random(0.05, 3));
    const double t = random(0, 0.1), speed = std::hypot(double(state.nu.u), double(state.nu.v));
    S last = S(-1);
    for (const double age : {0.0, 0.1, 0.5, 2.0, 10.0}) {
      const S sigma = track_uncertainty(state, S(age), S(t));
      CHECK(last < sigma);
      CHECK(sigma == approx(S(speed * t + double(state.a) * age * age / 2), 100));
      last = sigma;
    }
    // A clock error t shifts the vessel by the distance that it covers in that time.
    const S clock = track_uncertainty(state, S(1), S(t)) - track_uncertainty(state, S(1), S(0));
    CHECK(clock == approx(S(speed * t), 5));
  }
}

}  // namespace
}  // namespace flotilla::core
