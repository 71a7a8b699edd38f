// SPDX-License-Identifier: MIT
// The course of a slot that moves in the shape, against its path.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "app/guidance/moving_slot.hpp"

namespace flotilla::app {
namespace {

constexpr double kU = 0.6, kR = 0.05;  // of the leader, which turns

/// Motion of slot and leader over time; the slot accelerates in the shape.
struct Path {
  bool turns = false;
  core::Vec2<double> d{-6, 4}, w{0.3, -0.9}, w_dot{0.05, -0.1};
  core::Vec2<double> w_soon = w;

  core::Vec2<double> slot(double t) const {
    return {d.x + w.x * t + w_dot.x * t * t / 2, d.y + w.y * t + w_dot.y * t * t / 2};
  }
  core::Vec2<double> place(double t) const {
    const double psi = 1 + kR * t;
    const core::Vec2<double> d_n = turns ? core::to_north_east(psi, slot(t)) : slot(t);
    return {kU / kR * (std::sin(psi) - std::sin(1)) + d_n.x,
            kU / kR * (std::cos(1) - std::cos(psi)) + d_n.y};
  }
  core::Vec2<double> velocity(double t) const {
    constexpr double h = 1e-4;
    const auto a = place(t - h), b = place(t + h);
    return {(b.x - a.x) / (2 * h), (b.y - a.y) / (2 * h)};
  }
  Lead<double> lead() const {
    Lead<double> out;
    out.motion.psi = 1;
    out.motion.nu = {kU, 0, kR};
    out.slot.turns = turns;
    (turns ? out.slot.d : out.offset_n) = d;
    return on_own_course(out, w, w_dot, w_soon);
  }
};

TEST_CASE("a slot that moves in any direction has the course, speed and yaw rate of its path") {
  constexpr double h = 1e-3;
  for (const bool turns : {false, true}) {
    for (double way = 0; way < 2 * std::numbers::pi; way += 0.3) {
      Path path{.turns = turns};
      path.w = path.w_soon = {1.3 * std::cos(way), 1.3 * std::sin(way)};
      const auto v = path.velocity(0), before = path.velocity(-h), after = path.velocity(h);
      const double course = std::atan2(v.y, v.x);
      const Lead<double> lead = path.lead();
      CHECK(std::abs(core::wrap_pi(lead.motion.psi - course)) < 1e-6);
      CHECK(lead.motion.nu.u == doctest::Approx(std::hypot(v.x, v.y)));
      CHECK(lead.motion.nu.v == 0);
      const double turned = std::atan2(after.y, after.x) - std::atan2(before.y, before.x);
      CHECK(lead.motion.nu.r == doctest::Approx(core::wrap_pi(turned) / (2 * h)).epsilon(1e-3));
      const double faster = std::hypot(after.x, after.y) - std::hypot(before.x, before.y);
      CHECK(lead.motion.nu_dot.u == doctest::Approx(faster / (2 * h)).epsilon(1e-3));
      CHECK_FALSE(lead.slot.turns);
      CHECK(lead.slot.moves);
      const auto d_n = path.place(0);
      CHECK(lead.offset_n.x == doctest::Approx(d_n.x));
      CHECK(lead.offset_n.y == doctest::Approx(d_n.y));
    }
  }
}

TEST_CASE("a slot at rest over ground makes no boat turn on the spot") {
  Path path;
  path.w = path.w_soon = core::to_north_east(1.0, core::Vec2<double>{-kU + 0.001, 0.0});
  const Lead<double> lead = path.lead();
  CHECK(std::isfinite(lead.motion.nu.r));
  CHECK(std::abs(lead.motion.nu.r) < 1);
}

TEST_CASE("a boat turns about before its slot does, whether the slot turns astern or ahead") {
  for (const bool turns : {false, true}) {
    for (const double sign : {1.0, -1.0}) {
      Path path{.turns = turns, .d = {}};
      const auto along = [&](double over_ground) {
        const core::Vec2<double> w{over_ground - kU, 0.0};
        return turns ? w : core::to_north_east(1.0, w);
      };
      path.w = along(0.2 * sign);
      path.w_soon = along(-0.3 * sign);
      const Lead<double> lead = path.lead();
      CHECK(std::abs(core::wrap_pi(lead.motion.psi - (sign > 0 ? 1 + std::numbers::pi : 1))) <
            1e-6);
      CHECK(lead.motion.nu.u == doctest::Approx(0.3));
      CHECK(lead.motion.nu.r == 0);
    }
  }
}

TEST_CASE("behind a slot that moves a boat turns and closes up twice as fast") {
  core::VirtualVelocityParams<double> gains{0.2, 0.5, 1.5, 0.8};
  core::LineOfSightParams<double> sight{2};
  hasten(gains, sight);
  CHECK((gains.k_x == 0.4 && gains.k_psi == 1 && sight.Delta == 1));
  CHECK((gains.u_max == 1.5 && gains.r_max == 0.8));
}

}  // namespace
}  // namespace flotilla::app
