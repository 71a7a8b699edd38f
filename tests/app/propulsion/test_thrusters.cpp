// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <utility>

#include "app/propulsion/thrusters.hpp"

namespace flotilla::app {
namespace {

template <class S>
Thrusters<S> thrusters_of(const Parameters& p) {
  return {configuration_of(p).propulsion, convert::law_of<S>(p)};
}

Parameters without_slew() {
  Parameters p;
  p.THR_SLEW = 0;
  return p;
}

TEST_CASE_TEMPLATE("full thrust is 8191 in each propeller's own slot, the others hold zeros", S,
                   float, double) {
  Parameters p = without_slew();
  p.ESC_PORT = 3;
  p.ESC_STBD = 1;
  auto thrusters = thrusters_of<S>(p);
  const auto out = thrusters.step(true, core::Thrust<S>{S(20), S(-20)}, S(0.01));
  REQUIRE(out.raw.count == 4);
  CHECK(out.raw.cmd[3] == 8191);
  CHECK(out.raw.cmd[1] == -8191);
  CHECK(out.raw.cmd[0] == 0);
  CHECK(out.raw.cmd[2] == 0);
  CHECK(double(out.given.X) == doctest::Approx(0));
  CHECK(double(out.given.N) == doctest::Approx(0.25 * 40));
}

TEST_CASE_TEMPLATE("a weak port propeller is commanded more, a strong starboard one less", S, float,
                   double) {
  Parameters p = without_slew();
  p.THR_EXPO = 0.3F;
  p.THR_BALANCE = 0.1F;
  const core::Thrust<S> asked{S(9), S(9)};
  const auto out = thrusters_of<S>(p).step(true, asked, S(0.01));
  CHECK(double(out.thrust.port) == doctest::Approx(9).epsilon(1e-3));
  CHECK(double(out.thrust.stbd) == doctest::Approx(9).epsilon(1e-3));
  CHECK(std::abs(double(out.given.N)) < 0.01);
  // Alone, a propeller of 18 N gets the port command, and one of 22 N the starboard one.
  p.THR_BALANCE = 0;
  for (const auto& [maximum, side] :
       {std::pair{18.0F, std::size_t{0}}, std::pair{22.0F, std::size_t{1}}}) {
    p.THR_FWD_MAX = maximum;
    const auto alone = thrusters_of<S>(p).step(true, asked, S(0.01));
    CHECK(std::abs(alone.raw.cmd[0] - out.raw.cmd[side]) <= 1);
  }
}

TEST_CASE("the law asks both propellers for no more thrust than the weaker one can give") {
  for (const float balance : {-0.2F, 0.2F}) {
    Parameters p;
    p.THR_BALANCE = balance;
    const auto law = convert::law_of<double>(p);
    CHECK(law.controller.propellers.F == doctest::Approx(16));
    CHECK(law.controller.propellers.R == doctest::Approx(16));
    CHECK((balance > 0 ? law.port_curve : law.stbd_curve).F == doctest::Approx(16));
    CHECK((balance > 0 ? law.stbd_curve : law.port_curve).F == doctest::Approx(24));
  }
}

TEST_CASE_TEMPLATE("a propeller that turns the other way gets the other sign and gives the same", S,
                   float, double) {
  Parameters p = without_slew();
  const auto straight = thrusters_of<S>(p).step(true, core::Thrust<S>{S(7), S(3)}, S(0.01));
  p.THR_STBD_DIR = -1;
  const auto reversed = thrusters_of<S>(p).step(true, core::Thrust<S>{S(7), S(3)}, S(0.01));
  CHECK(reversed.raw.cmd[0] == straight.raw.cmd[0]);
  CHECK(reversed.raw.cmd[1] == -straight.raw.cmd[1]);
  CHECK(reversed.thrust.stbd == straight.thrust.stbd);
}

TEST_CASE_TEMPLATE(
    "starting is limited by the slew rate, stopping is not; the next start is from zero", S, float,
    double) {
  Parameters p;
  p.THR_SLEW = 5;
  auto thrusters = thrusters_of<S>(p);
  const core::Thrust<S> full{S(20), S(20)};
  typename Thrusters<S>::Output out;
  for (int k = 1; k <= 20; ++k) {
    out = thrusters.step(true, full, S(0.01));
    CHECK(std::abs(out.raw.cmd[0] - k * 0.05 * 8191) <= 1);
    if (k < 20) CHECK(out.slew_limited);
  }
  out = thrusters.step(true, full, S(0.01));
  CHECK(out.raw.cmd[0] == 8191);
  CHECK_FALSE(out.slew_limited);
  out = thrusters.step(false, full, S(0.01));
  CHECK(out.raw.count == 2);
  CHECK(out.raw.cmd[0] == 0);
  CHECK(out.raw.cmd[1] == 0);
  CHECK(out.given.X == S(0));
  CHECK(std::abs(thrusters.step(true, full, S(0.01)).raw.cmd[0] - 0.05 * 8191) <= 1);
}

TEST_CASE_TEMPLATE("the thrust reported is the thrust of the commands as sent", S, float, double) {
  constexpr std::uint32_t kSeed = 62;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> thrust(-25, 25), part(0, 1);
  for (int i = 0; i < 500; ++i) {
    Parameters p = without_slew();
    p.THR_EXPO = static_cast<float>(part(random));
    p.THR_REV_MAX = 12;
    const core::Thrust<S> desired{S(thrust(random)), S(thrust(random))};
    const auto out = thrusters_of<S>(p).step(true, desired, S(0.01));
    CHECK(std::abs(double(out.thrust.port) - std::clamp(double(desired.port), -12.0, 20.0)) < 0.01);
    CHECK(std::abs(double(out.thrust.stbd) - std::clamp(double(desired.stbd), -12.0, 20.0)) < 0.01);
    CHECK(double(out.given.X) == doctest::Approx(double(out.thrust.port + out.thrust.stbd)));
    CHECK(std::abs(out.raw.cmd[0]) <= 8191);
  }
}

TEST_CASE_TEMPLATE(
    "a wrench that fades out gives finite commands down to zero, even on a quadratic curve", S,
    float, double) {
  Parameters p = without_slew();
  p.THR_EXPO = 1;
  auto thrusters = thrusters_of<S>(p);
  for (S T = S(1); T > S(0); T = S(0.25) * T) {
    const S c = core::command_from_thrust(convert::law_of<S>(p).port_curve, T);
    REQUIRE(std::isfinite(c));  // the cast of NaN to an integer would be undefined
    CHECK(thrusters.step(true, core::Thrust<S>{T, T}, S(0.01)).raw.cmd[0] >= 0);
  }
}

TEST_CASE_TEMPLATE(
    "while thrust may not rise, neither the greatest thrust nor the greatest command rises", S,
    float, double) {
  constexpr std::uint32_t kSeed = 73;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> thrust(-25, 25);
  Parameters p;
  p.THR_REV_MAX = 12;  // the same thrust is a greater command astern
  auto thrusters = thrusters_of<S>(p);
  const auto step = [&](bool may_rise) {
    const core::Thrust<S> desired{S(thrust(random)), S(thrust(random))};
    const auto out = thrusters.step(true, desired, S(0.01), may_rise);
    return std::pair(std::max(std::abs(out.raw.cmd[0]), std::abs(out.raw.cmd[1])),
                     core::max(core::abs(out.thrust.port), core::abs(out.thrust.stbd)));
  };
  for (int run = 0; run < 20; ++run) {
    auto greatest = step(true);
    for (int k = 0; k < 50; ++k) greatest = step(true);
    for (int k = 0; k < 200; ++k) {
      const auto next = step(false);
      REQUIRE(next.first <= greatest.first);
      // A thrust becomes a command of 1/8191 of full scale, the nearest one.
      REQUIRE(next.second <= greatest.second + S(0.5 * 20 / 8191));
      greatest.first = next.first;
      greatest.second = core::min(greatest.second, next.second);
    }
  }
  thrusters.step(false, {}, S(0.01));
  CHECK(step(false).first == 0);  // from rest there is nothing to keep
}

}  // namespace
}  // namespace flotilla::app
