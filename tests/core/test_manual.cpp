// SPDX-License-Identifier: MIT
#include <algorithm>

#include "core/arbitrary.hpp"
#include "core/manual.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Random;

/// One propeller gives 20 N ahead, 8 N astern.
template <class S>
AllocationParams<S> propellers() {
  return {S(0.25), S(20), S(8)};
}

template <class S>
Allocation<S> drive(double surge, double yaw) {
  return allocate(propellers<S>(), stick_wrench(propellers<S>(), S(surge), S(yaw)));
}

template <class S>
void check_thrusts(const Thrust<S>& thrust, double port, double stbd) {
  CHECK(thrust.port == approx(S(port), 20));
  CHECK(thrust.stbd == approx(S(stbd), 20));
}

TEST_CASE_TEMPLATE("sticks at rest: both propellers stand still", S, float, double) {
  const Thrust<S> thrust = drive<S>(0, 0).thrust;
  CHECK(thrust.port == S(0));
  CHECK(thrust.stbd == S(0));
}

TEST_CASE_TEMPLATE("stick full ahead or astern: full thrust of both propellers in that direction",
                   S, float, double) {
  check_thrusts(drive<S>(1, 0).thrust, 20, 20);
  check_thrusts(drive<S>(-1, 0).thrust, -8, -8);
  check_thrusts(drive<S>(0.5, 0).thrust, 10, 10);
  check_thrusts(drive<S>(-0.5, 0).thrust, -4, -4);
}

TEST_CASE_TEMPLATE("stick hard over: port ahead and starboard astern turn her to starboard", S,
                   float, double) {
  check_thrusts(drive<S>(0, 1).thrust, 20, -8);
  check_thrusts(drive<S>(0, -1).thrust, -8, 20);
  check_thrusts(drive<S>(0, 0.5).thrust, 7, -7);
}

TEST_CASE_TEMPLATE("both sticks full: yaw gets all it asks for, surge the rest", S, float, double) {
  check_thrusts(drive<S>(1, 1).thrust, 20, -8);
  check_thrusts(drive<S>(1, 0.5).thrust, 20, 6);
  check_thrusts(drive<S>(-1, 0.5).thrust, 6, -8);
}

TEST_CASE_TEMPLATE(
    "no stick alone asks for more than can be given, and more stick never gives less", S, float,
    double) {
  constexpr std::uint32_t kSeed = 31;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const AllocationParams<S> p{S(random(0.05, 5)), S(random(0.1, 500)), S(random(0.1, 500))};
    const double less = random(-10, 10), more = less + random(0, 5);
    CAPTURE(less);
    CAPTURE(more);
    for (const double stick : {less, more}) {
      const Allocation<S> surge = allocate(p, stick_wrench(p, S(stick), S(0)));
      const Allocation<S> yaw = allocate(p, stick_wrench(p, S(0), S(stick)));
      CHECK(surge.missing.X == approx(S(0), 1000));
      CHECK(surge.given.N == approx(S(0), 5000));
      CHECK(yaw.missing.N == approx(S(0), 5000));
    }
    CHECK(stick_wrench(p, S(less), S(0)).X <= stick_wrench(p, S(more), S(0)).X);
    CHECK(stick_wrench(p, S(0), S(less)).N <= stick_wrench(p, S(0), S(more)).N);
  }
}

TEST_CASE_TEMPLATE("a stick beyond its end counts as a stick at its end", S, float, double) {
  for (const double beyond : {1.001, 2.0, 10.0, 1e30}) {
    CAPTURE(beyond);
    for (const double sign : {-1.0, 1.0}) {
      const Tau<S> end = stick_wrench(propellers<S>(), S(sign), S(-sign));
      const Tau<S> tau = stick_wrench(propellers<S>(), S(sign * beyond), S(-sign * beyond));
      CHECK(tau.X == end.X);
      CHECK(tau.N == end.N);
    }
  }
}

TEST_CASE_TEMPLATE("a motor test turns the one propeller that was named, by the share asked", S,
                   float, double) {
  check_thrusts(test_thrust(propellers<S>(), Propeller::kPort, S(0.1)), 2, 0);
  check_thrusts(test_thrust(propellers<S>(), Propeller::kStbd, S(0.1)), 0, 2);
  check_thrusts(test_thrust(propellers<S>(), Propeller::kPort, S(-0.1)), -0.8, 0);
  check_thrusts(test_thrust(propellers<S>(), Propeller::kStbd, S(-0.1)), 0, -0.8);
  check_thrusts(test_thrust(propellers<S>(), Propeller::kPort, S(0)), 0, 0);
}

TEST_CASE_TEMPLATE("a motor test never gives more than a fifth of a propeller, whatever is asked",
                   S, float, double) {
  for (const double share : {0.2, 0.21, 1.0, 10.0, 1e30}) {
    CAPTURE(share);
    check_thrusts(test_thrust(propellers<S>(), Propeller::kPort, S(share)), 4, 0);
    check_thrusts(test_thrust(propellers<S>(), Propeller::kStbd, S(-share)), 0, -1.6);
  }
}

}  // namespace
}  // namespace flotilla::core
