// SPDX-License-Identifier: MIT
#include "app/convert.hpp"

#include <array>
#include <cmath>
#include <initializer_list>

namespace flotilla::app::convert {
namespace {

constexpr double kFarthest_m = 1e6, kFastest_mps = 50, kFastestTurn_radps = 20;
constexpr std::int64_t kMicrosecondsPerMillisecond = 1000;
constexpr double kPi = 3.14159265358979323846;

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

Sample with_velocity_n(Sample sample, double north_mps, double east_mps) {
  const double c = std::cos(sample.psi_rad), s = std::sin(sample.psi_rad);
  sample.u_mps = c * north_mps + s * east_mps;
  sample.v_mps = c * east_mps - s * north_mps;
  return sample;
}

/// Metres per degE7 of latitude and of longitude on the WGS 84 ellipsoid.
Vec3 metres_per_degE7(double latitude_rad) {
  constexpr double a = 6378137.0, e2 = 6.69437999014e-3;
  const double s = std::sin(latitude_rad), w2 = 1 - e2 * s * s;
  const double unit = kPi / 180e7;
  return {a * (1 - e2) / (w2 * std::sqrt(w2)) * unit,
          a / std::sqrt(w2) * std::cos(latitude_rad) * unit, 0};
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
  std::array<double, 4> q{m.q[0], m.q[1], m.q[2], m.q[3]};
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!within(kFarthest_m, {m.x, m.y, m.z}) || !within(kFastest_mps, {m.vx, m.vy, m.vz}) ||
      !within(kFastestTurn_radps, {m.rollspeed, m.pitchspeed, m.yawspeed}) ||
      !(norm > 0.1 && norm < 10) || m.time_usec > INT64_MAX / 4) {
    return {};
  }
  for (double& component : q) component /= norm;
  const Vec3 ahead = ned_of(enu, rotate(q, {1, 0, 0}));
  const Vec3 starboard = ned_of(enu, rotate(q, {0, 1, 0}));
  const Vec3 keel = ned_of(enu, rotate(q, {0, 0, 1}));
  const double pitch = std::asin(std::fmax(-1.0, std::fmin(1.0, -ahead.z)));
  const double roll = std::atan2(starboard.z, keel.z);
  const auto r = heading_rate(roll, pitch, m.pitchspeed, m.yawspeed);
  if (!r) return {};
  const Vec3 position = ned_of(enu, {m.x, m.y, m.z});
  const Vec3 wire{m.vx, m.vy, m.vz};
  const Vec3 velocity = velocity_b ? ned_of(enu, rotate(q, wire)) : ned_of(velocity_enu, wire);
  const Sample sample{static_cast<std::int64_t>(m.time_usec),
                      position.x,
                      position.y,
                      std::atan2(ahead.y, ahead.x),
                      0,
                      0,
                      *r};
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
  const std::int64_t stamp_us =
      unwrapped_us(m.time_boot_ms * kMicrosecondsPerMillisecond, heading.stamp_us);
  const double later_s = static_cast<double>(stamp_us - heading.stamp_us) * 1e-6;
  const double psi = heading.psi_rad + heading.r_radps * later_s;
  return with_velocity_n({stamp_us, m.x, m.y, psi, 0, 0, heading.r_radps}, m.vx, m.vy);
}

Sample at_reference_point(const Sample& antenna, double x, double y) {
  const double c = std::cos(antenna.psi_rad), s = std::sin(antenna.psi_rad);
  Sample out = antenna;
  out.north_m -= c * x - s * y;
  out.east_m -= s * x + c * y;
  out.u_mps += antenna.r_radps * y;  // v_reference = v_antenna − ω × offset
  out.v_mps -= antenna.r_radps * x;
  return out;
}

bool is_valid(const link::GpsGlobalOrigin& o) {
  const bool no_fix = o.latitude == 0 && o.longitude == 0;
  return !no_fix && std::abs(std::int64_t{o.latitude}) <= 890'000'000 &&
         std::abs(std::int64_t{o.longitude}) <= 1'800'000'000;
}

template <class S>
core::Vec2<S> separation(const Position& own, const Position& leader) {
  const std::int64_t d_lat = std::int64_t{own.origin.latitude} - leader.origin.latitude;
  std::int64_t d_lon = std::int64_t{own.origin.longitude} - leader.origin.longitude;
  if (d_lon > 1'800'000'000) d_lon -= 3'600'000'000;
  if (d_lon < -1'800'000'000) d_lon += 3'600'000'000;
  Vec3 between{0, 0, 0};
  if (d_lat != 0 || d_lon != 0) {
    const double middle_degE7 = 0.5 * (double(own.origin.latitude) + leader.origin.latitude);
    const Vec3 scale = metres_per_degE7(middle_degE7 * kPi / 180e7);
    between = {scale.x * static_cast<double>(d_lat), scale.y * static_cast<double>(d_lon), 0};
  }
  return {S(own.north_m - leader.north_m + between.x), S(own.east_m - leader.east_m + between.y)};
}

bool near(const Position& own, const Position& leader) {
  constexpr double kNear_m = 5000;
  const core::Vec2<double> d = separation<double>(own, leader);
  return std::hypot(d.x, d.y) <= kNear_m;
}

template <class S>
core::ControllerParams<S> controller_params(const Parameters& p) {
  return {{S(p.FORM_OFS_N), S(p.FORM_OFS_E)},
          {S(p.LAW_KX), S(p.LAW_KPSI)},
          {S(p.LAW_KDU), S(p.LAW_KDR)},
          {S(p.VES_M11), S(p.VES_M22), S(p.VES_M33), S(p.VES_D11), S(p.VES_D22), S(p.VES_D33)},
          {S(p.THR_ARM), S(p.THR_FWD_MAX), S(p.THR_REV_MAX)}};
}

template <class S>
core::ThrustCurveParams<S> thrust_curve_params(const Parameters& p) {
  return {S(p.THR_FWD_MAX), S(p.THR_REV_MAX), S(p.THR_EXPO), S(p.THR_DEAD)};
}

template <class S>
link::Attitude attitude_of(const OwnState<S>& state, std::uint32_t time_boot_ms) {
  const auto psi = static_cast<float>(core::wrap_pi(state.motion.psi));
  return {time_boot_ms, 0, 0, psi, 0, 0, static_cast<float>(state.motion.nu.r)};
}

template <class S>
link::LocalPositionNed local_position_of(const OwnState<S>& state, std::uint32_t time_boot_ms) {
  const auto& motion = state.motion;
  const core::Vec2<S> v_n =
      core::to_north_east(motion.psi, core::Vec2<S>{motion.nu.u, motion.nu.v});
  return {time_boot_ms,
          static_cast<float>(state.north_m + double(motion.moved_n.x)),
          static_cast<float>(state.east_m + double(motion.moved_n.y)),
          0,
          static_cast<float>(v_n.x),
          static_cast<float>(v_n.y),
          0};
}

#define FLOTILLA_INSTANTIATE(S)                                                  \
  template core::Vec2<S> separation<S>(const Position&, const Position&);        \
  template core::ControllerParams<S> controller_params<S>(const Parameters&);    \
  template core::ThrustCurveParams<S> thrust_curve_params<S>(const Parameters&); \
  template link::Attitude attitude_of<S>(const OwnState<S>&, std::uint32_t);     \
  template link::LocalPositionNed local_position_of<S>(const OwnState<S>&, std::uint32_t);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app::convert
