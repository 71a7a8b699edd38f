// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "app/navigation/liveness.hpp"

namespace flotilla::app {
namespace {

/// A vessel that reports its place at 10 Hz by an instrument that can stick.
template <class S>
struct Watch {
  Liveness<S> liveness{S(0.3)};
  convert::Sample<S> sample{};
  int said = 0;

  /// Seconds until it is found frozen, or −1.
  double sail(double seconds, bool stuck = false, double pushed_mps2 = 0) {
    double frozen_s = -1;
    for (int k = 0; k < seconds * 10; ++k, ++said) {
      if (!stuck) {
        sample.north_m = sample.north_m + 0.1 * double(sample.u_mps);
        sample.psi_rad += S(0.1) * sample.r_radps;
      }
      liveness.push(S(0.1 * pushed_mps2));
      liveness.take(sample, said > 0 ? S(0.1) : S(0));
      if (!liveness.live() && frozen_s < 0) frozen_s = 0.1 * (k + 1);
    }
    return frozen_s;
  }
};

TEST_CASE_TEMPLATE(
    "a moving or turning vessel whose state stops changing is frozen within half a second", S,
    float, double) {
  for (const auto& [u, r] : {std::pair{1.0, 0.0}, {0.6, 0.3}, {-0.5, 0.0}}) {
    Watch<S> w;
    w.sample.u_mps = S(u), w.sample.r_radps = S(r);
    CHECK(w.sail(10) == -1);
    const double after_s = w.sail(5, true);
    CHECK(after_s >= 0.3);
    CHECK(after_s <= 0.5);
  }
}

TEST_CASE_TEMPLATE("a vessel that reports being at rest is not frozen, however long", S, float,
                   double) {
  Watch<S> w;
  CHECK(w.sail(1000) == -1);
  w.sample.u_mps = 1;
  CHECK(w.sail(10) == -1);
  w.sample.u_mps = 0;
  CHECK(w.sail(1000) == -1);
}

TEST_CASE_TEMPLATE("a position or a heading alone that stops changing is frozen too", S, float,
                   double) {
  for (const bool place : {true, false}) {
    Watch<S> w;
    w.sample.u_mps = S(0.5), w.sample.r_radps = S(0.2);
    REQUIRE(w.sail(5) == -1);
    bool live = true;
    for (int k = 0; k < 30; ++k) {
      w.sample.psi_rad += place ? S(0.02) : S(0);
      if (!place) w.sample.north_m = w.sample.north_m + 0.02;
      w.liveness.take(w.sample, S(0.1));
      live = w.liveness.live();
    }
    CHECK_FALSE(live);
  }
}

TEST_CASE_TEMPLATE(
    "a position that changes only in every third message comes from a slow instrument", S, float,
    double) {
  Watch<S> w;
  w.sample.u_mps = 1;
  for (int k = 0; k < 200; ++k) {
    REQUIRE(w.sail(0.1) == -1);
    REQUIRE(w.sail(0.2, true) == -1);
    w.sample.north_m = w.sample.north_m + 0.2;
  }
}

TEST_CASE_TEMPLATE("a state that is the same to the last bit while the propellers push is frozen",
                   S, float, double) {
  Watch<S> w;
  w.sample.u_mps = 1;
  REQUIRE(w.sail(3) == -1);
  w.sample.u_mps = 0;
  REQUIRE(w.sail(30) == -1);
  const double after_s = w.sail(5, true, 1.0);
  CHECK(after_s >= 0.2);
  CHECK(after_s <= 0.5);
  CHECK(w.sail(2, true) > 0);
  // While the propellers rest, nobody can know whether it still sticks. It is judged again when
  // they push.
  w.sail(20, true);
  CHECK(w.liveness.live());
  CHECK(w.sail(5, true, 1.0) > 0);
}

TEST_CASE_TEMPLATE("two equal states under thrust at a place that stays are chance, not a fault", S,
                   float, double) {
  Watch<S> w;
  w.sample.u_mps = 1;
  REQUIRE(w.sail(3) == -1);
  for (int k = 0; k < 50;
       ++k) {  // coarse degrees, and by a quay: only the velocity's noise goes on
    w.sample.u_mps = S(0.001 * (k / 2 % 2));
    REQUIRE(w.sail(0.1, true, 10) == -1);
  }
}

TEST_CASE_TEMPLATE("a frozen vessel is live again some states after it moves", S, float, double) {
  Watch<S> w;
  w.sample.u_mps = 1;
  w.sail(5);
  REQUIRE(w.sail(5, true) > 0);
  int states = 0;
  for (; !w.liveness.live(); ++states) w.sail(0.1);
  CHECK(states >= 2);
  CHECK(states <= 5);
}

TEST_CASE_TEMPLATE("a hull held from the beginning is frozen only after some seconds", S, float,
                   double) {
  Watch<S> w;
  w.sample.u_mps = 5;
  CHECK(w.sail(4.5, true) == -1);
  CHECK(w.sail(5, true) > 0);
  Watch<S> pushed;
  CHECK(pushed.sail(20, true) == -1);
  CHECK(pushed.sail(60, true, 10) == doctest::Approx(8.2).epsilon(0.1));
  CHECK_FALSE(pushed.liveness.moved());
}

/// A boat that sails at a speed and turns at a rate, and its noisy unit.
struct Noisy {
  double speed_mps = 0, turn_radps = 0, period_s = 0.1;
  double place_m = 0, drift_m = 0, drift_s = 60, velocity_mps = 0;  ///< noise, drift of the place
  double dropped = 0;                                               ///< share of the states
  bool frozen = false;  ///< the place, but for its noise
  std::mt19937 random{5};
  Liveness<double> liveness{0.3};
  core::Vec2<double> place{}, drift{};
  double psi = 0;

  double normal() { return std::normal_distribution<double>()(random); }

  /// Seconds until it is found frozen, or −1.
  double sail(double seconds) {
    double since_s = 0;
    const double kept = std::exp(-period_s / drift_s);
    const double fresh_m = drift_m * std::sqrt(1 - kept * kept);
    for (double t = 0; t < seconds; t += period_s) {
      psi = core::wrap_pi(psi + period_s * turn_radps);
      if (!frozen) place.x += period_s * speed_mps * std::cos(psi);
      if (!frozen) place.y += period_s * speed_mps * std::sin(psi);
      drift = {kept * drift.x + fresh_m * normal(), kept * drift.y + fresh_m * normal()};
      since_s += period_s;
      if (since_s < 1 && std::uniform_real_distribution()(random) < dropped) continue;
      convert::Sample<double> seen{};
      seen.north_m = place.x + drift.x + place_m * normal();
      seen.east_m = place.y + drift.y + place_m * normal();
      seen.psi_rad = psi + 0.001 * normal();
      seen.u_mps = speed_mps + velocity_mps * normal();
      seen.v_mps = velocity_mps * normal();
      seen.r_radps = turn_radps;
      liveness.push(0.1 * since_s);
      liveness.take(seen, since_s);
      since_s = 0;
      if (!liveness.live()) return t;
    }
    return -1;
  }
};

TEST_CASE("a place that is frozen but for noise is found within ten seconds of sailing") {
  for (const double noise_m : {1e-6, 0.005, 0.02}) {
    for (const double speed_mps : {0.25, 0.5, 1.0, 2.0, -0.4}) {
      for (const double period_s : {0.05, 0.1, 0.2, 0.5}) {
        CAPTURE(noise_m);
        CAPTURE(speed_mps);
        CAPTURE(period_s);
        Noisy boat{.speed_mps = speed_mps, .period_s = period_s, .place_m = noise_m};
        CHECK(boat.sail(10) == -1);
        boat.frozen = true;
        const double after_s = boat.sail(20);
        CHECK(after_s > 1);
        CHECK(after_s < 10);
      }
    }
  }
}

TEST_CASE("a noisy boat that is held from the beginning gets five seconds") {
  Noisy boat{.speed_mps = 0.58, .period_s = 0.05, .place_m = 0.01, .frozen = true};
  CHECK(boat.sail(20) == doctest::Approx(5).epsilon(0.05));
}

TEST_CASE("after it was frozen, a place counts as live only once it has changed") {
  Noisy boat{.speed_mps = 0.5, .place_m = 0.001};
  boat.sail(10);
  boat.frozen = true;
  REQUIRE(boat.sail(10) > 0);
  boat.speed_mps = 0;
  boat.sail(100);
  for (int k = 0; k < 100; ++k) REQUIRE(boat.sail(1) == 0);
  boat.place.x += 3;
  for (int k = 0; k < 3; ++k) boat.sail(0.1);
  CHECK(boat.sail(100) == -1);
}

TEST_CASE("a boat that moves, rests or is held is not frozen, whatever its unit's errors") {
  for (const double speed_mps : {0.0, 0.05, 0.25, 0.6, 1.5}) {
    for (const double turn_radps : {0.0, 0.1, 0.5, 3.0}) {
      for (const double period_s : {0.05, 0.1, 0.2, 0.5}) {
        for (const auto& [place_m, drift_m, drift_s] :
             {std::array{1e-4, 0.0, 60.0}, std::array{0.02, 0.03, 60.0},
              std::array{0.02, 0.03, 5.0}, std::array{1e-4, 0.5, 60.0},
              std::array{0.1, 0.5, 10.0}}) {
          CAPTURE(speed_mps);
          CAPTURE(turn_radps);
          CAPTURE(period_s);
          CAPTURE(drift_m);
          CAPTURE(drift_s);
          Noisy boat{.speed_mps = speed_mps,
                     .turn_radps = turn_radps,
                     .period_s = period_s,
                     .place_m = place_m,
                     .drift_m = drift_m,
                     .drift_s = drift_s,
                     .velocity_mps = 0.05,
                     .dropped = 0.5};
          CHECK(boat.sail(600) == -1);
        }
      }
    }
  }
}

}  // namespace
}  // namespace flotilla::app
