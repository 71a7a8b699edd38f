// SPDX-License-Identifier: MIT
// The product's default law behind leaders that rest, that are slow, and that are too fast.
#include "core/piloted_boat.hpp"
#include "core/track.hpp"

namespace flotilla::core {
namespace {

using testing::PilotedBoat;
using testing::Random;
using testing::Sighting;

constexpr double kH = 0.01;

struct Moments {
  double rms = 0, swing = 0;  ///< of the yaw moment, N m; of the bow, rad
};

/// Behind a leader at rest, of which it hears 20 times a second with σ 0.02 m/s and 0.0035 rad/s, a
/// boat lies `aside` from its slot.
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

TEST_CASE_TEMPLATE("the noise of a leader at rest is not worth a tenth of a newton metre", S, float,
                   double) {
  for (const double aside : {0.0, 0.3, 1.0}) {
    for (const std::uint32_t seed : {96U, 97U}) {
      INFO("seed ", seed, ", ", aside, " m aside");
      const Moments seen = beside_a_noisy_leader<S>(aside, seed);
      CAPTURE(seen.swing);
      CHECK(seen.rms < 0.1);
      CHECK(seen.rms > 1e-3);  // it is heard
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

TEST_CASE_TEMPLATE("a leader faster than LAW_U_MAX is followed, and caught up with", S, float,
                   double) {
  auto params = testing::products_law<S>();
  const auto leader = testing::voyage([](double) { return Tau<double>{7, 0.1}; }, kH, 120);
  CHECK(leader.back().nu.u > 1.9);
  REQUIRE(double(params.law.outer.u_max) == 1.5);
  for (const double behind : {0.0, 4.0, 12.0}) {
    PilotedBoat<S> boat;
    boat.hull.q = {-behind, 1, 0, 0, 0, 0};
    double off = 0;
    bool limited = false;
    for (const Sighting& seen : leader) {
      off = std::hypot(boat.hull.q[0] - seen.place.x, boat.hull.q[1] - seen.place.y);
      limited = boat.tick(params, seen, kH).wanted.u_limited;
    }
    INFO("from ", behind, " m behind, at the end ", off, " m");
    CHECK(off < 0.1);
    CHECK_FALSE(limited);
  }
}

}  // namespace
}  // namespace flotilla::core
