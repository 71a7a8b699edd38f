// SPDX-License-Identifier: MIT
// MAVLink state messages, read: the half of convert that faces the wire.
#include <array>
#include <cmath>
#include <initializer_list>

#include "app/convert.hpp"

namespace flotilla::app::convert {
namespace {

constexpr double kFarthest_m = 1e6, kFastest_mps = 50, kFastestTurn_radps = 20;
constexpr double kMetresPerCentimetre = 0.01;
constexpr std::int64_t kMicrosecondsPerMillisecond = 1000;

struct Vec3 {
  double x, y, z;
};

bool within(double limit, std::initializer_list<double> values) {
  for (const double value : values) {
    if (!(std::abs(value) <= limit)) return false;  // false for NaN
  }
  return true;
}

/// Body to frame, of a unit quaternion (w x y z).
Vec3 rotate(const std::array<double, 4>& q, const Vec3& v) {
  const auto [w, x, y, z] = q;
  return {(1 - 2 * (y * y + z * z)) * v.x + 2 * (x * y - w * z) * v.y + 2 * (x * z + w * y) * v.z,
          2 * (x * y + w * z) * v.x + (1 - 2 * (x * x + z * z)) * v.y + 2 * (y * z - w * x) * v.z,
          2 * (x * z - w * y) * v.x + 2 * (y * z + w * x) * v.y + (1 - 2 * (x * x + y * y)) * v.z};
}

/// ψ̇ from body rates and attitude (Fossen 2011, eq. 2.26); nothing near the vertical.
std::optional<double> heading_rate(double roll, double pitch, double q, double r) {
  const double c = std::cos(pitch);
  if (c < 0.1 || std::cos(roll) < 0.1) return std::nullopt;
  return (q * std::sin(roll) + r * std::cos(roll)) / c;
}

/// A vector of the message's frame in north-east-down.
Vec3 ned_of(bool enu, const Vec3& v) { return enu ? Vec3{v.y, v.x, -v.z} : v; }

/// Heading and its rate, of body axes in north-east-down.
struct Turning {
  double psi_rad, r_radps;
};
std::optional<Turning> turning_of(const Vec3& ahead, const Vec3& starboard, const Vec3& keel,
                                  double pitchspeed, double yawspeed) {
  const double pitch = std::asin(std::fmax(-1.0, std::fmin(1.0, -ahead.z)));
  const double roll = std::atan2(starboard.z, keel.z);
  const auto r = heading_rate(roll, pitch, pitchspeed, yawspeed);
  if (!r) return std::nullopt;
  return Turning{std::atan2(ahead.y, ahead.x), *r};
}

/// A unit quaternion of the same direction; nothing where there is none.
std::optional<std::array<double, 4>> normalised(const std::array<float, 4>& wire) {
  std::array<double, 4> q{wire[0], wire[1], wire[2], wire[3]};
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!(norm > 0.1 && norm < 10)) return std::nullopt;
  for (double& component : q) component /= norm;
  return q;
}

Sample with_velocity_n(Sample sample, double north_mps, double east_mps) {
  const double c = std::cos(sample.psi_rad), s = std::sin(sample.psi_rad);
  sample.u_mps = c * north_mps + s * east_mps;
  sample.v_mps = c * east_mps - s * north_mps;
  return sample;
}

/// Not off the globe, too near a pole, or 0, 0, which is what units without a fix say.
bool is_fix(std::int32_t latitude, std::int32_t longitude) {
  const bool no_fix = latitude == 0 && longitude == 0;
  return !no_fix && std::abs(std::int64_t{latitude}) <= 890'000'000 &&
         std::abs(std::int64_t{longitude}) <= 1'800'000'000;
}

std::int64_t follow_stamp_us(const link::FollowTarget& m) {
  return static_cast<std::int64_t>(m.timestamp) * kMicrosecondsPerMillisecond;
}

/// The heading, carried over to a stamp of the same clock.
Sample joined(const HeadingSample& heading, std::int64_t time_us) {
  const std::int64_t stamp_us = unwrapped_us(time_us, heading.stamp_us);
  const double later_s = static_cast<double>(stamp_us - heading.stamp_us) * 1e-6;
  const double psi = heading.psi_rad + heading.r_radps * later_s;
  return {stamp_us, 0, 0, psi, 0, 0, heading.r_radps};
}

}  // namespace

Reading sample_of(const link::Odometry& m) {
  namespace mav = link::mav;
  const bool enu = m.frame_id == mav::kFrameLocalEnu;
  const bool velocity_b = m.child_frame_id == mav::kFrameBodyFrd ||
                          m.child_frame_id == mav::kFrameBodyNed ||
                          m.child_frame_id == mav::kFrameBodyOffsetNed;
  const bool velocity_enu = m.child_frame_id == mav::kFrameLocalEnu;
  if (!(enu || m.frame_id == mav::kFrameLocalNed) ||
      !(velocity_b || velocity_enu || m.child_frame_id == mav::kFrameLocalNed)) {
    return {std::nullopt, Refusal::kBadFrame};
  }
  const auto q = normalised(m.q);
  if (m.quality < 0) return {};
  if (!within(kFarthest_m, {m.x, m.y, m.z}) || !within(kFastest_mps, {m.vx, m.vy, m.vz}) ||
      !within(kFastestTurn_radps, {m.rollspeed, m.pitchspeed, m.yawspeed}) || !q ||
      m.time_usec > INT64_MAX / 4) {
    return {};
  }
  const auto turning =
      turning_of(ned_of(enu, rotate(*q, {1, 0, 0})), ned_of(enu, rotate(*q, {0, 1, 0})),
                 ned_of(enu, rotate(*q, {0, 0, 1})), m.pitchspeed, m.yawspeed);
  if (!turning) return {};
  const auto [psi, r] = *turning;
  const Vec3 position = ned_of(enu, {m.x, m.y, m.z});
  const Vec3 wire{m.vx, m.vy, m.vz};
  const Vec3 velocity = velocity_b ? ned_of(enu, rotate(*q, wire)) : ned_of(velocity_enu, wire);
  const Sample sample{static_cast<std::int64_t>(m.time_usec), position.x, position.y, psi, 0, 0, r};
  return {with_velocity_n(sample, velocity.x, velocity.y), {}};
}

std::optional<HeadingSample> heading_of(const link::Attitude& m) {
  if (!within(10, {m.roll, m.pitch, m.yaw}) ||
      !within(kFastestTurn_radps, {m.rollspeed, m.pitchspeed, m.yawspeed})) {
    return std::nullopt;
  }
  const auto r = heading_rate(m.roll, m.pitch, m.pitchspeed, m.yawspeed);
  if (!r) return std::nullopt;
  return HeadingSample{m.time_boot_ms * kMicrosecondsPerMillisecond, m.yaw, *r};
}

std::optional<Sample> sample_of(const link::LocalPositionNed& m, const HeadingSample& heading) {
  if (!within(kFarthest_m, {m.x, m.y, m.z}) || !within(kFastest_mps, {m.vx, m.vy, m.vz})) {
    return std::nullopt;
  }
  Sample sample = joined(heading, m.time_boot_ms * kMicrosecondsPerMillisecond);
  sample.north_m = m.x;
  sample.east_m = m.y;
  return with_velocity_n(sample, m.vx, m.vy);
}

std::optional<Sample> sample_of(const link::GlobalPositionInt& m, const HeadingSample& heading) {
  const double north_mps = m.vx * kMetresPerCentimetre, east_mps = m.vy * kMetresPerCentimetre;
  if (!is_fix(m.lat, m.lon) || !within(kFastest_mps, {north_mps, east_mps})) return std::nullopt;
  Sample sample = joined(heading, m.time_boot_ms * kMicrosecondsPerMillisecond);
  sample.at = {m.lat, m.lon};
  return with_velocity_n(sample, north_mps, east_mps);
}

bool is_usable(const link::FollowTarget& m) {
  namespace mav = link::mav;
  constexpr std::uint8_t kNeeded = mav::kFollowPosition | mav::kFollowVelocity;
  constexpr std::uint64_t kLatest_ms = INT64_MAX / 4 / kMicrosecondsPerMillisecond;
  const bool attitude = (m.est_capabilities & mav::kFollowAttitude) != 0;
  return (m.est_capabilities & kNeeded) == kNeeded && is_fix(m.lat, m.lon) &&
         within(kFastest_mps, {m.vel[0], m.vel[1], m.vel[2]}) && m.timestamp <= kLatest_ms &&
         (!attitude || (within(10, {m.q[0], m.q[1], m.q[2], m.q[3]}) &&
                        within(kFastestTurn_radps, {m.rates[0], m.rates[1], m.rates[2]})));
}

std::optional<HeadingSample> own_heading_of(const link::FollowTarget& m) {
  const auto q = normalised(m.q);
  if (!q || (m.est_capabilities & link::mav::kFollowAttitude) == 0) return std::nullopt;
  const auto turning = turning_of(rotate(*q, {1, 0, 0}), rotate(*q, {0, 1, 0}),
                                  rotate(*q, {0, 0, 1}), m.rates[1], m.rates[2]);
  if (!turning) return std::nullopt;
  return HeadingSample{follow_stamp_us(m), turning->psi_rad, turning->r_radps};
}

std::optional<Sample> sample_of(const link::FollowTarget& m, const HeadingSample& heading) {
  if (!is_usable(m)) return std::nullopt;
  Sample sample = joined(heading, follow_stamp_us(m));
  sample.at = {m.lat, m.lon};
  return with_velocity_n(sample, m.vel[0], m.vel[1]);
}

Sample at_reference_point(const Sample& antenna, double x, double y) {
  Sample out = antenna;
  out.u_mps += antenna.r_radps * y;  // v_reference = v_antenna − ω × offset
  out.v_mps -= antenna.r_radps * x;
  if (x == 0 && y == 0) return out;
  const double c = std::cos(antenna.psi_rad), s = std::sin(antenna.psi_rad);
  out.north_m -= c * x - s * y;
  out.east_m -= s * x + c * y;
  return out;
}

bool is_valid(const link::GpsGlobalOrigin& o) { return is_fix(o.latitude, o.longitude); }

}  // namespace flotilla::app::convert
