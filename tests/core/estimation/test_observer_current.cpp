// SPDX-License-Identifier: MIT
// The estimate of the current from the boat's fixes.
#include "core/watched_boat.hpp"

namespace flotilla::core {
namespace {

using testing::Random;
using testing::Watched;

Tau<double> straight_ahead(double) { return {2, 0}; }

TEST_CASE_TEMPLATE("on a straight leg the boat finds the current across it, on a curve all of it",
                   S, float, double) {
  constexpr std::uint32_t kSeed = 43;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (const double speed : {0.1, 0.3}) {
    for (int run = 0; run < 4; ++run) {
      Watched<S> straight, turning;
      straight.hull.q[2] = random.angle();
      straight.hull.current = to_north_east(random.angle(), Vec2<double>{speed, 0});
      turning.hull = straight.hull;
      straight.sail_until(60, straight_ahead);
      turning.sail_until(100, testing::s_curve);
      const auto off = [](const Watched<S>& boat) {
        return Vec2<double>{double(boat.state.c_n.x) - boat.hull.current.x,
                            double(boat.state.c_n.y) - boat.hull.current.y};
      };
      CHECK(std::abs(to_body(straight.hull.q[2], off(straight)).y) < 0.01);
      CHECK(std::hypot(off(turning).x, off(turning).y) < 0.01);
    }
  }
}

TEST_CASE_TEMPLATE("the slower the current estimate, the later the current is found", S, float,
                   double) {
  for (const double omega_c : {0.05, 0.1, 0.2}) {
    Watched<S> boat;
    boat.params.omega_c = S(omega_c);
    boat.hull.q[2] = 0;
    boat.hull.current = {0, 0.2};
    double delay = 0;
    while (boat.t < 15 / omega_c) {
      boat.sail(straight_ahead(boat.t), straight_ahead(boat.t));
      delay += boat.spacing * (1 - double(boat.state.c_n.y) / 0.2);
    }
    CHECK(delay * omega_c == doctest::Approx(1).epsilon(0.15));
  }
}

TEST_CASE_TEMPLATE("a boat that assumes still water finds no current", S, float, double) {
  Watched<S> boat;
  boat.params.omega_c = S(0);
  boat.hull.current = {0.3, -0.2};
  while (boat.t < 30) {
    boat.sail(testing::s_curve(boat.t), testing::s_curve(boat.t));
    REQUIRE(boat.state.c_n.x == S(0));
    REQUIRE(boat.state.c_n.y == S(0));
  }
  CHECK(std::abs(boat.unknown().X) > 0.1);  // the boat takes the current for a force
}

}  // namespace
}  // namespace flotilla::core
