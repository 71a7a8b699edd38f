// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/arbitrary.hpp"
#include "core/route.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::core {
namespace {

using testing::in_scalar;
using testing::number_of;
using testing::Random;

template <class S>
std::vector<Waypoint<S>> waypoints(const std::vector<Waypoint<double>>& points) {
  std::vector<Waypoint<S>> out;
  for (const auto& p : points) {
    out.push_back({{in_scalar<S>(p.place.x), in_scalar<S>(p.place.y)},
                   in_scalar<S>(p.speed),
                   in_scalar<S>(p.reach),
                   in_scalar<S>(p.wait)});
  }
  return out;
}

template <class S>
RouteParams<S> params_of(const RouteParams<double>& p) {
  return {in_scalar<S>(p.accel), in_scalar<S>(p.yaw_rate), in_scalar<S>(p.yaw_accel),
          in_scalar<S>(p.radius), in_scalar<S>(p.half_width)};
}

struct Seen {
  double t, north, east, psi, u, r, u_dot, r_dot;
  RoutePhase phase;
  std::size_t next;
};

template <class S>
std::vector<Seen> sail(const RouteParams<double>& limits,
                       const std::vector<Waypoint<double>>& route, double most_s, double h = 0.01) {
  const auto points = waypoints<S>(route);
  const auto params = params_of<S>(limits);
  auto state = route_start<S>(params, points);
  std::vector<Seen> out;
  for (int k = 0; k * h < most_s; ++k) {
    const auto& m = state.motion;
    out.push_back({k * h, number_of(m.moved_n.x), number_of(m.moved_n.y), number_of(m.psi),
                   number_of(m.nu.u), number_of(m.nu.r), number_of(m.nu_dot.u),
                   number_of(m.nu_dot.r), state.phase, state.next});
    if (state.phase == RoutePhase::kArrived) break;
    route_forward<S>(params, points, state, S(1), in_scalar<S>(h));
  }
  return out;
}

double distance(const Vec2<double>& a, double north, double east) {
  return std::hypot(north - a.x, east - a.y);
}

TEST_CASE_TEMPLATE("a corner ends on the next leg with its course", S, float, double, Q16) {
  constexpr std::uint32_t kSeed = 7;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 300; ++i) {
    const double turn = random(-2.8, 2.8), theta_0 = random(0.05, 1.0), R = random(0.5, 30);
    const auto shape = corner_shape(in_scalar<S>(turn), in_scalar<S>(theta_0));
    const auto corner = corner_of(shape, in_scalar<S>(turn), in_scalar<S>(R));
    // Integrated by small steps of the tested curvature, in double.
    const double length = number_of(corner.length);
    double psi = 0, x = 0, y = 0;
    constexpr int kSteps = 4000;
    for (int k = 0; k < kSteps; ++k) {
      const double ds = length / kSteps;
      const double kappa = number_of(curvature(corner, in_scalar<S>((k + 0.5) * ds)));
      x += ds * std::cos(psi + 0.5 * ds * kappa);
      y += ds * std::sin(psi + 0.5 * ds * kappa);
      psi += ds * kappa;
    }
    const double T = number_of(corner.tangent);
    const double fine = std::is_same_v<S, double> ? 1e-5 : 3e-3;  // of R
    CHECK(psi == doctest::Approx(turn).epsilon(0.002));
    CHECK(std::hypot(x - T * (1 + std::cos(turn)), y - T * std::sin(turn)) < fine * R + 1e-3);
    CHECK(number_of(turned(corner, corner.length)) == doctest::Approx(turn).epsilon(0.001));
  }
}

// A CHECK for each of many thousand moments would take longer than the checked code.
#define CHECK_EACH(condition)           \
  do {                                  \
    if (!(condition)) CHECK(condition); \
  } while (false)

TEST_CASE_TEMPLATE("a square is sailed within its limits and passes each waypoint within its reach",
                   S, float, double, Q16) {
  const RouteParams<double> limits{.accel = 0.1, .yaw_rate = 0.35, .yaw_accel = 0.15, .radius = 2};
  const std::vector<Waypoint<double>> route{
      {{0, 0}}, {{40, 0}, 0.5, 1.5}, {{40, 30}, 0.7, 1.5}, {{0, 30}, 0.5, 0.5}, {{0, 0}, 0.5, 1}};
  const auto seen = sail<S>(limits, route, 1000);
  REQUIRE(seen.back().phase == RoutePhase::kArrived);
  for (const Seen& s : seen) {
    CHECK_EACH(s.u <= 0.7001);
    CHECK_EACH(s.u >= 0);
    CHECK_EACH(std::abs(s.r) <= 0.36);
    CHECK_EACH(std::abs(s.u_dot) <= 0.21);
    CHECK_EACH(std::abs(s.r_dot) <= 0.2);
  }
  for (std::size_t i = 1; i < route.size(); ++i) {
    double nearest = 1e9;
    for (const Seen& s : seen)
      nearest = std::min(nearest, distance(route[i].place, s.north, s.east));
    CHECK(nearest <= route[i].reach + 0.002);
  }
  // The vessel sails the whole way: the last place is the last waypoint.
  CHECK(distance(route.back().place, seen.back().north, seen.back().east) < 0.002);
  // The place does not jump: no step is longer than the speed allows.
  for (std::size_t k = 1; k < seen.size(); ++k) {
    CHECK_EACH(std::hypot(seen[k].north - seen[k - 1].north, seen[k].east - seen[k - 1].east) <
               0.0075);
  }
  // It keeps its speed where that is allowed.
  CHECK(seen.back().t < 1.12 * (40 / 0.5 + 30 / 0.7 + 40 / 0.5 + 30 / 0.5));
}

TEST_CASE("a vessel stops where it waits, and turns on the spot") {
  const RouteParams<double> limits;
  const std::vector<Waypoint<double>> route{
      {{0, 0}}, {{10, 0}, 0.5, 1, 5}, {{10, 10}, 0.5, 1}, {{10, -10}, 0.5, 1}};
  const auto seen = sail<double>(limits, route, 500);
  REQUIRE(seen.back().phase == RoutePhase::kArrived);
  double waited = 0, turned_back = 0;
  for (const Seen& s : seen) {
    if (s.phase == RoutePhase::kWait && s.next == 1) waited += 0.01;
    if (s.phase == RoutePhase::kTurn) {
      CHECK(s.u == 0);
      CHECK(std::abs(s.r) <= limits.yaw_rate + 1e-9);
      if (s.next == 2) turned_back += 0.01 * s.r;
    }
    CHECK(std::abs(s.u_dot) <= 2.1 * limits.accel);
    CHECK(std::abs(s.r_dot) <= 2.1 * limits.yaw_accel);
  }
  CHECK(waited == doctest::Approx(5).epsilon(0.01));
  CHECK(std::abs(turned_back) == doctest::Approx(3.1416).epsilon(0.01));
}

TEST_CASE_TEMPLATE("random routes are sailed to their end within the limits", S, float, double,
                   Q16) {
  constexpr std::uint32_t kSeed = 23;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 40; ++i) {
    std::vector<Waypoint<double>> route{{{random(-500, 500), random(-500, 500)}}};
    const int count = 2 + static_cast<int>(random(0, 12));
    for (int k = 0; k < count; ++k) {
      const double along = random.angle(), length = random(0.2, 15);
      const Vec2<double>& last = route.back().place;
      route.push_back({{last.x + length * std::cos(along), last.y + length * std::sin(along)},
                       random(0.2, 1.5),
                       random(0.1, 3),
                       random(0, 1) < 0.1 ? 2.0 : 0.0});
    }
    const RouteParams<double> limits{random(0.05, 0.3), random(0.1, 0.6), random(0.05, 0.5),
                                     random(0, 3), random(0, 5)};
    const auto seen = sail<S>(limits, route, 4000, 0.02);
    INFO("route ", i);
    REQUIRE(seen.back().phase == RoutePhase::kArrived);
    for (std::size_t k = 1; k < seen.size(); ++k) {
      const Seen &a = seen[k - 1], &b = seen[k];
      // A step of Q16's speed is 0.001 m/s² here, and its roots of small numbers are coarse.
      CHECK_EACH(std::abs(b.u_dot) <= 2.1 * limits.accel + (std::is_same_v<S, Q16> ? 0.05 : 0));
      CHECK_EACH(std::abs(b.r) <= 1.05 * limits.yaw_rate + 0.002);
      CHECK_EACH(std::hypot(b.north - a.north, b.east - a.east) <= 0.02 * 1.5 + 0.003);
    }
    for (std::size_t k = 1; k < route.size(); ++k) {
      double nearest = 1e9;
      for (const Seen& s : seen)
        nearest = std::min(nearest, distance(route[k].place, s.north, s.east));
      CHECK(nearest <= route[k].reach + 0.02);
    }
  }
}

TEST_CASE("legs of any length end at rest, also where a step ends exactly on the waypoint") {
  const Q16 lsb = Q16::of_raw(1), far = Q16(3);
  (void)take_overflow<Q16>();
  for (Q16 length = far; length < far + Q16(500) * lsb; length = length + lsb) {
    std::vector<Waypoint<Q16>> points(2);
    points[1] = {{length, Q16{}}, Q16(1) / Q16(2), Q16(2), Q16{}};
    const RouteParams<Q16> params;
    auto state = route_start<Q16>(params, points);
    for (int k = 0; k < 2000 && state.phase != RoutePhase::kArrived; ++k) {
      route_forward<Q16>(params, points, state, Q16(1), in_scalar<Q16>(0.01));
    }
    REQUIRE(state.phase == RoutePhase::kArrived);
    REQUIRE(state.motion.moved_n.x.raw() == length.raw());
    REQUIRE_FALSE(take_overflow<Q16>());
  }
}

TEST_CASE("at pace 0 the vessel stops, at pace 1 it sails on") {
  const RouteParams<double> params;
  const std::vector<Waypoint<double>> route{{{0, 0}}, {{20, 0}, 0.5, 1}};
  auto state = route_start<double>(params, route);
  for (int k = 0; k < 2000; ++k) route_forward<double>(params, route, state, 0.0, 0.01);
  CHECK(state.motion.moved_n.x == 0);
  for (int k = 0; k < 1000; ++k) route_forward<double>(params, route, state, 1.0, 0.01);
  CHECK(state.motion.nu.u == doctest::Approx(0.5));
  for (int k = 0; k < 1000; ++k) route_forward<double>(params, route, state, 0.0, 0.01);
  CHECK(state.motion.nu.u == 0);
}

TEST_CASE_TEMPLATE("at pace 0 no wait runs out and the vessel does not turn", S, float, double,
                   Q16) {
  const RouteParams<S> params;
  const auto route = waypoints<S>({{{0, 0}}, {{2, 0}, 0.5, 1, 5}, {{0, 0}, 0.5}});
  const auto sail = [&](RouteState<S>& state, S pace, int seconds) {
    for (int k = 0; k < 10 * seconds; ++k) {
      route_forward<S>(params, route, state, pace, in_scalar<S>(0.1));
    }
  };
  auto state = route_start<S>(params, route);
  while (state.phase != RoutePhase::kWait) sail(state, S(1), 1);
  const S left = state.left;
  sail(state, S(0), 20);
  CHECK(state.phase == RoutePhase::kWait);
  CHECK(state.left == left);
  while (state.phase != RoutePhase::kTurn) sail(state, S(1), 1);
  sail(state, S(1), 1);
  sail(state, S(0), 5);
  CHECK(state.motion.nu.r == S(0));
  const S psi = state.motion.psi;
  sail(state, S(0), 20);
  CHECK(state.phase == RoutePhase::kTurn);
  CHECK(state.motion.psi == psi);
  sail(state, S(1), 30);
  CHECK(state.phase == RoutePhase::kArrived);
}

}  // namespace
}  // namespace flotilla::core
