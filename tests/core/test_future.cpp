// SPDX-License-Identifier: MIT
#include <cmath>

#include "core/arbitrary.hpp"
#include "core/future.hpp"

namespace flotilla::core {
namespace {

using testing::in_scalar;
using testing::number_of;
using testing::Random;

struct Place {
  double x = 0, y = 0, psi = 0;
};

/// Place of a root on this future `to` seconds after the future's time, by small steps.
Place sailed(const Future<double>& future, double psi, double from, double to) {
  constexpr int kSteps = 20000;
  Place at{0, 0, psi};
  const double dt = (to - from) / kSteps;
  for (int k = 0; k < kSteps; ++k) {
    const Nu<double> nu = future_at(future, from + (k + 0.5) * dt);
    at.x += dt * nu.u * std::cos(at.psi + 0.5 * dt * nu.r);
    at.y += dt * nu.u * std::sin(at.psi + 0.5 * dt * nu.r);
    at.psi += dt * nu.r;
  }
  return at;
}

Future<double> arbitrary(Random& random) {
  Future<double> out;
  double u = random(0, 1.5), r = random(-0.3, 0.3);
  for (std::size_t k = 0; k < out.u.size(); ++k) {
    out.u[k] = u;
    out.r[k] = r;
    u += random(-0.1, 0.1);
    r += random(-0.08, 0.08);
  }
  return out;
}

TEST_CASE_TEMPLATE("following the prediction from an old reference gives the root's present motion",
                   S, float, double, Q16) {
  constexpr std::uint32_t kSeed = 83;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 200; ++i) {
    const Future<double> truth = arbitrary(random);
    Future<S> future;
    for (std::size_t k = 0; k < truth.u.size(); ++k) {
      future.u[k] = in_scalar<S>(truth.u[k]);
      future.r[k] = in_scalar<S>(truth.r[k]);
    }
    const double from = random(0, 6), to = from + random(0, 5.9), psi = random.angle();
    const Nu<double> nu = future_at(truth, from);
    auto walk = future_start(
        ReferenceMotion<S>{
            in_scalar<S>(psi), {in_scalar<S>(nu.u), S(0), in_scalar<S>(nu.r)}, {}, {}},
        in_scalar<S>(from));
    const double middle = from + random(0, 1) * (to - from);
    future_forward(future, walk, in_scalar<S>(middle));
    future_forward(future, walk, in_scalar<S>(to));
    const Motion<S> then = future_motion(future, walk, in_scalar<S>(to) - walk.t);
    const Place place = sailed(truth, psi, from, to);
    CAPTURE(from);
    CAPTURE(to);
    CHECK(std::abs(number_of(then.moved_n.x) - place.x) < 0.01);
    CHECK(std::abs(number_of(then.moved_n.y) - place.y) < 0.01);
    CHECK(std::abs(std::remainder(number_of(then.psi) - place.psi, 2 * M_PI)) < 2e-3);
    CHECK(std::abs(number_of(then.nu.u) - future_at(truth, to).u) < 5e-3);
  }
}

TEST_CASE(
    "after the last sample the motion is constant; before the first it approaches that sample") {
  Future<double> future;
  future.u.fill(1);
  future.r.fill(0.1);
  const Nu<double> late = future_at(future, 20.0), early = future_at(future, -3.0);
  CHECK(late.u == 1);
  CHECK(early.r == 0.1);
  auto walk = future_start(ReferenceMotion<double>{0, {0.5, 0, 0}, {}, 0}, -2.0);
  future_forward(future, walk, 0.0);
  CHECK(walk.motion.nu.u == doctest::Approx(1));
  CHECK(walk.motion.moved_n.x == doctest::Approx(1.5).epsilon(0.01));
  future_forward(future, walk, 30.0);
  CHECK(future_motion(future, walk, 18.0).nu.u == doctest::Approx(1));
}

TEST_CASE("a root that deviates from its predicted motion is noticed") {
  Future<double> future;
  future.u.fill(0.6);
  CHECK(future_holds(future, {0.6, 0, 0}, 3.0));
  CHECK(future_holds(future, {0.55, 0, 0.03}, 3.0));
  CHECK_FALSE(future_holds(future, {0.3, 0, 0}, 3.0));
  CHECK_FALSE(future_holds(future, {0.6, 0, 0.2}, 3.0));
  CHECK(future_holds(future, {0.1, 0, 0.2}, -0.1));  // from before it began
}

}  // namespace
}  // namespace flotilla::core
