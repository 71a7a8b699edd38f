// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <random>
#include <utility>
#include <vector>

#include "core/estimation/thrust_response.hpp"
#include "core/piloted_boat.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::core {
namespace {

using testing::Hull;

/// Shares of the port and starboard thrust that are given.
using Shares = std::vector<std::pair<double, double>>;

/// Disturbances of the hull, and the propellers' response to a command.
struct Sailing {
  double port = 1, stbd = 1;     ///< of the thrust asked for, from `from` on
  double from = 10, until = 30;  ///< s
  double drag = 0;               ///< N, an unknown drag of the water
  double noise = 0;              ///< of a force and moment, for 10 ms
};

/// A hull that keeps 0.6 m/s and its heading by a simple loop. Time from the fault until it counts
/// as not responding, s; −1: never; −2: before the fault.
template <class S>
double not_answering_after(const Sailing& how) {
  std::mt19937 engine(7);
  std::normal_distribution<double> force(0, how.noise > 0 ? how.noise : 1);
  ThrustResponseParams<S> params;
  params.vessel = testing::papers_vessel<S>();
  params.propellers = {S(0.25), S(20), S(20)};
  ThrustResponse<S> state;
  Hull hull{{0, 0, 0, 0, 0, 0}};
  for (double t = 0; t < how.until; t += 0.01) {
    const double heading = hull.q[2], u = hull.q[3], r = hull.q[5];
    const Allocation<double> asked =
        allocate(AllocationParams<double>{0.25, 20, 20},
                 Tau<double>{3.436 * 0.6 + 10 * (0.6 - u), -10 * r - 5 * heading});
    Thrust<double> real = asked.thrust;
    if (t >= how.from) real = {how.port * real.port, how.stbd * real.stbd};
    const auto moved = wrench_of(AllocationParams<double>{0.25, 20, 20}, real);
    const double w = how.noise > 0 ? force(engine) : 0, w_N = how.noise > 0 ? force(engine) : 0;
    hull.advance({moved.X + w - how.drag, moved.N + w_N}, 0.01);
    thrust_response_forward(params, state, Nu<S>{S(hull.q[3]), S(hull.q[4]), S(hull.q[5])},
                            Nu<S>{S(0.6), S(0), S(-0.5 * heading)},
                            Tau<S>{S(asked.given.X), S(asked.given.N)}, S(0.01));
    if (!answers(params, state)) return t < how.from ? -2 : t - how.from;
  }
  return -1;
}

TEST_CASE_TEMPLATE("a boat that moves as commanded answers, in noise and against drag", S, float,
                   double) {
  CHECK(not_answering_after<S>({}) == -1);
  CHECK(not_answering_after<S>({.noise = 3.2}) == -1);
  CHECK(not_answering_after<S>({.drag = 1}) == -1);
  CHECK(not_answering_after<S>({.port = 0.7, .stbd = 0.7}) == -1);
}

TEST_CASE_TEMPLATE("propellers that stop are seen within five seconds", S, float, double) {
  for (const double noise : {0.0, 3.2}) {
    for (const auto& [port, stbd] : Shares{{0, 0}, {0, 1}, {1, 0}}) {
      CAPTURE(port);
      CAPTURE(stbd);
      CAPTURE(noise);
      const double after = not_answering_after<S>({.port = port, .stbd = stbd, .noise = noise});
      CHECK(after > 0.1);
      CHECK(after < 5);
    }
  }
}

TEST_CASE_TEMPLATE("propellers that turn the other way are seen within three seconds", S, float,
                   double) {
  for (const double noise : {0.0, 0.5}) {
    for (const auto& [port, stbd] : Shares{{-1, -1}, {-1, 1}, {1, -1}}) {
      CAPTURE(port);
      CAPTURE(stbd);
      CAPTURE(noise);
      const double after = not_answering_after<S>({.port = port, .stbd = stbd, .noise = noise});
      CHECK(after > 0.1);
      CHECK(after < 3);
    }
  }
}

TEST_CASE_TEMPLATE("a boat with little or no thrust is not required to move", S, float, double) {
  ThrustResponseParams<S> params;
  params.vessel = testing::papers_vessel<S>();
  params.propellers = {S(0.25), S(20), S(20)};
  for (const double X : {0.0, 0.8, -0.8}) {  // N; enough to hold a boat in a current of 0.23 m/s
    ThrustResponse<S> state;
    for (int k = 0; k < 3000; ++k) {
      thrust_response_forward(params, state, {}, Nu<S>{S(X), S(0), S(X)}, Tau<S>{S(X), S(0.3 * X)},
                              S(0.01));
      REQUIRE(answers(params, state));
    }
  }
}

TEST_CASE_TEMPLATE(
    "a boat at rest in a current answers if it is meant to stay, not if it is meant to move", S,
    float, double) {
  ThrustResponseParams<S> params;
  params.vessel = testing::papers_vessel<S>();
  params.propellers = {S(0.25), S(20), S(20)};
  for (const double X : {3.4, -3.4, 10.0}) {  // N; enough in a current of 1 m/s, the last in 3 m/s
    for (const double desired : {0.0, 0.05, 0.4}) {
      ThrustResponse<S> state;
      bool answered = true;
      for (int k = 0; k < 6000; ++k) {
        const S u_star = S(X < 0 ? -desired : desired);
        thrust_response_forward(params, state, {}, Nu<S>{u_star}, Tau<S>{S(X), S(0)}, S(0.01));
        answered = answered && answers(params, state);
      }
      CHECK(answered == (desired < 0.1));
    }
  }
}

TEST_CASE("in Q16 no wrench overflows, and a large one without motion is seen as in double") {
  const auto fails_with = []<class S>(S X) {
    ThrustResponseParams<S> params;
    params.vessel = testing::papers_vessel<S>();
    params.propellers = {S(0.25), S(20), S(20)};
    ThrustResponse<S> state;
    for (int k = 0; k < 500; ++k) {
      // the velocity alternates, so that the momentum that is seen has either sign
      const Nu<S> nu{S(k % 40 < 20 ? 3 : -3), S(1), S(k % 40 < 20 ? 2 : -2)};
      thrust_response_forward(params, state, S(0) < X ? Nu<S>{} : nu, Nu<S>{S(1)}, Tau<S>{X, X},
                              S(0.01));
    }
    return !answers(params, state);
  };
  (void)take_overflow<Q16>();
  for (const int X : {1, 2, 10, 1000, -1000}) {
    CAPTURE(X);
    CHECK(fails_with(Q16(X)) == fails_with(static_cast<double>(X)));
  }
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE_TEMPLATE("a boat that did not answer is tested again some seconds after it stopped", S,
                   float, double) {
  ThrustResponseParams<S> params;
  params.vessel = testing::papers_vessel<S>();
  params.propellers = {S(0.25), S(20), S(20)};
  ThrustResponse<S> state;
  for (int k = 0; k < 500; ++k) {
    thrust_response_forward(params, state, {}, Nu<S>{S(1)}, Tau<S>{S(10), S(0)}, S(0.01));
  }
  CHECK_FALSE(answers(params, state));
  int ticks = 0;
  while (!answers(params, state)) {
    thrust_response_forward(params, state, {}, Nu<S>{S(1)}, {}, S(0.01));
    REQUIRE(++ticks < 1000);
  }
  CHECK(ticks > 100);
}

}  // namespace
}  // namespace flotilla::core
