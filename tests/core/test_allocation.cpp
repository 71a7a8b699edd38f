// SPDX-License-Identifier: MIT
#include <algorithm>

#include "core/allocation.hpp"
#include "core/arbitrary.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Random;

template <class S>
AllocationParams<S> arbitrary_propellers(Random& random) {
  return {S(random(0.05, 5)), S(random(0.1, 500)), S(random(0.1, 500))};
}

TEST_CASE_TEMPLATE("more port than starboard thrust turns the boat to starboard", S, float,
                   double) {
  const Allocation<S> out =
      allocate(AllocationParams<S>{S(0.25), S(20), S(20)}, Tau<S>{S(4), S(1)});
  CHECK(out.thrust.port == approx(S(4)));
  CHECK(out.thrust.stbd == approx(S(0)));
}

TEST_CASE_TEMPLATE("a feasible wrench is given exactly and nothing is missing", S, float, double) {
  constexpr std::uint32_t kSeed = 14;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const auto p = arbitrary_propellers<S>(random);
    const auto draw = [&] { return S(random(-0.99 * double(p.R), 0.99 * double(p.F))); };
    const Thrust<S> desired{draw(), draw()};
    const Allocation<S> out = allocate(p, wrench_of(p, desired));
    CHECK(out.thrust.port == approx(desired.port, 500));
    CHECK(out.thrust.stbd == approx(desired.stbd, 500));
    CHECK(out.missing.X == approx(S(0), 500));
    CHECK(out.missing.N == approx(S(0), 2500));
    CHECK(out.limits == 0);
  }
}

TEST_CASE_TEMPLATE(
    "for any wrench no propeller exceeds its limit, and given plus missing is the request", S,
    float, double) {
  constexpr std::uint32_t kSeed = 15;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const auto p = arbitrary_propellers<S>(random);
    const double size = std::pow(10, random(-2, 4));
    const Tau<S> tau{S(random(-size, size)), S(random(-size, size))};
    const Allocation<S> out = allocate(p, tau);
    CAPTURE(tau.X);
    CAPTURE(tau.N);
    for (const S T : {out.thrust.port, out.thrust.stbd}) {
      REQUIRE(T <= p.F);
      REQUIRE(T >= -p.R);
    }
    CHECK(out.given.X + out.missing.X == approx(tau.X, 1000));
    CHECK(out.given.N + out.missing.N == approx(tau.N, 5000));
    const Tau<S> given = wrench_of(p, out.thrust);
    CHECK(out.given.X == given.X);
    CHECK(out.given.N == given.N);
  }
}

TEST_CASE_TEMPLATE(
    "yaw has priority: surge gets all that yaw leaves, and acting limits are reported", S, float,
    double) {
  constexpr std::uint32_t kSeed = 16;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    const auto p = arbitrary_propellers<S>(random);
    const double N_max = double(p.a) * (double(p.F) + double(p.R));
    const double N = random(-2, 2) * N_max;
    const bool yaw_fits = std::abs(N) <= N_max;
    const double D = std::min(std::abs(N), N_max) / (2 * double(p.a));
    const double X_most = 2 * (double(p.F) - D), X_least = 2 * (D - double(p.R));
    const double X = random(-1, 1) * 3 * (double(p.F) + double(p.R));
    const double X_given = std::clamp(X, X_least, std::max(X_least, X_most));
    const Allocation<S> out = allocate(p, Tau<S>{S(X), S(N)});
    CHECK(out.given.N == approx(S(std::copysign(std::min(std::abs(N), N_max), N)), 5000));
    CHECK(out.given.X == approx(S(X_given), 1000));
    CHECK((out.limits & kYawLimit) == (yaw_fits ? 0 : kYawLimit));
    CHECK((out.limits & kSurgeLimit) == (X < X_least || X > X_most ? kSurgeLimit : 0));
  }
}

TEST_CASE_TEMPLATE(
    "braking in a turn gives the surge requested, down to half astern, and the rest to yaw", S,
    float, double) {
  constexpr std::uint32_t kSeed = 17;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 2000; ++i) {
    auto p = arbitrary_propellers<S>(random);
    p.brakes = true;
    const double F = double(p.F), R = double(p.R), all = 2 * (F + R);
    const Tau<S> tau{S(random(-1, 1) * all), S(random(-1, 1) * double(p.a) * all)};
    const Allocation<S> out = allocate(p, tau);
    // A turn never drives a boat ahead with more surge than commanded, nor uses more than half of
    // the reverse thrust.
    CHECK(double(out.given.X) <= std::max(double(tau.X), -R) + 1e-3);
    const double D_least = std::min(std::abs(double(tau.N)) / (2 * double(p.a)), R / 2);
    CHECK(std::abs(double(out.given.N)) >= 2 * double(p.a) * D_least - 1e-2);
    CHECK(out.given.X + out.missing.X == approx(tau.X, 1000));
    CHECK(out.given.N + out.missing.N == approx(tau.N, 5000));
    CHECK((out.missing.N == approx(S(0), 5000)) == ((out.limits & kYawLimit) == 0));
  }
}

TEST_CASE_TEMPLATE("a zero wrench gives zero thrust", S, float, double) {
  const Allocation<S> out = allocate(AllocationParams<S>{S(0.25), S(30), S(10)}, Tau<S>{});
  CHECK(out.thrust.port == S(0));
  CHECK(out.thrust.stbd == S(0));
  CHECK(out.limits == 0);
}

}  // namespace
}  // namespace flotilla::core
