// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "core/closed_loop.hpp"
#include "core/dead_reckoning.hpp"

namespace flotilla::core {
namespace {

using testing::Hull;
using testing::Random;

constexpr std::uint32_t kSeed = 41;

TEST_CASE_TEMPLATE("a boat is where its model takes it under the thrust that it gives", S, float,
                   double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  const Vessel<S> vessel = testing::papers_vessel<S>();
  for (int run = 0; run < 100; ++run) {
    Hull hull{{0, 0, random.angle(), random(-1, 1), random(-0.2, 0.2), random(-1, 1)}};
    Reckoning<S> state;
    reckon_from(ReckoningParams<S>{}, vessel, state,
                Fix<S>{S(hull.q[2]), {S(hull.q[3]), S(hull.q[4]), S(hull.q[5])}, S(0), S(0)}, {});
    for (int k = 0; k < 20; ++k) {  // 0.2 s: a navigation unit of 5 Hz
      const Tau<double> tau{random(-10, 10), random(-2, 2)};
      hull.advance(tau, 0.01);
      reckon_forward(vessel, state, Tau<S>{S(tau.X), S(tau.N)}, S(0.01));
    }
    CHECK(double(state.motion.moved_n.x) == doctest::Approx(hull.q[0]).epsilon(0.01).scale(1));
    CHECK(double(state.motion.moved_n.y) == doctest::Approx(hull.q[1]).epsilon(0.01).scale(1));
    CHECK(double(state.motion.psi) == doctest::Approx(hull.q[2]).epsilon(0.01).scale(1));
    CHECK(double(state.motion.nu.u) == doctest::Approx(hull.q[3]).epsilon(0.02).scale(1));
    CHECK(double(state.motion.nu.r) == doctest::Approx(hull.q[5]).epsilon(0.02).scale(1));
  }
}

TEST_CASE_TEMPLATE("a boat knows its acceleration, at a fix as between two", S, float, double) {
  const Vessel<S> vessel = testing::papers_vessel<S>();
  const Tau<S> tau{S(2), S(0.1)};
  Reckoning<S> state;
  const Fix<S> fix{S(0.3), {S(0.2), S(0.05), S(0.1)}, S(0), S(0)};
  reckon_from(ReckoningParams<S>{}, vessel, state, fix, tau);
  // 0.0401: the last of the steps is so short that a difference over it is all rounding.
  for (const double time : {0.01, 0.0401}) {
    const Nu<S> before = state.motion.nu;
    reckon_forward(vessel, state, tau, S(time));
    const Nu<S>& a = state.motion.nu_dot;
    CHECK(std::abs(double(a.u) - double(state.motion.nu.u - before.u) / time) < 0.15);
    CHECK(std::abs(double(a.v) - double(state.motion.nu.v - before.v) / time) < 0.15);
    CHECK(std::abs(double(a.r) - double(state.motion.nu.r - before.r) / time) < 0.05);
    CHECK(std::abs(double(a.u)) > 0.3);
    const Nu<S> kept = a;
    reckon_from(ReckoningParams<S>{}, vessel, state, {fix.psi, state.motion.nu, S(0), S(0.1)}, tau);
    CHECK(state.motion.nu_dot.u == kept.u);
    CHECK(state.motion.nu_dot.r == kept.r);
  }
}

TEST_CASE_TEMPLATE("an old fix is carried forward to now", S, float, double) {
  const Vessel<S> vessel = testing::papers_vessel<S>();
  const Tau<S> tau{S(2), S(0.1)};
  Reckoning<S> at_once, late;
  reckon_from(ReckoningParams<S>{}, vessel, at_once,
              Fix<S>{S(0.3), {S(0.5), S(0), S(0.1)}, S(0), S(0)}, tau);
  reckon_forward(vessel, at_once, tau, S(0.1));
  reckon_from(ReckoningParams<S>{}, vessel, late,
              Fix<S>{S(0.3), {S(0.5), S(0), S(0.1)}, S(0.1), S(0)}, tau);
  CHECK(late.motion.moved_n.x == at_once.motion.moved_n.x);
  CHECK(late.motion.nu.r == at_once.motion.nu.r);
}

TEST_CASE_TEMPLATE("a boat that is towed, or whose damping is mistaken, is found out", S, float,
                   double) {
  // At 0.6 m/s without thrust: the model would have it stop within a second.
  const Vessel<S> vessel = testing::papers_vessel<S>();
  Reckoning<S> state;
  double worst = 0;
  for (int k = 0; k < 60; ++k) {
    const Fix<S> fix{S(0), {S(0.6), S(0), S(0)}, S(0), k == 0 ? S(0) : S(0.2)};
    reckon_from(ReckoningParams<S>{}, vessel, state, fix, {});
    reckon_forward(vessel, state, {}, S(0.2));
    if (k > 40) worst = std::max(worst, std::abs(double(state.motion.nu.u) - 0.6));
  }
  CHECK(worst < 0.01);
}

TEST_CASE_TEMPLATE("steps of any length and any thrust leave numbers that are finite", S, float,
                   double) {
  Random random(kSeed);
  const Vessel<S> vessel = testing::papers_vessel<S>();
  Reckoning<S> state;
  for (int k = 0; k < 2000; ++k) {
    reckon_forward(vessel, state, Tau<S>{S(random(-1000, 1000)), S(random(-1000, 1000))},
                   S(random(-1, 5)));
    const Fix<S> fix{S(random.angle()), testing::arbitrary_nu<S>(random), S(random(-1, 3)),
                     S(random(-1, 3))};
    if (k % 10 == 0) reckon_from(ReckoningParams<S>{}, vessel, state, fix, {});
    REQUIRE(std::isfinite(state.motion.nu.u));
    REQUIRE(std::isfinite(state.motion.nu.r));
    REQUIRE(std::isfinite(state.bias.u));
    REQUIRE(std::isfinite(state.motion.moved_n.x));
  }
}

TEST_CASE_TEMPLATE("a moment before, the boat was a moment back", S, float, double) {
  const Motion<S> now{{S(1), S(2)}, S(0), {S(0.5), S(0), S(0.1)}, {}};
  const Motion<S> before = moment_before(now, S(0.001));
  CHECK(double(before.moved_n.x) == doctest::Approx(0.9995));
  CHECK(double(before.psi) == doctest::Approx(-0.0001));
}

}  // namespace
}  // namespace flotilla::core
