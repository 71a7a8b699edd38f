// SPDX-License-Identifier: MIT
// The product's default law behind leaders that rest, that are slow, and that are too fast.
#include <algorithm>

#include "core/estimation/track.hpp"
#include "core/piloted_boat.hpp"

namespace flotilla::core {
namespace {

using testing::PilotedBoat;
using testing::Random;
using testing::Sighting;

constexpr double kH = 0.01;

struct Moments {
  double rms = 0, swing = 0;  ///< of the yaw moment, N m; of the bow, rad
};

/// A boat lies `aside` from its slot behind a leader at rest, whose state arrives 20 times a second
/// with σ 0.02 m/s and 0.0035 rad/s.
template <class S>
Moments beside_a_noisy_leader(double aside, std::uint32_t seed) {
  Random random(seed);
  const auto noise = [&](double sigma) {
    return std::normal_distribution<double>(0, sigma)(random.engine);
  };
  auto params = testing::products_law<S>();
  params.law.slot.d = {S(-2), S(0)};
  TrackState<double> track;
  PilotedBoat<S> boat;
  boat.hull.q = {-2, aside, 0, 0, 0, 0};
  Moments out;
  int n = 0;
  for (int k = 0; k < 6000; ++k) {
    if (k % 5 == 0) {
      const Nu<double> nu{noise(0.02), noise(0.02), noise(0.0035)};
      track_update({}, track, {0, nu, k == 0 ? 0 : 0.05});
    }
    const Motion<double> seen = track_forward(track, kH * (k % 5));
    const auto step = boat.tick(params, {seen.moved_n, seen.psi, seen.nu, seen.nu_dot}, kH);
    if (k < 500) continue;
    const double N = testing::number_of(step.allocation.given.N);
    out.rms += N * N, ++n;
    out.swing = std::max(out.swing, std::abs(boat.hull.q[2]));
  }
  out.rms = std::sqrt(out.rms / n);
  return out;
}

TEST_CASE_TEMPLATE("the noise of a leader at rest causes less than a tenth of a newton metre", S,
                   float, double) {
  for (const double aside : {0.0, 0.3, 1.0}) {
    for (const std::uint32_t seed : {96U, 97U}) {
      INFO("seed ", seed, ", ", aside, " m aside");
      const Moments seen = beside_a_noisy_leader<S>(aside, seed);
      CAPTURE(seen.swing);
      CHECK(seen.rms < 0.1);
      CHECK(seen.rms > 1e-3);  // the noise has an effect
      CHECK(seen.swing < 0.03);
    }
  }
}

TEST_CASE_TEMPLATE("a boat far ahead of a slow leader goes no farther abeam to wait for it", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 98;
  INFO("seed ", kSeed);
  Random random(kSeed);
  const auto params = testing::products_law<S>();
  const auto leader = testing::voyage([](double) { return Tau<double>{0.2 * 3.436, 0}; }, kH, 120);
  for (int run = 0; run < 8; ++run) {
    PilotedBoat<S> boat;
    const double abeam = random(-5, 5);
    boat.hull.q = {random(15, 20), abeam, random(-0.1, 0.1), random(0, 0.5), 0, 0};
    double farthest = 0;
    for (const Sighting& seen : leader) {
      boat.tick(params, seen, kH);
      farthest = std::max(farthest, std::abs(boat.hull.q[1]));
    }
    INFO("abeam ", abeam, " m at first, ", farthest, " m at most");
    CHECK(farthest < std::abs(abeam) + 0.5);
    CHECK(std::hypot(boat.hull.q[0] - leader.back().place.x, boat.hull.q[1]) < 0.05);
  }
}

TEST_CASE_TEMPLATE("a leader faster than LAW_U_MAX is followed at LAW_U_MAX, and this is reported",
                   S, float, double) {
  auto params = testing::products_law<S>();
  const auto leader = testing::voyage([](double) { return Tau<double>{7, 0.1}; }, kH, 120);
  CHECK(leader.back().nu.u > 1.9);
  REQUIRE(double(params.law.outer.u_max) == 1.5);
  for (const double behind : {0.0, 4.0, 12.0}) {
    PilotedBoat<S> boat;
    boat.hull.q = {-behind, 1, 0, 0, 0, 0};
    double off = 0;
    ControllerOutput<S> out;
    for (const Sighting& seen : leader) {
      off = std::hypot(boat.hull.q[0] - seen.place.x, boat.hull.q[1] - seen.place.y);
      out = boat.tick(params, seen, kH);
      REQUIRE(double(out.desired.nu_star.u) <= 1.5);
    }
    INFO("from ", behind, " m behind, at the end ", off, " m");
    CHECK(off < 7);  // on its circle of 11 m it never falls behind
    CHECK(double(out.too_fast.u) == doctest::Approx(leader.back().nu.u).epsilon(0.01));
    CHECK(double(out.too_fast.r) == 0);
  }
}

TEST_CASE_TEMPLATE("a slot 10 m astern of a leader that pivots asks for no more than the limits", S,
                   float, double) {
  auto params = testing::products_law<S>();
  params.law.slot.d = {S(-10), S(0)};
  params.law.slot.turns = true;
  const auto leader = testing::voyage([](double) { return Tau<double>{0.2, 0.7}; }, kH, 60);
  PilotedBoat<S> boat;
  boat.hull.q = {-10, 0, 0, 0, 0, 0};
  double needs = 0, off = 0;
  for (const Sighting& seen : leader) {
    const auto out = boat.tick(params, seen, kH);
    REQUIRE(std::abs(double(out.desired.nu_star.u)) <= 1.5);
    REQUIRE(std::abs(double(out.desired.nu_star.r)) <= double(S(0.8)));
    needs = std::max(needs, double(out.too_fast.u));
    off = std::max(off, std::hypot(boat.hull.q[3], boat.hull.q[4]));
  }
  CHECK(needs > 7.5);
  CHECK(off < 1.6);  // the boat's true speed, m/s
}

TEST_CASE_TEMPLATE("in no situation does a boat ask for more than its limits", S, float, double) {
  constexpr std::uint32_t kSeed = 99;
  INFO("seed ", kSeed);
  Random random(kSeed);
  int yields = 0, approaches = 0, runs = 0;
  for (int run = 0; run < 2000; ++run) {
    auto params = testing::products_law<S>().law;
    params.slot.turns = run % 2 == 0;
    params.slot.d = {S(random(-10, 10)), S(random(-10, 10))};
    params.separation.least = S(2);
    params.outer.u_max = S(random(0.2, 3));
    params.outer.r_max = S(random(0.1, 2));
    auto state = controller_start(testing::arbitrary_encounter<S>(random));
    for (int k = 0; k < 5; ++k) {
      auto in = testing::arbitrary_encounter<S>(random);
      if (run % 3 == 0) in.nu_L = {};
      in.current_n = {S(random(-0.5, 0.5)), S(random(-0.5, 0.5))};
      Traffic<S> traffic;
      traffic.vessels[0] = {
          {S(random(-6, 6)), S(random(-6, 6))}, {S(random(-1, 1)), S(0)}, S(0), true};
      traffic.count = 1;
      const auto out = controller_step(params, state, in, S(0.01), &traffic);
      const auto& nu = out.desired.nu_star;
      REQUIRE(std::abs(nu.u) <= params.outer.u_max);
      REQUIRE(std::abs(nu.r) <= params.outer.r_max);
      yields += out.separation.yielding;
      approaches += state.approach.on;
      runs += out.too_fast.u > S(0) && state.approach.on;
    }
  }
  CHECK(std::min({yields, approaches, runs}) > 500);
}

/// A boat off the track of a leader at 0.4 m/s, with a force from astern; its distance from the
/// track at the end.
template <class S>
double off_before_the_wind(double push_N, double aside) {
  const auto params = testing::products_law<S>();
  const auto leader = testing::voyage([](double) { return Tau<double>{0.4 * 3.436, 0}; }, kH, 120);
  PilotedBoat<S> boat;
  boat.hull.q = {0, aside, 0, 0.4, 0, 0};
  boat.push = {push_N, 0};
  for (const Sighting& seen : leader) boat.tick(params, seen, kH);
  return std::hypot(boat.hull.q[0] - leader.back().place.x, boat.hull.q[1]);
}

TEST_CASE_TEMPLATE("a force from astern, even stronger than the drag, keeps no boat from its track",
                   S, float, double) {
  for (const double share : {0.0, 0.9, 1.0, 1.4, 3.0}) {
    INFO("push over drag ", share);
    CHECK(off_before_the_wind<S>(share * 0.4 * 3.436, 2) < 0.05);
  }
}

}  // namespace
}  // namespace flotilla::core
