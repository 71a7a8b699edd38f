// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "core/estimation/plausibility.hpp"

namespace flotilla::core {
namespace {

/// 1 m, 0.8 rad, 2 m/s, 1.5 rad/s; 10 m/s² up to 10 m/s, 10 rad/s² up to 4 rad/s.
template <class S>
PlausibilityLimits<S> any_vessel() {
  return {S(1), S(0.8), S(2), S(1.5), S(10), S(10), S(10), S(4)};
}

/// A vessel that sails north at 2 m/s, a tenth of a second later.
template <class S>
Leg<S> sails() {
  return {{S(0.2), S(0)}, S(0), S(0), {S(2), S(0), S(0)}, {S(2), S(0), S(0)}, S(0.1)};
}

template <class S>
bool jumps(const Leg<S>& leg, double scatter = 0) {
  return S(1) < innovation_of(any_vessel<S>(), leg, S(scatter)).share;
}

TEST_CASE_TEMPLATE("a vessel that moves as its velocity says is no jump", S, float, double) {
  const auto innovation = innovation_of(any_vessel<S>(), sails<S>(), S(0));
  CHECK(double(innovation.off) < 1e-6);
  CHECK(double(innovation.share) < 1e-6);
}

TEST_CASE_TEMPLATE("a place, a heading, a velocity or a yaw rate too far off is a jump", S, float,
                   double) {
  auto place = sails<S>(), heading = sails<S>(), speed = sails<S>(), turn = sails<S>();
  place.moved_n.y = S(0.9), heading.psi_to = S(0.7), speed.to.u = S(4.5), turn.to.r = S(2);
  CHECK_FALSE(jumps(place));
  CHECK_FALSE(jumps(speed));
  CHECK_FALSE(jumps(turn));
  heading.to = {S(2 * std::cos(0.7)), S(-2 * std::sin(0.7)), S(0)};
  CHECK_FALSE(jumps(heading));
  place.moved_n.y = S(1.2), heading.psi_to = S(1.5), speed.to.u = S(5.5), turn.to.r = S(8);
  CHECK(jumps(place));
  CHECK(jumps(heading));
  CHECK(jumps(speed));
  CHECK(jumps(turn));
}

TEST_CASE_TEMPLATE("a vessel that runs aground stops at once, and that is no jump", S, float,
                   double) {
  auto leg = sails<S>();
  leg.from = {S(12), S(0), S(6)};
  leg.to = {};
  leg.moved_n.x = S(0.3);
  CHECK_FALSE(jumps(leg));
  leg.from.r = S(0);
  leg.to.u = S(-12);
  CHECK(jumps(leg));
}

TEST_CASE_TEMPLATE("the longer the silence, the farther away a vessel may be", S, float, double) {
  auto leg = sails<S>();
  leg.moved_n.x = S(12);
  CHECK(jumps(leg));
  leg.h = S(2);  // 4 m by its velocity, 10 m by what it can do
  CHECK_FALSE(jumps(leg));
  leg.moved_n.x = S(1e6);
  CHECK(jumps(leg));
}

TEST_CASE_TEMPLATE("where positions commonly scatter, a position may differ more", S, float,
                   double) {
  auto leg = sails<S>();
  leg.moved_n.x = S(3);
  CHECK(jumps(leg));
  CHECK_FALSE(jumps(leg, 0.3));
}

TEST_CASE_TEMPLATE("a heading that passes south is no jump", S, float, double) {
  auto leg = sails<S>();
  leg.psi_from = S(3.1), leg.psi_to = S(-3.1);
  leg.moved_n.x = S(-0.2);
  CHECK_FALSE(jumps(leg));
}

TEST_CASE_TEMPLATE("a small move is never a jump, whatever else the message says", S, float,
                   double) {
  std::mt19937 engine(5);
  int hardly = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto any = [&](double most) {
      return S(std::uniform_real_distribution<double>(-most, most)(engine));
    };
    Leg<S> leg{{any(0.6), any(0.6)}, any(3), S(0), {any(6), any(6), any(9)}, {}, any(5)};
    leg.h = abs(leg.h);
    leg.psi_to = leg.psi_from + any(0.12);
    leg.to = {leg.from.u + any(0.6), leg.from.v + any(0.6), leg.from.r + any(1.6)};
    if (!hardly_moves(small_move(any_vessel<S>()), leg)) continue;
    ++hardly;
    REQUIRE_FALSE(jumps(leg));
  }
  CHECK(hardly > 1000);
}

}  // namespace
}  // namespace flotilla::core
