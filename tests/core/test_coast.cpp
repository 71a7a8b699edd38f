// SPDX-License-Identifier: MIT
#include <cmath>

#include "core/arbitrary.hpp"
#include "core/coast.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Random;

template <class S>
Motion<S> motion(double psi, double u, double v, double r) {
  Motion<S> m;
  m.psi = S(psi);
  m.nu = {S(u), S(v), S(r)};
  return m;
}

/// Dead-reckons for `seconds` in steps of h.
template <class S>
CoastState<S> coasted(const Motion<S>& from, double T, double seconds, double h) {
  CoastState<S> state = coast_start(from);
  for (int k = 0; k < std::lround(seconds / h); ++k) coast_forward(S(T), state, S(h));
  return state;
}

TEST_CASE_TEMPLATE(
    "a leader that sailed straight stops after two thirds of the distance at full speed", S, float,
    double) {
  const auto state = coasted(motion<S>(0.7, 1.5, -0.2, 0), 5, 5, 0.01);
  const Vec2<double> way = to_north_east(0.7, Vec2<double>{1.5 * 10 / 3, -0.2 * 10 / 3});
  CHECK(std::abs(double(state.leader.moved_n.x) - way.x) < 1e-4);
  CHECK(std::abs(double(state.leader.moved_n.y) - way.y) < 1e-4);
  CHECK(state.leader.psi == approx(S(0.7)));
  CHECK(std::abs(state.leader.nu.u) < S(1e-5));
}

TEST_CASE_TEMPLATE("a leader that sailed a circle slows down on it", S, float, double) {
  constexpr std::uint32_t kSeed = 71;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 50; ++i) {
    const double psi = random.angle(), u = random(-2, 2), v = random(-0.5, 0.5),
                 r = random(0.05, 0.8);
    const double T = random(1, 10), seconds = random(0, T);
    const auto state = coasted(motion<S>(psi, u, v, r), T, seconds, 0.01);
    const double t = 0.01 * std::round(seconds / 0.01);
    const double arc = t - t * t * t / (3 * T * T);  // s at full speed, by the integral
    const double chord = 2 / r * std::sin(0.5 * r * arc);
    const auto way = to_north_east(psi + 0.5 * r * arc, Vec2<double>{u * chord, v * chord});
    CHECK(std::abs(double(state.leader.moved_n.x) - way.x) < 1e-3);
    CHECK(std::abs(double(state.leader.moved_n.y) - way.y) < 1e-3);
    CHECK(std::abs(wrap_pi(double(state.leader.psi) - psi - r * arc)) < 1e-4);
    CHECK(std::abs(double(state.leader.nu.u) - u * (1 - t * t / T / T)) < 1e-4);
    CHECK(std::abs(double(state.leader.nu.r) - r * (1 - t * t / T / T)) < 1e-4);
  }
}

TEST_CASE("the leader's acceleration is the slope of its velocity, and zero once it is at rest") {
  const Motion<double> from = motion<double>(1, 0.8, 0.1, -0.2);
  auto state = coast_start(from);
  for (int k = 0; k < 300; ++k) {
    const Nu<double> before = state.leader.nu;
    coast_forward(2.0, state, 0.01);
    const Nu<double>& nu = state.leader.nu;
    const Nu<double>& nu_dot = state.leader.nu_dot;
    // The slope over a step is that at its middle.
    if (k < 199) CHECK(std::abs((nu.u - before.u) / 0.01 - nu_dot.u) < 0.00201);
    if (k < 199) CHECK(std::abs((nu.r - before.r) / 0.01 - nu_dot.r) < 0.00201);
    if (k >= 200) CHECK((nu.u == 0 && nu.r == 0 && nu_dot.u == 0 && nu_dot.r == 0));
    CHECK(std::abs(nu.u) <= std::abs(before.u));
  }
}

TEST_CASE_TEMPLATE("a leader extrapolated by no time has not moved yet", S, float, double) {
  auto state = coast_start(motion<S>(2, 1, 0, 0.3));
  coast_forward(S(5), state, S(0));
  CHECK(state.leader.moved_n.x == S(0));
  CHECK(state.leader.psi == S(2));
  CHECK(state.leader.nu.u == S(1));
}

TEST_CASE_TEMPLATE("no command exceeds the limit, and commands within it stay unchanged", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 72;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const Thrust<S> asked{S(random(-1, 1)), S(random(-1, 1))};
    const S most = S(random(0, 1));
    const Thrust<S> given = limited(asked, most);
    CHECK(max(abs(given.port), abs(given.stbd)) <= most);
    if (max(abs(asked.port), abs(asked.stbd)) <= most) {
      CHECK(given.port == approx(asked.port));
      CHECK(given.stbd == approx(asked.stbd));
    }
    // Yaw has priority, and neither surge nor turn is reversed.
    const S d = asked.port - asked.stbd, m = asked.port + asked.stbd;
    const S d_given = given.port - given.stbd, m_given = given.port + given.stbd;
    CHECK(abs(d_given - clamp(d, S(-2) * most, S(2) * most)) < S(1e-6));
    CHECK(double(m * m_given) >= -1e-6);
    CHECK(abs(m_given) <= abs(m) + S(1e-6));
  }
  CHECK(limited(Thrust<S>{S(1), S(-1)}, S(0)).port == S(0));
}

}  // namespace
}  // namespace flotilla::core
