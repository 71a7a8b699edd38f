// SPDX-License-Identifier: MIT
#include "core/arbitrary.hpp"
#include "core/thrust_curve.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Random;

TEST_CASE_TEMPLATE("the command for a thrust gives that thrust, from linear to quadratic", S, float,
                   double) {
  for (int k = 0; k <= 20; ++k) {
    const ThrustCurveParams<S> curve{S(30), S(12), S(k) / S(20), S(0)};
    for (int i = -100; i <= 100; ++i) {
      const S c = S(i) / S(100);
      const S T = thrust_from_command(curve, c);
      CAPTURE(curve.epsilon);
      CHECK(command_from_thrust(curve, T) == approx(c));
      CHECK(thrust_from_command(curve, command_from_thrust(curve, T)) == approx(T, 30));
    }
  }
}

TEST_CASE_TEMPLATE(
    "full command gives each direction's maximum; half, on a quadratic curve, gives a quarter", S,
    float, double) {
  const ThrustCurveParams<S> curve{S(30), S(12), S(1), S(0)};
  CHECK(thrust_from_command(curve, S(1)) == approx(S(30)));
  CHECK(thrust_from_command(curve, S(-1)) == approx(S(-12)));
  CHECK(thrust_from_command(curve, S(0.5)) == approx(S(7.5)));
  CHECK(thrust_from_command(curve, S(0)) == S(0));
}

TEST_CASE_TEMPLATE("a greater thrust never takes a smaller command, and none goes beyond full", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 17;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const S F = S(random(0.1, 500)), R = S(random(0.1, 500));
    const ThrustCurveParams<S> curve{F, R, S(random(0, 1)), S(random(0, 0.2)) * F};
    const S a = S(random(-1.5, 1.5)) * F, b = S(random(-1.5, 1.5)) * F;
    const S c_a = command_from_thrust(curve, a), c_b = command_from_thrust(curve, b);
    REQUIRE(std::abs(c_a) <= S(1));
    CHECK((a <= b ? c_a <= c_b : c_a >= c_b));
    if (a >= F) CHECK(c_a == approx(S(1)));
    if (a <= -R && -a >= curve.dead) CHECK(c_a == approx(S(-1)));
  }
}

TEST_CASE_TEMPLATE(
    "a thrust within the dead band stops the propeller, the next greater one does not", S, float,
    double) {
  const ThrustCurveParams<S> curve{S(30), S(30), S(0.5), S(2)};
  CHECK(command_from_thrust(curve, S(1.99)) == S(0));
  CHECK(command_from_thrust(curve, S(-1.99)) == S(0));
  CHECK(command_from_thrust(curve, S(2)) > S(0));
  CHECK(command_from_thrust(curve, S(-2)) < S(0));
  CHECK(command_from_thrust(ThrustCurveParams<S>{S(30), S(30), S(1), S(0)}, S(0)) == S(0));
}

TEST_CASE_TEMPLATE("even the smallest thrust gives a valid command, not NaN", S, float, double) {
  for (int k = 0; k <= 4; ++k) {
    const ThrustCurveParams<S> curve{S(30), S(30), S(k) / S(4), S(0)};
    for (S T = S(1); T > S(0); T = S(0.5) * T) {
      const S c = command_from_thrust(curve, T);
      CAPTURE(T);
      CAPTURE(curve.epsilon);
      REQUIRE((c >= S(0) && c <= S(1)));  // false for NaN
    }
  }
}

TEST_CASE_TEMPLATE("a command moves no faster than the slew rate and arrives", S, float, double) {
  constexpr std::uint32_t kSeed = 18;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const S desired = S(random(-1, 1)), rate = S(random(0.5, 20));
    S command = S(random(-1, 1));
    for (int k = 0; k < 500; ++k) {
      const S next = limit_slew(command, desired, rate, S(0.01));
      REQUIRE(std::abs(next - command) <= rate * S(0.01) * S(1.001) + S(1e-6));
      REQUIRE(std::abs(desired - next) <= std::abs(desired - command));
      command = next;
    }
    CHECK(command == desired);
  }
}

TEST_CASE_TEMPLATE("a slew rate of 0 means no limit; no time means no change", S, float, double) {
  CHECK(limit_slew(S(-1), S(1), S(0), S(0.01)) == S(1));
  CHECK(limit_slew(S(-1), S(1), S(5), S(0)) == S(-1));
}

}  // namespace
}  // namespace flotilla::core
