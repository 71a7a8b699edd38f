// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "core/estimation/model_error.hpp"
#include "core/unlike_hull.hpp"

namespace flotilla::core {
namespace {

using testing::helm;
using testing::UnlikeHull;

template <class S>
struct Learner {
  ModelErrorParams<S> params{.m11 = S(UnlikeHull::m11),
                             .m22 = S(UnlikeHull::m22),
                             .m33 = S(UnlikeHull::m33),
                             .d11 = S(UnlikeHull::d11),
                             .d33 = S(UnlikeHull::d33),
                             .a = S(UnlikeHull::a)};
  ModelError<S> state{};

  void sail(UnlikeHull& hull, double minutes, double turns, double speed = 0.8) {
    for (int i = 0; i < std::lround(600 * minutes); ++i) {
      Tau<double> impulse{};
      for (int k = 0; k < 10; ++k) {
        const Tau<double> tau = helm(hull, turns, speed);
        impulse = {impulse.X + 0.01 * tau.X, impulse.N + 0.01 * tau.N};
        hull.step(tau);
      }
      const Nu<double> nu = hull.seen();
      model_error_forward(params, state,
                          {{S(impulse.X), S(impulse.N)},
                           {S(nu.u), S(nu.v), S(nu.r)},
                           {S(std::sin(hull.psi)), S(std::cos(hull.psi))},
                           {}},
                          S(0.1));
    }
  }
};

template <class S>
void check_near(const Share<S>& share, double truth, double most) {
  CAPTURE(share.value);
  CAPTURE(share.variance);
  CAPTURE(truth);
  CHECK(std::abs(double(share.value) - truth) < most);
  CHECK(std::abs(double(share.value) - truth) < 4 * std::sqrt(double(share.variance)));
}

TEST_CASE_TEMPLATE("in gusty wind, model errors are found within ten minutes", S, float, double) {
  std::mt19937 random{5};
  const auto between = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    UnlikeHull hull{.drag = between(0.5, 2),
                    .yaw_damping = between(0.5, 2),
                    .balance = between(-0.1, 0.1),
                    .wind_n = between(-2, 2),
                    .wind_e = between(-2, 2),
                    .wind_turns = 0.1,
                    .gust = 0.3,
                    .noise = 0.01,
                    .seed = seed};
    Learner<S> learner;
    learner.sail(hull, 10, 1.2);
    check_near(balance_error(learner.state), hull.balance, 0.03);
    check_near(drag_error(learner.state), hull.drag - 1, 0.15);
    check_near(yaw_damping_error(learner.state), hull.yaw_damping - 1, 0.15);
  }
}

TEST_CASE("on a single course no error is found, however long: wind could explain it too") {
  UnlikeHull hull{.drag = 2, .balance = 0.06};
  Learner<float> learner;
  learner.sail(hull, 30, 0);
  CHECK(balance_error(learner.state).variance > 0.02F * 0.02F);
  CHECK(drag_error(learner.state).variance > 0.15F * 0.15F);
  CHECK(yaw_damping_error(learner.state).variance > 0.15F * 0.15F);
}

TEST_CASE("a boat that drifts without thrust learns nothing of its propellers and its turning") {
  UnlikeHull hull{.balance = 0.06, .wind_n = 1};
  Learner<float> learner;
  for (int i = 0; i < 6000; ++i) {
    for (int k = 0; k < 10; ++k) hull.step({});
    const Nu<double> nu = hull.seen();
    model_error_forward(
        learner.params, learner.state,
        {{},
         {static_cast<float>(nu.u), static_cast<float>(nu.v), 0},
         {static_cast<float>(std::sin(hull.psi)), static_cast<float>(std::cos(hull.psi))},
         {}},
        0.1F);
  }
  REQUIRE(learner.state.blocks > 100);
  const ModelError<float> nothing{};
  CHECK(balance_error(learner.state).value == 0);
  CHECK(balance_error(learner.state).variance >= balance_error(nothing).variance);
  CHECK(yaw_damping_error(learner.state).value == 0);
  CHECK(yaw_damping_error(learner.state).variance >= yaw_damping_error(nothing).variance);
  CHECK(drag_error(learner.state).variance > 0.5F);  // wind could explain its drift too
}

TEST_CASE(
    "lasting gusts enlarge the variance of the drag error 15 times, white ones would 10 times") {
  double calm = 0, gusty = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    for (const double gust : {0.0, 1.0}) {
      UnlikeHull hull{.gust = gust, .noise = 0.02, .seed = seed};
      Learner<double> learner;
      learner.sail(hull, 10, 1.2);
      (gust > 0 ? gusty : calm) += drag_error(learner.state).variance;
    }
  }
  CHECK(gusty > 15 * calm);
}

TEST_CASE("an error that was applied to the model is subtracted from the estimated error") {
  UnlikeHull hull{.drag = 1.5, .balance = 0.06};
  Learner<double> learner;
  learner.sail(hull, 5, 1.2);
  const double drag = drag_error(learner.state).value, balance = balance_error(learner.state).value;
  model_error_applied(learner.state, 0.02, 0.1);
  CHECK(balance_error(learner.state).value == doctest::Approx(balance - 0.02));
  CHECK(1.1 * (1 + drag_error(learner.state).value) == doctest::Approx(1 + drag));
}

TEST_CASE("blocks with fast turns, and interrupted blocks, are not used") {
  UnlikeHull hull{};
  Learner<double> learner;
  learner.params.r_max = 0.0001;
  learner.sail(hull, 1, 1.2);
  CHECK(learner.state.blocks == 0);
  Learner<double> cut;
  for (int i = 0; i < 20; ++i) {
    cut.sail(hull, 0.06, 1.2);
    model_error_interrupt(cut.state);
  }
  CHECK(cut.state.blocks == 0);
}

}  // namespace
}  // namespace flotilla::core
