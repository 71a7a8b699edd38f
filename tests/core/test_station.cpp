// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <type_traits>

#include "core/scalar/fixed.hpp"
#include "core/station.hpp"

namespace flotilla::core {
namespace {

/// A number that is not known when the test is compiled.
template <class S>
S of(double x) {
  if constexpr (std::is_same_v<S, Q16>) {
    return Q16::of_raw(static_cast<std::int32_t>(std::lround(65536 * x)));
  } else {
    return static_cast<S>(x);
  }
}

/// A boat with a given distance from its slot in each tick.
template <class S>
struct Watch {
  StationParams<S> params{.D = S(5), .Delta = S(1), .r_max = S(0.8)};
  StationState<S> state{};
  StationInput<S> in{};

  /// Passes `seconds`; off(t): distance t seconds after the start. Returns the time until the
  /// station is lost, or −1.
  template <class Off>
  double pass(double seconds, Off off) {
    for (int k = 0; k < std::lround(seconds * 50); ++k) {
      in.distance = of<S>(off(0.02 * k));
      station_forward(params, state, in, S(0.02));
      if (state.loss != StationLoss::kNo) return 0.02 * k;
    }
    return -1;
  }
  double stay(double seconds, double off_m) {
    return pass(seconds, [=](double) { return off_m; });
  }
};

TEST_CASE_TEMPLATE("a boat that gives way out of its slot has not left it, and closes up anew", S,
                   float, double, Q16) {
  Watch<S> w;
  CHECK(w.stay(4, 0.5) == -1);
  w.in.yields = true;
  CHECK(w.stay(20, 8) == -1);
  w.in.yields = false;
  CHECK(w.pass(20, [](double t) { return 8 - 0.375 * t; }) == -1);
  CHECK(w.stay(4, 0.5) == -1);
  CHECK(w.stay(4, 8) == doctest::Approx(1).epsilon(0.05));
}

TEST_CASE_TEMPLATE("a boat that yielded as it closed up has time for the way back", S, float,
                   double, Q16) {
  Watch<S> w;
  CHECK(w.pass(20, [](double t) { return 30 - t; }) == -1);
  w.in.yields = true;
  CHECK(w.stay(20, 40) == -1);
  w.in.yields = false;
  w.in.limited = true;
  CHECK(w.pass(39, [](double t) { return 40 - t; }) == -1);
}

TEST_CASE_TEMPLATE(
    "regaining the distance lost by yielding, again and again, does not count as progress", S,
    float, double, Q16) {
  Watch<S> w;
  CHECK(w.pass(20, [](double t) { return 22 - t; }) == -1);
  double until = 0;
  while (until < 900 && w.state.loss == StationLoss::kNo) {
    w.in.yields = true;
    w.pass(3, [](double t) { return 2 + 0.1 * t; });
    w.in.yields = false;
    w.pass(5, [](double t) { return 2.3 - 0.06 * t; });
    until += 8;
  }
  CHECK(w.state.loss == StationLoss::kStuck);
}

TEST_CASE_TEMPLATE("a slot that moves again and again does not hide a boat that makes no progress",
                   S, float, double, Q16) {
  Watch<S> w;
  double until = 0;
  while (until < 200 && w.state.loss == StationLoss::kNo) {
    station_moved(w.state);
    w.stay(5, std::fmod(until, 10) < 5 ? 60 : 20);
    until += 5;
  }
  CHECK(w.state.loss == StationLoss::kStuck);
  CHECK(until < 70);
}

TEST_CASE_TEMPLATE("a boat that still turns in its slot does not count as having reached it", S,
                   float, double, Q16) {
  Watch<S> w;
  w.in.turns = true;
  CHECK(w.stay(10, 0.5) == -1);
  CHECK(w.stay(10, 8) == -1);
  w.in.turns = false;
  CHECK(w.stay(4, 0.5) == -1);
  w.in.turns = true;
  CHECK(w.stay(4, 8) == doctest::Approx(1).epsilon(0.05));
}

TEST_CASE_TEMPLATE("a boat that was in its slot and is 5 m off for a second has left it", S, float,
                   double, Q16) {
  Watch<S> w;
  CHECK(w.stay(4, 0.5) == -1);
  CHECK(w.state.in);
  CHECK(w.stay(30, 4.9) == -1);
  CHECK_FALSE(w.state.in);
  CHECK(w.stay(0.9, 5.2) == -1);
  CHECK(w.stay(1, 4.9) == -1);
  const double after = w.stay(10, 5.2);
  CHECK(after > 0.9);
  CHECK(after < 1.2);
  CHECK(w.state.loss == StationLoss::kLeft);
}

TEST_CASE_TEMPLATE("a boat that left its slot is back in formation after a second in it", S, float,
                   double, Q16) {
  Watch<S> w;
  w.stay(4, 0);
  w.stay(2, 6);
  REQUIRE(w.state.loss == StationLoss::kLeft);
  w.stay(0.02, 4);
  CHECK(w.state.loss == StationLoss::kLeft);
  for (int k = 0; k < 40; ++k) w.stay(0.02, 0.9);
  CHECK(w.state.loss == StationLoss::kLeft);
  for (int k = 0; k < 20; ++k) w.stay(0.02, 0.9);
  CHECK(w.state.loss == StationLoss::kNo);
}

TEST_CASE_TEMPLATE("a boat that passed through its slot is still closing up", S, float, double,
                   Q16) {
  Watch<S> w;
  CHECK(w.stay(2, 0.5) == -1);
  CHECK(w.stay(20, 8) == -1);
}

TEST_CASE_TEMPLATE("a boat that closes up is judged by its progress, however far it is", S, float,
                   double, Q16) {
  CHECK(Watch<S>{}.pass(900, [](double t) { return 995 - t; }) == -1);
  // It turns first, while its leader sails away.
  CHECK(Watch<S>{}.pass(120, [](double t) { return t < 10 ? 50 + t : 60 - 0.5 * (t - 10); }) == -1);
  Watch<S> idle;
  const double after = idle.stay(100, 20);
  CHECK(after > 59);
  CHECK(after < 61);
  CHECK(idle.state.loss == StationLoss::kStuck);
}

TEST_CASE_TEMPLATE("a boat at a limit has half the time to make progress", S, float, double, Q16) {
  Watch<S> w;
  w.in.limited = true;
  const double after = w.stay(100, 20);
  CHECK(after > 29);
  CHECK(after < 31);
}

TEST_CASE_TEMPLATE("a boat that makes way for another is not stuck", S, float, double, Q16) {
  Watch<S> w;
  w.in.yields = true;
  CHECK(w.stay(200, 20) == -1);
}

TEST_CASE_TEMPLATE("a circle around the slot is no progress", S, float, double, Q16) {
  Watch<S> w;
  CHECK(w.pass(100, [](double t) { return 12 + 4 * std::cos(t); }) > 50);
  CHECK(w.state.loss == StationLoss::kStuck);
}

TEST_CASE_TEMPLATE("a boat that spins for two seconds is out of formation, in its slot or not", S,
                   float, double, Q16) {
  for (const double off_m : {0.0, 100.0}) {
    for (const double r : {1.1, -1.1}) {
      Watch<S> w;
      w.stay(4, off_m);
      w.in.r = S(0.9);  // hardly beyond the limit
      CHECK(w.stay(10, off_m) == -1);
      w.in.r = of<S>(r);
      CHECK(w.stay(1.9, off_m) == -1);
      CHECK(w.stay(1, off_m) > 0);
      CHECK(w.state.loss == StationLoss::kSpins);
    }
  }
}

TEST_CASE_TEMPLATE("a boat that swings to and fro is out of formation", S, float, double, Q16) {
  Watch<S> w;
  w.stay(4, 0);
  for (int k = 0; k < 20 && w.state.loss == StationLoss::kNo; ++k) {
    w.in.r = k % 2 == 0 ? S(2) : S(-2);
    w.stay(0.6, 0);
    w.in.r = S(0);
    w.stay(0.4, 0);
  }
  CHECK(w.state.loss == StationLoss::kSpins);
}

TEST_CASE_TEMPLATE("beside a slot at rest, a boat that the law leaves alone counts as in its slot",
                   S, float, double, Q16) {
  Watch<S> w;
  CHECK(w.stay(5, 1.5) == -1);
  CHECK_FALSE(w.state.in);
  w.in.at_rest = true;
  CHECK(w.stay(200, 1.5) == -1);
  CHECK(w.state.in);
}

TEST_CASE_TEMPLATE("with a limit of 0 m no boat leaves its formation", S, float, double, Q16) {
  Watch<S> w;
  w.params.D = S(0);
  w.in.r = S(9);
  CHECK(w.stay(5, 0) == -1);
  CHECK(w.stay(200, 900) == -1);
}

}  // namespace
}  // namespace flotilla::core
