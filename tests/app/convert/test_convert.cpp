// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <random>

#include "app/convert/convert.hpp"
#include "app/convert/convert_scalar.hpp"
#include "core/scalar/overflow.hpp"

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

/// The true motion of a vessel; told() makes its message.
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

TEST_CASE("a rolling, pitching boat has the same state in every pose and velocity frame") {
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

TEST_CASE("a pose in a frame without north is refused as a bad frame") {
  const Truth t{0, 0, 1, {1, 0, 0}, 0};
  for (const std::uint8_t frame : Frames{0, 2, 3, 5, 8, 12, 20, 21, 255}) {
    link::Odometry m = told(t, 1, 12);
    m.frame_id = frame;
    CHECK_FALSE(sample_of(m).sample);
    CHECK(sample_of(m).refusal == Refusal::kBadFrame);
  }
}

TEST_CASE("NaN, infinity and absurd numbers in any field are refused as bad values") {
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

TEST_CASE("a quaternion of zeros is refused; one of any other length is normalised") {
  link::Odometry m = told({0.1, 0.1, 1, {1, 0, 0}, 0}, 1, 12);
  for (float& c : m.q) c *= 1.5F;
  REQUIRE(sample_of(m).sample);
  CHECK(sample_of(m).sample->psi_rad == doctest::Approx(1).epsilon(1e-5));
  m.q = {0, 0, 0, 0};
  CHECK_FALSE(sample_of(m).sample);
  m = told({0, kPi / 2, 1, {1, 0, 0}, 0}, 1, 12);  // bow straight up: no heading
  CHECK_FALSE(sample_of(m).sample);
}

TEST_CASE(
    "ATTITUDE: yaw rate is psi's derivative, even when rolling; NaN and upside down are refused") {
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

TEST_CASE("a position's heading is the last attitude's, extrapolated by the yaw rate") {
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

link::GlobalPositionInt global() { return {1000, 410'000'000, 20'000'000, 0, 0, 200, 0, 0, 65535}; }

link::FollowTarget follow_target() {
  link::FollowTarget m{};
  m.timestamp = 1000;
  m.lat = 410'000'000, m.lon = 20'000'000;
  m.vel = {2, 0, 0};
  m.acc = {kNaN, kNaN, kNaN};  // unknown, and not used
  const Quaternion q = from_euler(0.1, -0.2, 1.5);
  for (std::size_t i = 0; i < 4; ++i) m.attitude_q[i] = static_cast<float>(q[i]);
  m.rates = {0, 0.1F, 0.4F};
  m.est_capabilities = 1 | 2 | 8;
  return m;
}

TEST_CASE("GLOBAL_POSITION_INT: velocity in cm/s, and the last attitude's heading, extrapolated") {
  const HeadingSample heading{900'000, 1.0, 0.5};
  const auto sample = sample_of(global(), heading);
  REQUIRE(sample);
  CHECK(sample->stamp_us == 1'000'000);
  CHECK(sample->at->latitude == 410'000'000);
  CHECK(sample->at->longitude == 20'000'000);
  CHECK(sample->psi_rad == doctest::Approx(1.05));
  CHECK(sample->u_mps == doctest::Approx(2 * std::cos(1.05)));
  CHECK(sample->v_mps == doctest::Approx(-2 * std::sin(1.05)));
  CHECK(sample->r_radps == 0.5);
  link::GlobalPositionInt m = global();
  m.lat = m.lon = 0;  // no fix
  CHECK_FALSE(sample_of(m, heading));
  for (const std::int32_t far : {INT32_MIN, INT32_MAX, 900'000'001}) {
    m = global();
    m.lat = far;
    CHECK_FALSE(sample_of(m, heading));
  }
  m = global();
  m.lon = 1'800'000'001;
  CHECK_FALSE(sample_of(m, heading));
  m = global();
  m.vy = INT16_MIN;
  CHECK_FALSE(sample_of(m, heading));
}

TEST_CASE("FOLLOW_TARGET with attitude: a complete state, whose yaw rate is psi's derivative") {
  const auto heading = own_heading_of(follow_target());
  REQUIRE(heading);
  CHECK(heading->psi_rad == doctest::Approx(1.5));
  CHECK(heading->r_radps ==
        doctest::Approx((0.1 * std::sin(0.1) + 0.4 * std::cos(0.1)) / std::cos(0.2)));
  const auto sample = sample_of(follow_target(), *heading);
  REQUIRE(sample);
  CHECK(sample->stamp_us == 1'000'000);
  CHECK(sample->at->longitude == 20'000'000);
  CHECK(sample->u_mps == doctest::Approx(2 * std::cos(1.5)));
  CHECK(sample->v_mps == doctest::Approx(-2 * std::sin(1.5)));
}

TEST_CASE("FOLLOW_TARGET whose attitude is unknown takes that of ATTITUDE") {
  const HeadingSample attitude{900'000, 1.0, 0.5};
  link::FollowTarget m = follow_target();
  m.attitude_q = {0, 0, 0, 0};
  CHECK(is_usable(m));
  CHECK_FALSE(own_heading_of(m));
  m = follow_target();
  m.est_capabilities = 1 | 2;
  m.attitude_q = {kNaN, kNaN, kNaN, kNaN};
  CHECK(is_usable(m));
  CHECK_FALSE(own_heading_of(m));
  CHECK(sample_of(m, attitude)->psi_rad == doctest::Approx(1.05));
}

TEST_CASE("FOLLOW_TARGET without position, velocity or a fix, or with absurd numbers, is refused") {
  const auto refused = [](auto change) {
    link::FollowTarget m = follow_target();
    change(m);
    return !is_usable(m) && !sample_of(m, HeadingSample<double>{});
  };
  CHECK_FALSE(refused([](auto&) {}));
  CHECK(refused([](auto& m) { m.est_capabilities = 1 | 8; }));
  CHECK(refused([](auto& m) { m.est_capabilities = 2 | 8; }));
  CHECK(refused([](auto& m) { m.lat = m.lon = 0; }));
  CHECK(refused([](auto& m) { m.lat = 900'000'001; }));
  CHECK(refused([](auto& m) { m.timestamp = UINT64_MAX; }));
  for (const float bad : {kNaN, HUGE_VALF, -HUGE_VALF, 1e30F}) {
    for (std::size_t i = 0; i < 4; ++i) {
      CAPTURE(i);
      CHECK(refused([&](auto& m) { m.attitude_q[i] = bad; }));
      if (i == 3) continue;
      CHECK(refused([&](auto& m) { m.vel[i] = bad; }));
      CHECK(refused([&](auto& m) { m.rates[i] = bad; }));
    }
  }
}

TEST_CASE("a boat that turns on the spot stands still, although its antenna moves in a circle") {
  const double x = 2, y = -1, r = 0.7;
  for (double psi = -3; psi < 3; psi += 0.5) {
    const double north = 5 + std::cos(psi) * x - std::sin(psi) * y;
    const double east = 6 + std::sin(psi) * x + std::cos(psi) * y;
    Sample s{1, north, east, psi, -r * y, r * x, r};
    move_to_reference_point(s, x, y);
    CHECK(convert::number(s.north_m) == doctest::Approx(5));
    CHECK(convert::number(s.east_m) == doctest::Approx(6));
    CHECK(std::abs(s.u_mps) < 1e-12);
    CHECK(std::abs(s.v_mps) < 1e-12);
    CHECK(s.psi_rad == psi);
    CHECK(s.r_radps == r);
  }
}

link::GpsGlobalOrigin origin_at(double latitude_deg, double longitude_deg) {
  return {static_cast<std::int32_t>(std::lround(latitude_deg * 1e7)),
          static_cast<std::int32_t>(std::lround(longitude_deg * 1e7)), 0, 0};
}

/// A leader at (north, east) of its own plane, seen from another origin. The last three numbers
/// come from geodesics that were integrated numerically, as in tests/sil/wire/test_geodesy.py.
struct TwoOrigins {
  link::GpsGlobalOrigin own, leader;
  double north_m, east_m;
  double seen_north_m, seen_east_m, turn_rad;
};
constexpr TwoOrigins kTwoOrigins[] = {
    {{410126000, 20238000, 0, 0},
     {410000000, 20000000, 0, 0},
     500,
     -300,
     -898.92609,
     -2302.28105,
     0.00027255},
    {{487000000, 22950000, 0, 0},
     {487125918, 23140342, 0, 0},
     -1400,
     -1400,
     0.08447,
     1.11202,
     -0.00024960},
    {{126000, 1799910000, 0, 0},
     {0, -1799910000, 0, 0},
     100,
     2000,
     -1293.23559,
     4003.75060,
     -0.00000003},
    {{-330000000, -1220000000, 0, 0},
     {-330126000, -1219790000, 0, 0},
     -700,
     900,
     -2097.77302,
     2862.09860,
     0.00019965},
    {{600000000, 50000000, 0, 0},
     {600126000, 50250000, 0, 0},
     0,
     0,
     1404.05963,
     1394.46950,
     -0.00037790},
    {{-780000000, 0, 0, 0},
     {-780126000, 600000, 0, 0},
     1500,
     1500,
     91.02002,
     2893.24055,
     0.00102434},
};

TEST_CASE(
    "a leader's position from an origin 2 km away agrees with geodesics within a millimetre") {
  for (const TwoOrigins& t : kTwoOrigins) {
    CAPTURE(t.own.latitude);
    const Position own{-20, 30, t.own}, leader{t.north_m, t.east_m, t.leader};
    const auto got = separation<double>(own, leader).n;
    CHECK(std::abs(got.x - (-20 - t.seen_north_m)) < 1e-3);
    CHECK(std::abs(got.y - (30 - t.seen_east_m)) < 1e-3);
    const auto coarse = separation<float>(own, leader).n;
    CHECK(std::abs(double(coarse.x) - got.x) < 3e-4);
    CHECK(std::abs(double(coarse.y) - got.y) < 3e-4);
  }
}

TEST_CASE_TEMPLATE("a leader's heading and displacement are rotated from its north to ours", S,
                   float, double) {
  for (const TwoOrigins& t : kTwoOrigins) {
    CAPTURE(t.own.latitude);
    const core::Motion<S> still{{}, S(0.3), {S(1), S(2), S(3)}, {}};
    const core::Motion<S> moving{{S(200), S(100)}, S(-1), {S(4), S(5), S(6)}, {S(7), S(8), S(9)}};
    const Position own{0, 0, t.own}, leader{t.north_m, t.east_m, t.leader};
    const auto in = controller_input_of<S>(own, still, leader, moving);
    CHECK(double(in.psi) == doctest::Approx(0.3));
    CHECK(std::abs(double(in.psi_L) - (-1 + t.turn_rad)) < 1e-6);
    // The leader's place, as if its last message had given the moved place.
    const auto there = separation<double>(own, {t.north_m + 200, t.east_m + 100, t.leader}).n;
    CHECK(std::abs(double(in.separation_n.x) - there.x) < 2e-3);
    CHECK(std::abs(double(in.separation_n.y) - there.y) < 2e-3);
    CHECK(in.nu.v == S(2));
    CHECK(in.nu_L.v == S(5));
    CHECK(in.nu_L_dot.v == S(8));
  }
}

TEST_CASE("a global position becomes the same place in the plane of any origin near enough") {
  const Sample<double> sample{7, 0, 0, 0.5, 1, 2, 3, GlobalPoint{487'125'918, 23'140'342}};
  const link::GpsGlobalOrigin origin{487'000'000, 22'950'000, 0, 0};
  const Sample got = in_plane(sample, origin);
  CHECK(std::abs(convert::number(got.north_m) - 1400.43387) < 1e-3);
  CHECK(std::abs(convert::number(got.east_m) - 1400.76253) < 1e-3);
  CHECK(std::abs(got.psi_rad - (0.5 - 0.00024960)) < 1e-7);
  CHECK(got.u_mps == 1);
  CHECK_FALSE(got.at);
  CHECK(reaches(origin, *sample.at));
  CHECK_FALSE(reaches({487'000'000, -1'777'050'000, 0, 0}, *sample.at));
  CHECK_FALSE(reaches({-487'000'000, -1'777'050'000, 0, 0}, *sample.at));
}

TEST_CASE("any local point converted to degrees and back is the same point") {
  constexpr std::uint32_t kSeed = 72;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  const auto draw = [&](double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random);
  };
  for (int i = 0; i < 500; ++i) {
    const auto origin = origin_at(draw(80), draw(180));
    const double far = i < 250 ? 5'000 : 90'000;
    const double north = draw(far), east = draw(far);
    const GlobalPoint at = global_of({north, east, origin});
    const Sample<double> told{0, 0, 0, 1 - at.turn_rad, 0, 0, 0, at};
    const Sample back = in_plane(told, origin);
    CAPTURE(origin.latitude);
    CHECK(std::abs(convert::number(back.north_m) - north) < 0.006);
    CHECK(std::abs(convert::number(back.east_m) - east) < 0.006);
    CHECK(std::abs(std::remainder(back.psi_rad - 1, 2 * kPi)) < 1e-9);
  }
}

TEST_CASE_TEMPLATE("a point beyond the given distance has no offset, and nothing overflows", S,
                   float, double, core::Q16) {
  core::take_overflow<S>();
  const Position here{10, -20, {600000000, 50000000, 0, 0}};
  const auto [way, near] = way_to<S>(here, {600009000, 50000000}, 3000);  // 100.3 m north
  CHECK(near);
  CHECK(std::abs(number(way.x) - 90.3) < 0.1);
  CHECK(std::abs(number(way.y) - 20) < 0.1);
  const auto far = way_to<S>(here, {603600000, 50000000}, 3000);  // 40 km
  CHECK_FALSE(far.near);
  CHECK(number(far.n.x) == 0);
  CHECK_FALSE(core::take_overflow<S>());
}

TEST_CASE_TEMPLATE(
    "far from a common origin, the separation in float is still accurate to a millimetre", S, float,
    double) {
  const auto origin = origin_at(41, 2);
  const auto got = separation<S>(Position{400'000.125, -300'000.5, origin},
                                 Position{400'001.5, -300'002.5, origin})
                       .n;
  CHECK(got.x == S(-1.375));
  CHECK(got.y == S(2));
}

TEST_CASE("an origin beyond the poles or the antimeridian is invalid") {
  CHECK(is_valid(origin_at(41, 2)));
  CHECK_FALSE(is_valid(origin_at(91, 2)));
  CHECK_FALSE(is_valid(origin_at(-91, 2)));
  CHECK_FALSE(is_valid(origin_at(0, 181)));
  CHECK_FALSE(is_valid({INT32_MIN, INT32_MIN, 0, 0}));
}

TEST_CASE_TEMPLATE("commands are 8191 steps each way, rounded to the nearest", S, float, double) {
  CHECK(raw_of(S(9000)) == 8191);
  CHECK(raw_of(S(-9000)) == -8191);
  CHECK(raw_of(S(0)) == 0);
  for (int raw = -8191; raw <= 8191; raw += 7) {
    CHECK(raw_of(S(raw)) == raw);
    CHECK(raw_of(S(raw + 0.4)) == raw);
  }
}

TEST_CASE("a rate of zero has no period; times are truncated to whole milliseconds") {
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
