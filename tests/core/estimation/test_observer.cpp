// SPDX-License-Identifier: MIT
// The boat's own motion at and between its fixes; test_observer_learning.cpp: estimates from the
// fixes.
#include "core/piloted_boat.hpp"

namespace flotilla::core {
namespace {

using testing::Hull;
using testing::Random;

constexpr std::uint32_t kSeed = 41;

/// Fixes are taken unfiltered; unknown forces are not estimated.
template <class S>
ObserverParams<S> raw() {
  return {};
}

TEST_CASE_TEMPLATE("the boat's position follows its model under the thrust it gives", S, float,
                   double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  const Vessel<S> vessel = testing::papers_vessel<S>();
  for (int run = 0; run < 100; ++run) {
    Hull hull{{0, 0, random.angle(), random(-1, 1), random(-0.2, 0.2), random(-1, 1)}};
    Observer<S> state;
    observer_correct(
        raw<S>(), vessel, state,
        Fix<S>{{}, S(hull.q[2]), {S(hull.q[3]), S(hull.q[4]), S(hull.q[5])}, S(0), S(0)});
    for (int k = 0; k < 20; ++k) {  // 0.2 s: a navigation unit of 5 Hz
      const Tau<double> tau{random(-10, 10), random(-2, 2)};
      hull.advance(tau, 0.01);
      observer_forward(vessel, state, Tau<S>{S(tau.X), S(tau.N)}, S(0.01));
    }
    CHECK(double(state.motion.moved_n.x) == doctest::Approx(hull.q[0]).epsilon(0.01).scale(1));
    CHECK(double(state.motion.moved_n.y) == doctest::Approx(hull.q[1]).epsilon(0.01).scale(1));
    CHECK(double(state.motion.psi) == doctest::Approx(hull.q[2]).epsilon(0.01).scale(1));
    CHECK(double(state.motion.nu.u) == doctest::Approx(hull.q[3]).epsilon(0.02).scale(1));
    CHECK(double(state.motion.nu.r) == doctest::Approx(hull.q[5]).epsilon(0.02).scale(1));
  }
}

TEST_CASE_TEMPLATE("drag that grows with speed slows the boat in its model as on the water", S,
                   float, double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 100; ++run) {
    Hull hull{{0, 0, random.angle(), random(-1.5, 1.5), random(-0.2, 0.2), random(-1, 1)}};
    hull.drag = {random(2, 6), random(0, 2)};
    const bool ahead = hull.q[3] > 0;
    const Vessel<S> vessel{S(1.012), S(1.982), S(0.354),       S(3.436),
                           S(18.99), S(0.864), S(hull.drag.x), S(hull.drag.y)};
    Observer<S> state, plain;
    const Fix<S> fix{{}, S(hull.q[2]), {S(hull.q[3]), S(hull.q[4]), S(hull.q[5])}, S(0), S(0)};
    observer_correct(raw<S>(), vessel, state, fix);
    observer_correct(raw<S>(), testing::papers_vessel<S>(), plain, fix);
    const Tau<double> tau{random(4, 10), random(1, 2)};
    for (int k = 0; k < 20; ++k) {
      hull.advance(tau, 0.01);
      observer_forward(vessel, state, Tau<S>{S(tau.X), S(tau.N)}, S(0.01));
      observer_forward(testing::papers_vessel<S>(), plain, Tau<S>{S(tau.X), S(tau.N)}, S(0.01));
    }
    CHECK(double(state.motion.nu.u) == doctest::Approx(hull.q[3]).epsilon(0.02).scale(1));
    CHECK(double(state.motion.nu.r) == doctest::Approx(hull.q[5]).epsilon(0.02).scale(1));
    if (ahead) CHECK(plain.motion.nu.u > state.motion.nu.u);
  }
}

TEST_CASE_TEMPLATE("a boat knows its acceleration, at a fix as between two", S, float, double) {
  const Vessel<S> vessel = testing::papers_vessel<S>();
  const Tau<S> tau{S(2), S(0.1)};
  Observer<S> state;
  const Fix<S> fix{{}, S(0.3), {S(0.2), S(0.05), S(0.1)}, S(0), S(0)};
  observer_correct(raw<S>(), vessel, state, fix);
  // 0.0401: the last step is so short that a difference over it consists of rounding errors.
  for (const double time : {0.01, 0.0401}) {
    const Nu<S> before = state.motion.nu;
    observer_forward(vessel, state, tau, S(time));
    const Nu<S>& a = state.motion.nu_dot;
    CHECK(std::abs(double(a.u) - double(state.motion.nu.u - before.u) / time) < 0.15);
    CHECK(std::abs(double(a.v) - double(state.motion.nu.v - before.v) / time) < 0.15);
    CHECK(std::abs(double(a.r) - double(state.motion.nu.r - before.r) / time) < 0.05);
    CHECK(std::abs(double(a.u)) > 0.3);
    const Nu<S> kept = a;
    observer_correct(raw<S>(), vessel, state, {{}, fix.psi, state.motion.nu, S(0), S(0.1)});
    CHECK(state.motion.nu_dot.u == kept.u);
    CHECK(state.motion.nu_dot.r == kept.r);
  }
}

TEST_CASE_TEMPLATE("an old fix is carried forward to now", S, float, double) {
  const Vessel<S> vessel = testing::papers_vessel<S>();
  const Tau<S> tau{S(2), S(0.1)};
  Observer<S> at_once, late;
  observer_correct(raw<S>(), vessel, at_once,
                   Fix<S>{{}, S(0.3), {S(0.5), S(0), S(0.1)}, S(0), S(0)});
  observer_forward(vessel, at_once, tau, S(0.1));
  observer_forward(vessel, late, tau, S(0.1));  // from an unknown motion
  observer_correct(raw<S>(), vessel, late,
                   Fix<S>{{}, S(0.3), {S(0.5), S(0), S(0.1)}, S(0.1), S(0)});
  CHECK(late.motion.moved_n.x == at_once.motion.moved_n.x);
  CHECK(late.motion.nu.r == at_once.motion.nu.r);
}

TEST_CASE_TEMPLATE("towing, or wrong damping, is detected", S, float, double) {
  // At 0.6 m/s without thrust: the model would have it stop within a second.
  const Vessel<S> vessel = testing::papers_vessel<S>();
  Observer<S> state;
  double worst = 0;
  for (int k = 0; k < 100; ++k) {
    const Fix<S> fix{{}, S(0), {S(0.6), S(0), S(0)}, S(0), k == 0 ? S(0) : S(0.2)};
    observer_correct(testing::products_law<S>().observer, vessel, state, fix);
    observer_forward(vessel, state, {}, S(0.2));
    if (k > 80) worst = std::max(worst, std::abs(double(state.motion.nu.u) - 0.6));
  }
  CHECK(worst < 0.01);
}

TEST_CASE_TEMPLATE("the first fix, and one after a gap, is taken as it is", S, float, double) {
  Random random(kSeed);
  const Vessel<S> vessel = testing::papers_vessel<S>();
  Observer<S> state;
  state.b = {S(1), S(2), S(3)};
  state.c_n = {S(0.1), S(-0.2)};
  state.motion.moved_n = {S(5), S(6)};
  const Nu<S> nu = testing::arbitrary_nu<S>(random);
  observer_correct(testing::products_law<S>().observer, vessel, state,
                   Fix<S>{{S(7), S(8)}, S(2), nu, S(0), S(0)});
  CHECK(state.motion.moved_n.x == S(0));
  CHECK(state.motion.moved_n.y == S(0));
  CHECK(state.motion.psi == S(2));
  CHECK(state.motion.nu.u == nu.u);
  CHECK(state.motion.nu.r == nu.r);
  CHECK(state.b.u == S(0));
  CHECK(state.b.v == S(0));
  CHECK(state.b.r == S(0));
  CHECK(state.c_n.x == S(0.1));  // the current remains
}

TEST_CASE_TEMPLATE("in a current the boat moves with the water and its thrust", S, float, double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 100; ++run) {
    Hull hull{{0, 0, random.angle(), random(-1, 1), 0, random(-0.5, 0.5)},
              {random(-0.5, 0.5), random(-0.5, 0.5)}};
    const testing::Sighting start = testing::sighting_of(hull);
    Observer<S> state;
    state.c_n = {S(hull.current.x), S(hull.current.y)};
    observer_correct(raw<S>(), testing::papers_vessel<S>(), state,
                     Fix<S>{{}, S(start.psi), testing::in_scalar<S>(start.nu), S(0), S(0)});
    for (int k = 0; k < 50; ++k) {
      const Tau<double> tau{random(-10, 10), random(-2, 2)};
      hull.advance(tau, 0.01);
      observer_forward(testing::papers_vessel<S>(), state, Tau<S>{S(tau.X), S(tau.N)}, S(0.01));
    }
    const testing::Sighting now = testing::sighting_of(hull);
    CHECK(std::abs(double(state.motion.moved_n.x) - now.place.x) < 0.01);
    CHECK(std::abs(double(state.motion.moved_n.y) - now.place.y) < 0.01);
    CHECK(std::abs(double(state.motion.psi) - now.psi) < 0.02);
    CHECK(std::abs(double(state.motion.nu.u) - now.nu.u) < 0.02);
    CHECK(std::abs(double(state.motion.nu.v) - now.nu.v) < 0.02);
    CHECK(std::abs(double(state.motion.nu.r) - now.nu.r) < 0.03);
  }
}

TEST_CASE_TEMPLATE("moment_before gives the motion a moment earlier", S, float, double) {
  const Motion<S> now{{S(1), S(2)}, S(0), {S(0.5), S(0), S(0.1)}, {}};
  const Motion<S> before = moment_before(now, S(0.001));
  CHECK(double(before.moved_n.x) == doctest::Approx(0.9995));
  CHECK(double(before.psi) == doctest::Approx(-0.0001));
}

}  // namespace
}  // namespace flotilla::core
