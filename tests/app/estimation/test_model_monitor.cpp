// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "app/estimation/model_monitor.hpp"
#include "core/unlike_hull.hpp"

namespace flotilla::app {
namespace {

using testing::helm;
using testing::UnlikeHull;
using Number = ModelMonitor::Number;

Parameters told() {
  Parameters p;
  p.VES_M11 = UnlikeHull::m11;
  p.VES_M22 = UnlikeHull::m22;
  p.VES_M33 = UnlikeHull::m33;
  p.VES_D11 = UnlikeHull::d11;
  p.VES_D22 = UnlikeHull::d22;
  p.VES_D33 = UnlikeHull::d33;
  p.THR_ARM = static_cast<float>(UnlikeHull::a);
  return p;
}

/// A boat whose commands go through the parameters that the monitor has applied.
struct Boat {
  UnlikeHull hull;
  Parameters p = told();
  ModelMonitor monitor{};
  core::Impulse<float> given{};
  std::int64_t now_us = 0;
  std::vector<ModelMonitor::Finding> findings{};
  float fastest = 0;  ///< greatest step of THR_BALANCE

  explicit Boat(const UnlikeHull& boats, int apply = 0) : hull(boats) {
    p.LEARN_APPLY = static_cast<float>(apply);
    monitor.configure(p, 0);
  }

  void sail(double minutes, double turns = 1.2) {
    const double balance = hull.balance;
    for (int i = 0; i < std::lround(6000 * minutes); ++i) {
      now_us += 10'000;
      const core::Tau<double> tau = helm(hull, turns, 0.8);
      // A propeller that is stronger in the model gets a smaller command.
      hull.balance = balance - double{monitor.applied(p).THR_BALANCE - p.THR_BALANCE};
      hull.step(tau);
      hull.balance = balance;
      const auto f = [](double x) { return static_cast<float>(x); };
      core::impulse_forward(given, {f(tau.X), f(tau.N)}, 0.01F);
      if (given.time < ModelMonitor::kSample_s) continue;
      const core::Nu<double> nu = hull.seen();
      const float before = monitor.applied(p).THR_BALANCE;
      if (monitor.take(std::exchange(given, {}), {f(nu.u), f(nu.v), f(nu.r)},
                       {f(std::sin(hull.psi)), f(std::cos(hull.psi))}, {}, now_us)) {
        monitor.configure(p, 0);
      }
      fastest = std::max(fastest, std::abs(monitor.applied(p).THR_BALANCE - before));
      while (const auto found = monitor.take_finding()) findings.push_back(*found);
    }
  }
};

TEST_CASE("a weak propeller is reported once, with the right THR_BALANCE and since when") {
  for (const double balance : {0.06, -0.06}) {
    Boat boat({.balance = balance, .wind_n = 1, .gust = 0.2, .noise = 0.01});
    boat.sail(10);
    REQUIRE(boat.findings.size() == 1);
    CHECK(boat.findings[0].number == Number::kBalance);
    CHECK(double{boat.findings[0].value} == doctest::Approx(balance).epsilon(0.25));
    CHECK(boat.findings[0].since_us < 120'000'000);
    CHECK(double{boat.monitor.told(Number::kBalance).value()} ==
          doctest::Approx(balance).epsilon(0.2));
    CHECK_FALSE(boat.monitor.told(Number::kDrag).has_value());
    CHECK(boat.monitor.applied(boat.p).THR_BALANCE == 0);
  }
}

TEST_CASE("wrong drag and yaw damping are reported as factors of their parameters") {
  Boat boat({.drag = 2, .yaw_damping = 0.5, .wind_e = 1, .gust = 0.2, .noise = 0.01});
  boat.sail(10);
  CHECK(double{boat.monitor.told(Number::kDrag).value()} == doctest::Approx(2).epsilon(0.05));
  CHECK(double{boat.monitor.told(Number::kYawDamping).value()} ==
        doctest::Approx(0.5).epsilon(0.1));
  CHECK_FALSE(boat.monitor.told(Number::kBalance).has_value());
}

TEST_CASE("a boat with correct parameters gets no report, whatever the wind") {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    CAPTURE(seed);
    Boat boat(
        {.wind_n = 2, .wind_e = -1, .wind_turns = 0.1, .gust = 0.5, .noise = 0.02, .seed = seed});
    boat.sail(10);
    CHECK(boat.findings.empty());
  }
}

TEST_CASE("a propeller that weakens under way is reported, and again when it gets worse") {
  Boat boat({.noise = 0.01});
  boat.sail(10);
  REQUIRE(boat.findings.empty());
  boat.hull.balance = 0.06;
  boat.sail(60);
  REQUIRE(boat.findings.size() >= 1);
  CHECK(boat.findings[0].since_us > 600'000'000);
  const std::size_t before = boat.findings.size();
  boat.hull.balance = 0.15;
  boat.sail(60);
  CHECK(boat.findings.size() > before);
  CHECK(double{boat.findings.back().value} > 0.08);
}

TEST_CASE("a correction is applied slowly and never too far; the parameter stays as set") {
  Boat boat({.balance = 0.06, .wind_n = 1, .gust = 0.2, .noise = 0.01}, 1);
  boat.sail(15);
  CHECK(double{boat.monitor.applied(boat.p).THR_BALANCE} == doctest::Approx(0.06).epsilon(0.2));
  CHECK(boat.fastest < 0.0041F);
  CHECK(boat.p.THR_BALANCE == 0);
  CHECK(boat.monitor.applied(boat.p).VES_D11 == boat.p.VES_D11);
  boat.p.LEARN_APPLY = 0;  // switched off: the parameter applies as it is set
  boat.monitor.configure(boat.p, 0);
  CHECK(boat.monitor.applied(boat.p).THR_BALANCE == 0);
}

TEST_CASE("drag is applied by LEARN_APPLY 2 alone, within 0.4 to 2.5 of the parameter") {
  for (const double drag : {0.5, 2.0, 4.0}) {
    Boat boat({.drag = drag, .noise = 0.01}, 2);
    boat.sail(30);
    const double factor = double{boat.monitor.applied(boat.p).VES_D11} / UnlikeHull::d11;
    CHECK(factor == doctest::Approx(std::min(drag, 2.5)).epsilon(0.05));
  }
}

TEST_CASE("a new hull parameter discards the learnt correction of the old one") {
  Boat boat({.balance = 0.06, .noise = 0.01}, 1);
  boat.sail(10);
  REQUIRE(boat.monitor.told(Number::kBalance).has_value());
  boat.p.THR_BALANCE = 0.06F;
  boat.monitor.configure(boat.p, 0);
  CHECK_FALSE(boat.monitor.told(Number::kBalance).has_value());
  CHECK(boat.monitor.applied(boat.p).THR_BALANCE == 0.06F);
  boat.p.LAW_KX = 0.3F;  // not a parameter of the hull
  boat.hull.balance = 0;
  boat.sail(0.5);
  CHECK(boat.findings.size() == 1);
}

}  // namespace
}  // namespace flotilla::app
