// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <random>

#include "app/convert.hpp"

namespace flotilla::app::convert {
namespace {

using Quaternion = std::array<double, 4>;
using Vector = std::array<double, 3>;
constexpr double kPi = 3.14159265358979323846;
using Frames = std::initializer_list<std::uint8_t>;
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
          a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
          a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

Vector rotated(const Quaternion& q, const Vector& v) {
  const Quaternion r = product(product(q, {0, v[0], v[1], v[2]}), {q[0], -q[1], -q[2], -q[3]});
  return {r[1], r[2], r[3]};
}

Quaternion about(std::size_t axis, double angle) {
  Quaternion q{std::cos(angle / 2), 0, 0, 0};
  q[axis + 1] = std::sin(angle / 2);
  return q;
}

Quaternion from_euler(double roll, double pitch, double yaw) {
  return product(product(about(2, yaw), about(1, pitch)), about(0, roll));
}

/// Half a turn about the axis between north and east.
const Quaternion kNedToEnu{0, std::sqrt(0.5), std::sqrt(0.5), 0};

/// The truth, and how it is told.
struct Truth {
  double roll, pitch, yaw;
  Vector velocity_n;  ///< north-east-down
  double yaw_rate;    ///< ψ̇, with roll and pitch held
};

link::Odometry told(const Truth& t, std::uint8_t frame, std::uint8_t child) {
  const bool enu = frame == link::mav::kFrameLocalEnu;
  const Quaternion to_ned = from_euler(t.roll, t.pitch, t.yaw);
  const Quaternion q = enu ? product(kNedToEnu, to_ned) : to_ned;
  Vector v = t.velocity_n;
  if (child == link::mav::kFrameLocalEnu) v = {v[1], v[0], -v[2]};
  if (child >= link::mav::kFrameBodyNed) {
    v = rotated({to_ned[0], -to_ned[1], -to_ned[2], -to_ned[3]}, v);
  }
  const auto f = [](double x) { return static_cast<float>(x); };
  link::Odometry m{};
  m.time_usec = 123'456;
  m.x = enu ? 20 : 10, m.y = enu ? 10 : 20, m.z = enu ? -1 : 1;
  for (std::size_t i = 0; i < 4; ++i) m.q[i] = f(q[i]);
  m.vx = f(v[0]), m.vy = f(v[1]), m.vz = f(v[2]);
  m.rollspeed = f(-t.yaw_rate * std::sin(t.pitch));
  m.pitchspeed = f(t.yaw_rate * std::cos(t.pitch) * std::sin(t.roll));
  m.yawspeed = f(t.yaw_rate * std::cos(t.pitch) * std::cos(t.roll));
  m.frame_id = frame;
  m.child_frame_id = child;
  return m;
}

TEST_CASE("rolling and pitching, told in any pose and velocity frame, it is the same boat") {
  constexpr std::uint32_t kSeed = 71;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  const auto draw = [&](double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random);
  };
  for (int i = 0; i < 300; ++i) {
    const Truth t{draw(0.5), draw(0.5), draw(3.1), {draw(3), draw(3), draw(0.5)}, draw(1)};
    const double u = std::cos(t.yaw) * t.velocity_n[0] + std::sin(t.yaw) * t.velocity_n[1];
    const double v = std::cos(t.yaw) * t.velocity_n[1] - std::sin(t.yaw) * t.velocity_n[0];
    for (const std::uint8_t frame : Frames{1, 4}) {
      for (const std::uint8_t child : Frames{1, 4, 8, 9, 12}) {
        CAPTURE(int{frame});
        CAPTURE(int{child});
        const Reading reading = sample_of(told(t, frame, child));
        REQUIRE(reading.sample);
        CHECK(reading.sample->stamp_us == 123'456);
        CHECK(reading.sample->north_m == 10);
        CHECK(reading.sample->east_m == 20);
        CHECK(std::abs(std::remainder(reading.sample->psi_rad - t.yaw, 2 * kPi)) < 1e-5);
        CHECK(std::abs(reading.sample->u_mps - u) < 1e-5);
        CHECK(std::abs(reading.sample->v_mps - v) < 1e-5);
        CHECK(std::abs(reading.sample->r_radps - t.yaw_rate) < 1e-5);
      }
    }
  }
}

TEST_CASE("a pose in a frame without north is refused for its frame") {
  const Truth t{0, 0, 1, {1, 0, 0}, 0};
  for (const std::uint8_t frame : Frames{0, 2, 3, 5, 8, 12, 20, 21, 255}) {
    link::Odometry m = told(t, 1, 12);
    m.frame_id = frame;
    CHECK_FALSE(sample_of(m).sample);
    CHECK(sample_of(m).refusal == Refusal::kBadFrame);
  }
}

TEST_CASE("NaN, infinity and absurd numbers in any field are refused for their value") {
  const Truth t{0, 0, 1, {1, 0, 0}, 0};
  for (const float bad : {kNaN, HUGE_VALF, -HUGE_VALF, 1e30F}) {
    for (std::size_t field = 0; field < 13; ++field) {
      link::Odometry m = told(t, 1, 12);
      std::array<float*, 13> fields{&m.x,         &m.y,          &m.z,       &m.q[0], &m.q[1],
                                    &m.q[2],      &m.q[3],       &m.vx,      &m.vy,   &m.vz,
                                    &m.rollspeed, &m.pitchspeed, &m.yawspeed};
      *fields[field] = bad;
      CAPTURE(field);
      CHECK_FALSE(sample_of(m).sample);
      CHECK(sample_of(m).refusal == Refusal::kBadValue);
    }
  }
}

TEST_CASE("a quaternion of zeros is refused, one of another length is taken for its direction") {
  link::Odometry m = told({0.1, 0.1, 1, {1, 0, 0}, 0}, 1, 12);
  for (float& c : m.q) c *= 1.5F;
  REQUIRE(sample_of(m).sample);
  CHECK(sample_of(m).sample->psi_rad == doctest::Approx(1).epsilon(1e-5));
  m.q = {0, 0, 0, 0};
  CHECK_FALSE(sample_of(m).sample);
  m = told({0, kPi / 2, 1, {1, 0, 0}, 0}, 1, 12);  // bow straight up: no heading
  CHECK_FALSE(sample_of(m).sample);
}

TEST_CASE("attitude: psi's own rate when rolling; NaN and upside down are refused") {
  const auto heading = heading_of({1000, 0.3F, 0.2F, 1.5F, 0, 0.1F, 0.4F});
  REQUIRE(heading);
  CHECK(heading->stamp_us == 1'000'000);
  CHECK(heading->psi_rad == doctest::Approx(1.5));
  CHECK(heading->r_radps ==
        doctest::Approx((0.1 * std::sin(0.3) + 0.4 * std::cos(0.3)) / std::cos(0.2)));
  CHECK_FALSE(heading_of({1000, 3.1F, 0, 0, 0, 0, 0}));
  for (std::size_t field = 0; field < 6; ++field) {
    link::Attitude m{};
    *std::array{&m.roll, &m.pitch, &m.yaw, &m.rollspeed, &m.pitchspeed, &m.yawspeed}[field] = kNaN;
    CHECK_FALSE(heading_of(m));
  }
}

TEST_CASE("a position takes the heading that the boat has turned to since the attitude") {
  const HeadingSample heading{900'000, 1.0, 0.5};
  const auto sample = sample_of(link::LocalPositionNed{1000, 3, 4, 0, 2, 0, 0}, heading);
  REQUIRE(sample);
  CHECK(sample->stamp_us == 1'000'000);
  CHECK(sample->psi_rad == doctest::Approx(1.05));
  CHECK(sample->u_mps == doctest::Approx(2 * std::cos(1.05)));
  CHECK(sample->v_mps == doctest::Approx(-2 * std::sin(1.05)));
  for (std::size_t field = 0; field < 6; ++field) {
    link::LocalPositionNed m{};
    *std::array{&m.x, &m.y, &m.z, &m.vx, &m.vy, &m.vz}[field] = kNaN;
    CHECK_FALSE(sample_of(m, heading));
  }
}

TEST_CASE("a boat that turns on the spot stands still, though its antenna runs round it") {
  const double x = 2, y = -1, r = 0.7;
  for (double psi = -3; psi < 3; psi += 0.5) {
    const double north = 5 + std::cos(psi) * x - std::sin(psi) * y;
    const double east = 6 + std::sin(psi) * x + std::cos(psi) * y;
    const Sample s = at_reference_point({1, north, east, psi, -r * y, r * x, r}, x, y);
    CHECK(s.north_m == doctest::Approx(5));
    CHECK(s.east_m == doctest::Approx(6));
    CHECK(std::abs(s.u_mps) < 1e-12);
    CHECK(std::abs(s.v_mps) < 1e-12);
    CHECK(s.psi_rad == psi);
    CHECK(s.r_radps == r);
  }
}

/// Earth-centred WGS 84.
Vector ecef(double latitude, double longitude) {
  constexpr double a = 6378137.0, f = 1 / 298.257223563, e2 = f * (2 - f);
  const double n = a / std::sqrt(1 - e2 * std::sin(latitude) * std::sin(latitude));
  return {n * std::cos(latitude) * std::cos(longitude),
          n * std::cos(latitude) * std::sin(longitude), n * (1 - e2) * std::sin(latitude)};
}

link::GpsGlobalOrigin origin_at(double latitude_deg, double longitude_deg) {
  return {static_cast<std::int32_t>(std::lround(latitude_deg * 1e7)),
          static_cast<std::int32_t>(std::lround(longitude_deg * 1e7)), 0, 0};
}

TEST_CASE_TEMPLATE("origins a kilometre apart: the separation is that on the ellipsoid", S, float,
                   double) {
  for (const double latitude : {0.0, 41.0, -33.0, 60.0}) {
    for (const double longitude : {-122.0, 2.0, 179.9995}) {
      const double east_deg = 0.7 / 111.3 / std::cos(latitude * kPi / 180);
      const auto own = origin_at(latitude + 0.0065, std::remainder(longitude + east_deg, 360));
      const auto leader = origin_at(latitude, longitude);
      const double unit = kPi / 180e7;
      const double phi = 0.5 * (own.latitude + leader.latitude) * unit;
      const double lambda = (longitude + 0.5 * east_deg) * kPi / 180;
      const Vector a = ecef(own.latitude * unit, own.longitude * unit);
      const Vector b = ecef(leader.latitude * unit, leader.longitude * unit);
      const Vector d{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
      const double outward = std::cos(lambda) * d[0] + std::sin(lambda) * d[1];
      const double north = std::cos(phi) * d[2] - std::sin(phi) * outward;
      const double east = std::cos(lambda) * d[1] - std::sin(lambda) * d[0];
      CAPTURE(latitude);
      CAPTURE(longitude);
      const auto got = separation<S>(Position{0, 0, own}, Position{0, 0, leader});
      CHECK(std::abs(double(got.x) - north) < 0.01);
      CHECK(std::abs(double(got.y) - east) < 0.01);
      const auto back = separation<S>(Position{0, 0, leader}, Position{0, 0, own});
      CHECK(back.x == -got.x);
      CHECK(back.y == -got.y);
      const auto moved = separation<S>(Position{30, -40, own}, Position{-5, 7, leader});
      CHECK(std::abs(double(moved.x) - (north + 35)) < 0.02);
      CHECK(std::abs(double(moved.y) - (east - 47)) < 0.02);
    }
  }
}

TEST_CASE_TEMPLATE("far from a common origin, a float's separation still has millimetres", S, float,
                   double) {
  const auto origin = origin_at(41, 2);
  const auto got = separation<S>(Position{400'000.125, -300'000.5, origin},
                                 Position{400'001.5, -300'002.5, origin});
  CHECK(got.x == S(-1.375));
  CHECK(got.y == S(2));
}

TEST_CASE("an origin beyond the poles or the antimeridian is none") {
  CHECK(is_valid(origin_at(41, 2)));
  CHECK_FALSE(is_valid(origin_at(91, 2)));
  CHECK_FALSE(is_valid(origin_at(-91, 2)));
  CHECK_FALSE(is_valid(origin_at(0, 181)));
  CHECK_FALSE(is_valid({INT32_MIN, INT32_MIN, 0, 0}));
}

TEST_CASE_TEMPLATE("commands are 8191 steps each way, rounded to the nearest", S, float, double) {
  CHECK(raw_of(S(1)) == 8191);
  CHECK(raw_of(S(-1)) == -8191);
  CHECK(raw_of(S(0)) == 0);
  for (int raw = -8191; raw <= 8191; raw += 7) {
    CHECK(raw_of(command_of<S>(static_cast<std::int16_t>(raw))) == raw);
    CHECK(raw_of(S((raw + 0.4) / 8191)) == raw);
  }
}

TEST_CASE_TEMPLATE("the state for followers, read by a follower, is the state", S, float, double) {
  OwnState<S> state{100, -50, {{S(0.5), S(-0.25)}, S(2.5), {S(1.5), S(-0.2), S(0.3)}, {}}};
  const auto heading = heading_of(attitude_of(state, 4000));
  REQUIRE(heading);
  const auto sample = sample_of(local_position_of(state, 4000), *heading);
  REQUIRE(sample);
  CHECK(sample->stamp_us == 4'000'000);
  CHECK(sample->north_m == doctest::Approx(100.5));
  CHECK(sample->east_m == doctest::Approx(-50.25));
  CHECK(sample->psi_rad == doctest::Approx(2.5));
  CHECK(sample->u_mps == doctest::Approx(1.5));
  CHECK(sample->v_mps == doctest::Approx(-0.2));
  CHECK(sample->r_radps == doctest::Approx(0.3));
}

TEST_CASE("rates and times: a rate of zero has no period, milliseconds are those that have begun") {
  CHECK(period_us(100) == 10'000);
  CHECK(period_us(0) == 0);
  CHECK(period_us(-1) == 0);
  CHECK(boot_ms(1999) == 1);
  CHECK(us_of_ms(1999) == 1000);
  CHECK(boot_ms((std::int64_t{1} << 32) * 1000 + 7000) == 7);
  CHECK(seconds<double>(1'500'000) == doctest::Approx(1.5));
}

}  // namespace
}  // namespace flotilla::app::convert
