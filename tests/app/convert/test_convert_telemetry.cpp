// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <random>

#include "app/convert/convert_telemetry.hpp"

namespace flotilla::app::convert {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::array kOdd{0.0F,   -0.0F,  NAN,      -NAN,   INFINITY, -INFINITY, 1e38F, -1e38F,
                          1e10F,  -1e10F, 65.4999F, 65.5F,  65.536F,  1e-40F,    -1.0F, 12.6F,
                          149.9F, 150.0F, -149.9F,  327.0F, 327.68F,  600.15F,   300.0F};

float any_float(std::mt19937& random) {
  const auto bits = static_cast<std::uint32_t>(random());
  float x = 0;
  std::memcpy(&x, &bits, sizeof x);
  return random() % 2 == 0 ? x : kOdd[random() % kOdd.size()];
}

std::optional<link::EscStatus> esc(float voltage, float current) {
  link::EscStatus status;
  status.voltage = voltage;
  status.current = current;
  return status;
}

TEST_CASE("the battery message has the lower of two voltages and the sum of both currents") {
  const auto battery = battery_of(esc(12.6F, 3), esc(12.4F, 4.5F));
  CHECK(battery.voltages[0] == 12'400);
  CHECK(battery.current_battery == 750);
  const auto one = battery_of(std::nullopt, esc(11.1F, 2));
  CHECK(one.voltages[0] == 11'100);
  CHECK(one.current_battery == -1);  // the current of one ESC alone would mislead
  const auto none = battery_of(std::nullopt, std::nullopt);
  CHECK(none.voltages[0] == UINT16_MAX);
  CHECK(none.current_battery == -1);
}

TEST_CASE(
    "impossible battery values are unknown: NaN, infinity, negative volts, a negative current") {
  for (const float volts : {NAN, INFINITY, -INFINITY, -0.1F, 66.0F, 1e38F}) {
    CHECK(battery_of(esc(volts, 1), std::nullopt).voltages[0] == UINT16_MAX);
    CHECK(battery_of(esc(volts, 1), esc(12, 1)).voltages[0] == 12'000);
  }
  for (const float amperes : {NAN, INFINITY, -INFINITY, 1e38F, -1e38F, -1.0F}) {
    CHECK(battery_of(esc(12, amperes), std::nullopt).current_battery == -1);
  }
  // Rounding never gives the number that means unknown, nor a negative number.
  constexpr std::uint32_t kSeed = 3;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int k = 0; k < 200'000; ++k) {
    const float v0 = any_float(random), v1 = any_float(random);
    const float a0 = any_float(random), a1 = any_float(random);
    const auto out = battery_of(esc(v0, a0), esc(v1, a1));
    const auto volts_known = [](float v) { return v >= 0 && v < 65.5F; };
    REQUIRE((out.voltages[0] == UINT16_MAX) == !(volts_known(v0) || volts_known(v1)));
    if (out.voltages[0] != UINT16_MAX) REQUIRE(out.voltages[0] <= 65'500);
    REQUIRE(out.current_battery >= -1);
    REQUIRE(out.current_battery <= 30'000);
  }
}

TEST_CASE("a temperature is sent to a hundredth of a degree, or as unknown") {
  CHECK(centidegrees_of_kelvin(273.15F) == 0);
  CHECK(centidegrees_of_kelvin(300) == 2685);
  CHECK(centidegrees_of_kelvin(253.15F) == -2000);
  for (const float kelvin : {NAN, INFINITY, -INFINITY, 1e38F, -1e38F, 601.0F, -100.0F}) {
    CHECK(centidegrees_of_kelvin(kelvin) == INT16_MAX);
  }
  constexpr std::uint32_t kSeed = 13;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int k = 0; k < 200'000; ++k) {
    const float kelvin = any_float(random);
    const std::int16_t out = centidegrees_of_kelvin(kelvin);
    if (out == INT16_MAX) continue;
    REQUIRE(std::abs(out / 100.0 - (double{kelvin} - 273.15)) <= 0.00501);
  }
  for (float kelvin = 0; kelvin < 600; kelvin += 0.37F) {
    REQUIRE(centidegrees_of_kelvin(kelvin) != INT16_MAX);
  }
}

TEST_CASE("a stick is −1 to 1; any other number, including 32767, is ignored") {
  for (int axis = INT16_MIN; axis <= INT16_MAX; ++axis) {
    const auto stick = stick_of(static_cast<std::int16_t>(axis));
    REQUIRE(stick.has_value() == (axis >= -1000 && axis <= 1000));
    if (stick) REQUIRE(*stick == doctest::Approx(axis * 1e-3));
  }
}

/// A boat, its slot, and the law's error between them, all chosen.
struct Scene {
  double boat_n, boat_e, psi, slot_n, slot_e, slot_psi;

  OwnState state() const {
    // The boat has covered part of the displacement since its last position.
    return own_state_of<double>({boat_n - 1.5, boat_e + 0.5}, {{1.5, -0.5}, psi, {}, {}});
  }
  core::Error<double> error() const {
    const double n = boat_n - slot_n, e = boat_e - slot_e;
    return {std::cos(psi) * n + std::sin(psi) * e, -std::sin(psi) * n + std::cos(psi) * e,
            psi - slot_psi};
  }
};

double turn_between(double a, double b) { return std::remainder(a - b, 2 * kPi); }

TEST_CASE("thrust below THR_DEAD is dead, as a share of the greatest thrust in its own direction") {
  Configuration::Propulsion p;
  p.ahead_N = 50;
  p.astern_N = 20;
  p.dead_N = 5;
  CHECK(is_dead(0, p));
  CHECK(is_dead(0.0999, p));
  CHECK_FALSE(is_dead(0.1, p));
  CHECK_FALSE(is_dead(1, p));
  CHECK(is_dead(-0.2499, p));
  CHECK_FALSE(is_dead(-0.25, p));
  p.dead_N = 0;
  CHECK_FALSE(is_dead(0, p));  // without a dead band there is nothing to report
}

TEST_CASE("bearing, distance and target point from the boat to its slot, whatever the heading") {
  constexpr std::uint32_t kSeed = 17;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> metres(-2000, 2000), turn(-20, 20);
  for (int k = 0; k < 5000; ++k) {
    const Scene s{metres(random), metres(random), turn(random),
                  metres(random), metres(random), turn(random)};
    const auto nav = nav_controller_output_of(s.state(), s.error());
    const double n = s.slot_n - s.boat_n, e = s.slot_e - s.boat_e, far = std::hypot(n, e);
    REQUIRE(std::abs(nav.target_bearing) <= 180);
    REQUIRE(std::abs(nav.nav_bearing) <= 180);
    REQUIRE(std::abs(turn_between(nav.target_bearing * kPi / 180, std::atan2(e, n))) < 0.0088);
    REQUIRE(std::abs(turn_between(nav.nav_bearing * kPi / 180, s.slot_psi)) < 0.0088);
    REQUIRE(std::abs(nav.wp_dist - far) <= 0.501);
    REQUIRE(std::abs(double{nav.xtrack_error} - s.error().y) <= 1e-3);
    const auto slot = slot_of(s.state(), s.error(), 77);
    REQUIRE(slot.time_boot_ms == 77);
    REQUIRE(slot.coordinate_frame == 1);
    REQUIRE(slot.type_mask == 0b1001'1111'1000);
    REQUIRE(std::abs(double{slot.x} - s.slot_n) < 1e-3);
    REQUIRE(std::abs(double{slot.y} - s.slot_e) < 1e-3);
    REQUIRE(slot.z == 0);
    REQUIRE(std::abs(turn_between(double{slot.yaw}, s.slot_psi)) < 1e-5);
    REQUIRE(std::abs(double{slot.yaw}) <= kPi + 1e-6);
  }
}

TEST_CASE("a distance to the slot beyond the message's range saturates; it does not wrap") {
  for (const double far : {65'534.0, 65'536.0, 1e6, 1e12, 1e200}) {
    const Scene s{0, 0, 0, far, 0, 0};
    CHECK(nav_controller_output_of(s.state(), s.error()).wp_dist ==
          (far < 65'535 ? 65'534 : 65'535));
  }
}

TEST_CASE("ODOMETRY is the same state: NED pose, heading as a quaternion, body velocity") {
  for (double psi = -30; psi < 30; psi += 0.1) {
    const auto own = own_state_of<double>({3, -4}, {{0.5, 0.25}, psi, {1.5, -0.2, 0.1}, {}});
    const link::Odometry m = odometry_of(own, 4'000'000'000);
    REQUIRE(m.time_usec == 4'000'000'000'000);
    REQUIRE(m.x == 3.5F);
    REQUIRE(m.y == -3.75F);
    REQUIRE(m.frame_id == 1);
    REQUIRE(m.child_frame_id == 12);
    const double heading = 2 * std::atan2(double{m.q[3]}, double{m.q[0]});
    REQUIRE(std::abs(turn_between(heading, psi)) < 1e-5);
    REQUIRE(m.q[1] == 0);
    REQUIRE(m.q[2] == 0);
    REQUIRE(m.vx == 1.5F);
    REQUIRE(m.vy == -0.2F);
    REQUIRE(m.yawspeed == 0.1F);
    // A boat reads the same heading from it.
    const Reading reading = sample_of(m);
    REQUIRE(reading.sample);
    REQUIRE(std::abs(turn_between(reading.sample->psi_rad, psi)) < 1e-5);
  }
}

const link::GpsGlobalOrigin kOrigin{487'000'000, 22'950'000, 0, 0};

TEST_CASE_TEMPLATE("the state sent to followers and read by a follower is the same state", S, float,
                   double) {
  const auto state =
      own_state_of<S>({100, -50}, {{S(0.5), S(-0.25)}, S(2.5), {S(1.5), S(-0.2), S(0.3)}, {}});
  const auto heading = heading_of(attitude_of(state, 4000));
  REQUIRE(heading);
  const auto sample = sample_of(local_position_of(state, 4000), *heading);
  REQUIRE(sample);
  CHECK(sample->stamp_us == 4'000'000);
  CHECK(convert::number(sample->north_m) == doctest::Approx(100.5));
  CHECK(convert::number(sample->east_m) == doctest::Approx(-50.25));
  CHECK(sample->psi_rad == doctest::Approx(2.5));
  CHECK(sample->u_mps == doctest::Approx(1.5));
  CHECK(sample->v_mps == doctest::Approx(-0.2));
  CHECK(sample->r_radps == doctest::Approx(0.3));
}

TEST_CASE_TEMPLATE("the state sent globally and read by a follower is the same state", S, float,
                   double) {
  const auto state = own_state_of<S>({3000, -2000, kOrigin},
                                     {{S(0.5), S(-0.25)}, S(2.5), {S(1.5), S(-0.2), S(0.3)}, {}});
  const auto heading = heading_of(attitude_of(state, 4000));
  const link::GlobalPositionInt position = global_position_of(state, 4000);
  const link::FollowTarget target = follow_target_of(state, 4000);
  CHECK(target.lat == position.lat);
  CHECK(target.est_capabilities == 15);
  CHECK(target.alt == 0);
  for (const auto& sample :
       {sample_of(position, *heading), sample_of(target, own_heading_of(target).value())}) {
    REQUIRE(sample);
    CHECK(sample->stamp_us == 4'000'000);
    const Sample local = in_plane(*sample, kOrigin);
    CHECK(std::abs(convert::number(local.north_m) - 3000.5) < 0.006);
    CHECK(std::abs(convert::number(local.east_m) + 2000.25) < 0.006);
    CHECK(std::abs(local.u_mps - 1.5) < 0.008);  // one of the two messages has steps of 1 cm/s
    CHECK(std::abs(local.v_mps + 0.2) < 0.008);
    CHECK(local.r_radps == doctest::Approx(0.3));
  }
  // ATTITUDE's heading is relative to the local frame's north; these two use true north.
  const double turn = global_of({3000.5, -2000.25, kOrigin}).turn_rad;
  CHECK(turn == doctest::Approx(3.57e-4).epsilon(0.01));
  CHECK(own_heading_of(target)->psi_rad == doctest::Approx(2.5 - turn));
  CHECK(position.hdg == std::lround(18'000 / kPi * (2.5 - turn)));
}

TEST_CASE_TEMPLATE("FOLLOW_TARGET's acceleration is that of a boat on a circle", S, float, double) {
  const double u = 1.5, v = 0.2, r = 0.3, h = 1e-3, psi = 0.8;
  const auto at = [&](double t) {
    return core::to_north_east(psi + r * t, core::Vec2<double>{u + 0.1 * t, v - 0.4 * t});
  };
  const link::FollowTarget m = follow_target_of(
      own_state_of<S>({0, 0, kOrigin}, {{}, S(psi), {S(u), S(v), S(r)}, {S(0.1), S(-0.4), S(0)}}),
      1);
  CHECK(std::abs(double{m.acc[0]} - (at(h).x - at(-h).x) / (2 * h)) < 1e-4);
  CHECK(std::abs(double{m.acc[1]} - (at(h).y - at(-h).y) / (2 * h)) < 1e-4);
}

TEST_CASE("the true heading is sent as 0 to 359.99 degrees") {
  const auto told = [&](double psi) {
    return global_position_of(own_state_of<double>({0, 0, kOrigin}, {{}, psi, {}, {}}), 1).hdg;
  };
  CHECK(told(0) == 0);
  CHECK(told(-1e-7) == 0);
  CHECK(told(-kPi / 2) == 27'000);
  CHECK(told(kPi) == 18'000);
  CHECK(told(5 * kPi) == 18'000);
  CHECK(told(-0.01 * kPi / 180) == 35'999);
}

}  // namespace
}  // namespace flotilla::app::convert
