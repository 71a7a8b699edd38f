// SPDX-License-Identifier: MIT
#include <algorithm>

#include "core/arbitrary.hpp"
#include "core/line_of_sight.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::later;
using testing::Random;

constexpr std::uint32_t kSeed = 81;

/// In still water without unknown forces; U is held at the given value.
template <class S>
LineOfSight<S> sight_of(S Delta, const ControllerInput<S>& in, const Slot<S>& slot, S U) {
  return line_of_sight(LineOfSightParams<S>{Delta}, in.nu, slot, formation_error(in, slot), U);
}

template <class S>
LineOfSight<S> sight_of(S Delta, const ControllerInput<S>& in, const Slot<S>& slot) {
  return sight_of(Delta, in, slot, slot.pace);
}

/// A slot with its leader's motion, at most 9 m away.
template <class S>
Slot<S> arbitrary_slot(const ControllerInput<S>& in, Random& random) {
  return slot_beside(in, Vec2<S>{S(random(-9, 9)), S(random(-9, 9))});
}

/// A boat behind its slot, which sails north at `speed`; the boat is `aside` to starboard of its
/// track.
ControllerInput<double> straight(double behind, double aside, double speed) {
  ControllerInput<double> in;
  in.separation_n = {-behind, aside};
  in.nu = in.nu_L = {speed, 0, 0};
  return in;
}

TEST_CASE_TEMPLATE("without a look-ahead there is no line-of-sight angle, exactly", S, float,
                   double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const auto in = testing::arbitrary_encounter<S>(random);
    const LineOfSight<S> sight = sight_of(S(0), in, arbitrary_slot(in, random));
    CHECK(sight.theta == S(0));
    CHECK(sight.theta_dot == S(0));
    CHECK(sight.theta_ddot == S(0));
  }
}

TEST_CASE_TEMPLATE("the line-of-sight angle is never more than one radian", S, float, double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    in.separation_n = {S(random(-1000, 1000)), S(random(-1000, 1000))};
    const S Delta = S(std::pow(10, random(-1, 2)));
    const LineOfSight<S> sight = sight_of(Delta, in, arbitrary_slot(in, random));
    REQUIRE(std::abs(sight.theta) <= S(1));
    REQUIRE(std::isfinite(sight.theta_dot + sight.theta_ddot));
  }
}

TEST_CASE_TEMPLATE("in the mirror image, the bow turns the other way", S, float, double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  const auto mirrored = [](const Nu<S>& nu) { return Nu<S>{nu.u, -nu.v, -nu.r}; };
  for (int i = 0; i < 1000; ++i) {
    ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    in.psi_L = S(0);
    ControllerInput<S> mirror = in;
    mirror.separation_n.y = -in.separation_n.y;
    mirror.psi = -in.psi;
    mirror.nu = mirrored(in.nu);
    mirror.nu_L = mirrored(in.nu_L);
    mirror.nu_L_dot = mirrored(in.nu_L_dot);
    const LineOfSight<S> sight = sight_of(S(1.5), in, slot_beside(in, {}));
    const LineOfSight<S> other = sight_of(S(1.5), mirror, slot_beside(mirror, {}));
    CHECK(other.theta == -sight.theta);
    CHECK(other.theta_dot == approx(-sight.theta_dot, 10));
    CHECK(other.theta_ddot == approx(-sight.theta_ddot, 10));
  }
}

TEST_CASE("a boat to starboard of its slot's track turns to port, and more if it is farther away") {
  double last = 0;
  for (const double aside : {0.1, 0.5, 2.0, 20.0}) {
    const auto in = straight(0, aside, 2);
    const double theta = sight_of(1.0, in, slot_beside(in, {})).theta;
    CHECK(theta < last);
    last = theta;
  }
  CHECK(last < -0.98);
}

TEST_CASE_TEMPLATE("line of sight uses the smaller of two speeds, or 0 if their signs differ", S,
                   float, double) {
  CHECK(smaller_of_same_sign(S(2), S(1)) == S(1));
  CHECK(smaller_of_same_sign(S(-2), S(-1)) == S(-1));
  CHECK(smaller_of_same_sign(S(2), S(-1)) == S(0));
  CHECK(smaller_of_same_sign(S(0), S(1)) == S(0));
}

TEST_CASE("the slower a boat makes way, the less it turns its bow; hardly at all below 0.05 m/s") {
  const auto in = straight(0, 1, 1);
  const Slot<double> slot = slot_beside(in, {});
  for (const double U : {-1.0, -0.2, -0.05, 0.05, 0.2, 1.0}) {
    const double sigma = sight_of(1.0, in, slot, U).theta / sight_of(1.0, in, slot, 1e6).theta;
    CHECK(sigma == doctest::Approx(U * std::abs(U) / (U * U + 0.0225)));
    if (std::abs(U) <= 0.05) CHECK(std::abs(sigma) <= 0.1001);
  }
}

TEST_CASE("from far behind the bow points at the slot") {
  for (const double aside : {-8.0, -3.0, 0.0, 3.0, 8.0}) {
    const auto in = straight(40, aside, 1);
    const double theta = sight_of(1.0, in, slot_beside(in, {})).theta;
    CHECK(std::abs(theta - std::atan2(-aside, 40)) < 0.01);
  }
}

TEST_CASE_TEMPLATE(
    "a slot at rest gives a line-of-sight angle of 0; one that goes astern reverses its sign", S,
    float, double) {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    in.nu_L_dot = {};
    in.nu_L = {};
    const LineOfSight<S> stands = sight_of(S(1), in, slot_beside(in, {}));
    CHECK(stands.theta == S(0));
    CHECK(stands.theta_dot == S(0));
    CHECK(stands.theta_ddot == S(0));
    in.nu_L.u = S(random(0.05, 2));
    const S ahead = sight_of(S(1), in, slot_beside(in, {})).theta;
    in.nu_L.u = -in.nu_L.u;
    const S astern = sight_of(S(1), in, slot_beside(in, {})).theta;
    CHECK(astern == -ahead);
    const auto e_c = formation_error(in, slot_beside(in, {})).e;
    const S beside = sin(e_c.psi) * e_c.x + cos(e_c.psi) * e_c.y;
    CHECK(ahead * beside <= S(0));
  }
}

TEST_CASE("the rate of the line-of-sight angle is its derivative while both vessels sail on") {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    ControllerInput<double> in = testing::arbitrary_encounter<double>(random);
    in.separation_n = {random(-9, 9), random(-9, 9)};
    const double Delta = random(0.5, 10);
    const double U = random(-2, 2);  // held: the rate leaves out that of σ
    const auto at = [&](double h) {
      const auto then = later(in, h);
      return sight_of(Delta, then, slot_beside(then, {}), U);
    };
    constexpr double h = 1e-4;
    const double slope = (at(h).theta - at(-h).theta) / (2 * h);
    CHECK(std::abs(slope - at(0).theta_dot) < 1e-5);
  }
}

TEST_CASE("on the track, the angle's second derivative depends on the boat's yaw rate alone") {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const double u = random(-2, 2), r = random(-1, 1), Delta = random(0.5, 10);
    ControllerInput<double> in = straight(0, 0, u);
    in.nu.r = r;
    const double sigma = u * std::abs(u) / (u * u + 0.15 * 0.15);
    CHECK(sight_of(Delta, in, slot_beside(in, {})).theta_ddot ==
          approx(-sigma * u * r / Delta, 10));
    const auto at = [&](double h) {
      const auto then = later(in, h);
      return sight_of(Delta, then, slot_beside(then, {}));
    };
    const double slope = (at(1e-4).theta_dot - at(-1e-4).theta_dot) / 2e-4;
    CHECK(slope == doctest::Approx(at(0).theta_ddot).epsilon(1e-3).scale(1e-3));
  }
}

TEST_CASE(
    "abreast of the slot, the angle's second derivative is the part due to the boat's own turn") {
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const double u = random(-1.5, 1.5), Delta = random(1, 5);
    ControllerInput<double> in = straight(0, random(-3, 3) * Delta, u);
    in.psi = random(-1, 1);
    const auto at = [&](double r, double h) {
      ControllerInput<double> turning = in;
      turning.nu.r = r;
      const auto then = later(turning, h);
      return sight_of(Delta, then, slot_beside(then, {}));
    };
    const auto slope = [&](double r) {
      return (at(r, 1e-4).theta_dot - at(r, -1e-4).theta_dot) / 2e-4;
    };
    const double r = random(-1, 1);
    CHECK(std::abs(slope(r) - slope(0) - at(r, 0).theta_ddot) < 1e-5);
  }
}

}  // namespace
}  // namespace flotilla::core
