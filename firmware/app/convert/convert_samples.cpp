// SPDX-License-Identifier: MIT
// Converts received MAVLink state messages to samples.
#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>

#include "app/convert/convert.hpp"

namespace flotilla::app::convert {
namespace {

constexpr float kFarthest_m = 1e6F, kFastest_mps = 50, kFastestTurn_radps = 20, kMaxTurns_rad = 10;
constexpr int kCentimetres = 100;
constexpr std::int64_t kMicrosecondsPerMillisecond = 1000;

template <class S>
struct Vec3 {
  S x, y, z;
};

/// Compares bits: magnitudes order like unsigned integers, and NaN is above them all.
bool within(float limit, auto... values) {
  const auto bits = [](float x) { return std::bit_cast<std::uint32_t>(x) & 0x7FFF'FFFFU; };
  return ((bits(values) <= bits(limit)) && ...);
}

/// Rotates from body axes to the frame, by a unit quaternion (w x y z).
template <class S>
Vec3<S> rotate(const std::array<S, 4>& q, const Vec3<S>& v) {
  const auto& [w, x, y, z] = q;
  const S one = S(1), two = S(2);
  return {(one - two * (y * y + z * z)) * v.x + two * (x * y - w * z) * v.y +
              two * (x * z + w * y) * v.z,
          two * (x * y + w * z) * v.x + (one - two * (x * x + z * z)) * v.y +
              two * (y * z - w * x) * v.z,
          two * (x * z - w * y) * v.x + two * (y * z + w * x) * v.y +
              (one - two * (x * x + y * y)) * v.z};
}

/// ψ̇ from body rates and attitude (Fossen 2011, eq. 2.26); nothing near the vertical.
template <class S>
std::optional<S> heading_rate(S roll, S pitch, S q, S r) {
  const S c = core::cos(pitch);
  const auto [s_roll, c_roll] = core::sin_cos(roll);
  if (c < S(0.1) || c_roll < S(0.1)) return std::nullopt;
  return core::sum_of_products(q, s_roll, r, c_roll) / c;
}

/// A vector of the message's frame in north-east-down.
template <class S>
Vec3<S> ned_of(bool enu, const Vec3<S>& v) {
  return enu ? Vec3<S>{v.y, v.x, -v.z} : v;
}

/// Heading and its rate, from the attitude in the message's frame.
template <class S>
struct Turning {
  S psi_rad, r_radps;
};
template <class S>
std::optional<Turning<S>> turning_of(bool enu, const std::array<S, 4>& q, float pitchspeed,
                                     float yawspeed) {
  const auto axis = [&](const Vec3<S>& b) { return ned_of(enu, rotate(q, b)); };
  const Vec3<S> ahead = axis({S(1), S(0), S(0)});
  const S pitch = core::atan2(-ahead.z, core::hypot(ahead.x, ahead.y));
  const S roll = core::atan2(axis({S(0), S(1), S(0)}).z, axis({S(0), S(0), S(1)}).z);
  const auto r = heading_rate(roll, pitch, scalar<S>(pitchspeed), scalar<S>(yawspeed));
  if (!r) return std::nullopt;
  return Turning<S>{core::atan2(ahead.y, ahead.x), *r};
}

/// The quaternion scaled to unit length; nothing if it is too short, too long or not finite.
template <class S>
std::optional<std::array<S, 4>> normalised(const std::array<float, 4>& wire) {
  if (!within(10, wire[0], wire[1], wire[2], wire[3])) return std::nullopt;
  std::array<S, 4> q{scalar<S>(wire[0]), scalar<S>(wire[1]), scalar<S>(wire[2]),
                     scalar<S>(wire[3])};
  const S norm = core::hypot(core::hypot(q[0], q[1]), core::hypot(q[2], q[3]));
  if (!(norm > S(0.1) && norm < S(10))) return std::nullopt;
  for (S& component : q) component = component / norm;
  return q;
}

template <class S>
void set_velocity_n(Sample<S>& sample, S north_mps, S east_mps) {
  const core::Vec2<S> v = core::to_body(sample.psi_rad, core::Vec2<S>{north_mps, east_mps});
  sample.u_mps = v.x;
  sample.v_mps = v.y;
}

/// Rejects latitudes over 89°, longitudes over 180°, and 0, 0, which units without a fix send.
bool is_fix(std::int32_t latitude, std::int32_t longitude) {
  const bool no_fix = latitude == 0 && longitude == 0;
  return !no_fix && std::abs(std::int64_t{latitude}) <= 890'000'000 &&
         std::abs(std::int64_t{longitude}) <= 1'800'000'000;
}

std::int64_t follow_stamp_us(const link::FollowTarget& m) {
  return static_cast<std::int64_t>(m.timestamp) * kMicrosecondsPerMillisecond;
}

/// The heading, extrapolated to a stamp of the same clock.
template <class S>
Sample<S> joined(const HeadingSample<S>& heading, std::int64_t time_us) {
  const std::int64_t stamp_us = unwrapped_us(time_us, heading.stamp_us);
  // A heading more than a second away is of no use: extrapolate no further.
  constexpr std::int64_t kLongest_us = 1'000'000;
  const std::int64_t later_us = std::clamp(stamp_us - heading.stamp_us, -kLongest_us, kLongest_us);
  const S psi = heading.psi_rad + heading.r_radps * seconds<S>(later_us);
  return {stamp_us, 0, 0, psi, S(0), S(0), heading.r_radps};
}

constexpr int kFastestShip_cmps = static_cast<int>(kFastest_mps) * 100;

/// A vessel that reports itself at anchor, moored or aground counts as at rest up to 3 kn, as in
/// ITU-R M.1371. Above that its status is outdated. One of unknown speed counts as at rest.
bool rests(const link::AisVessel& m) {
  namespace mav = link::mav;
  constexpr int kStill_cmps = 30, kDrifts_cmps = 154;
  const std::uint8_t status = m.navigational_status;
  const bool told =
      status == mav::kAisAnchored || status == mav::kAisMoored || status == mav::kAisAground;
  if ((m.flags & mav::kAisSpeed) == 0 || m.velocity > kFastestShip_cmps) return true;
  return m.velocity < (told ? kDrifts_cmps : kStill_cmps);
}

}  // namespace

template <class S>
Reading<S> sample_of(const link::Odometry& m) {
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
  if (m.quality < 0 || !within(kFarthest_m, m.x, m.y, m.z) ||
      !within(kFastest_mps, m.vx, m.vy, m.vz) ||
      !within(kFastestTurn_radps, m.rollspeed, m.pitchspeed, m.yawspeed) ||
      m.time_usec > INT64_MAX / 4) {
    return {};
  }
  const auto q = normalised<S>(m.q);
  if (!q) return {};
  const auto turning = turning_of(enu, *q, m.pitchspeed, m.yawspeed);
  if (!turning) return {};
  const Vec3<S> wire{scalar<S>(m.vx), scalar<S>(m.vy), scalar<S>(m.vz)};
  const Vec3<S> velocity = velocity_b ? ned_of(enu, rotate(*q, wire)) : ned_of(velocity_enu, wire);
  Sample<S> sample{static_cast<std::int64_t>(m.time_usec),
                   enu ? m.y : m.x,
                   enu ? m.x : m.y,
                   turning->psi_rad,
                   S(0),
                   S(0),
                   turning->r_radps};
  set_velocity_n(sample, velocity.x, velocity.y);
  return {sample, {}};
}

template <class S>
std::optional<HeadingSample<S>> heading_of(const link::Attitude& m) {
  if (!within(kMaxTurns_rad, m.roll, m.pitch, m.yaw) ||
      !within(kFastestTurn_radps, m.rollspeed, m.pitchspeed, m.yawspeed)) {
    return std::nullopt;
  }
  const auto r = heading_rate(scalar<S>(m.roll), scalar<S>(m.pitch), scalar<S>(m.pitchspeed),
                              scalar<S>(m.yawspeed));
  if (!r) return std::nullopt;
  return HeadingSample<S>{m.time_boot_ms * kMicrosecondsPerMillisecond, scalar<S>(m.yaw), *r};
}

template <class S>
std::optional<Sample<S>> sample_of(const link::LocalPositionNed& m,
                                   const HeadingSample<S>& heading) {
  if (!within(kFarthest_m, m.x, m.y, m.z) || !within(kFastest_mps, m.vx, m.vy, m.vz)) {
    return std::nullopt;
  }
  Sample<S> sample = joined(heading, m.time_boot_ms * kMicrosecondsPerMillisecond);
  sample.north_m = m.x;
  sample.east_m = m.y;
  set_velocity_n(sample, scalar<S>(m.vx), scalar<S>(m.vy));
  return sample;
}

template <class S>
std::optional<Sample<S>> sample_of(const link::GlobalPositionInt& m,
                                   const HeadingSample<S>& heading) {
  constexpr float kFastest_cmps = kFastest_mps * kCentimetres;
  if (!is_fix(m.lat, m.lon) || !within(kFastest_cmps, float(m.vx), float(m.vy))) {
    return std::nullopt;
  }
  Sample<S> sample = joined(heading, m.time_boot_ms * kMicrosecondsPerMillisecond);
  sample.at = {m.lat, m.lon};
  set_velocity_n(sample, S(int{m.vx}) / S(kCentimetres), S(int{m.vy}) / S(kCentimetres));
  return sample;
}

bool is_usable(const link::FollowTarget& m) {
  namespace mav = link::mav;
  constexpr std::uint8_t kNeeded = mav::kFollowPosition | mav::kFollowVelocity;
  constexpr std::uint64_t kLatest_ms = INT64_MAX / 4 / kMicrosecondsPerMillisecond;
  const bool attitude = (m.est_capabilities & mav::kFollowAttitude) != 0;
  return (m.est_capabilities & kNeeded) == kNeeded && is_fix(m.lat, m.lon) &&
         within(kFastest_mps, m.vel[0], m.vel[1], m.vel[2]) && m.timestamp <= kLatest_ms &&
         (!attitude ||
          (within(10, m.attitude_q[0], m.attitude_q[1], m.attitude_q[2], m.attitude_q[3]) &&
           within(kFastestTurn_radps, m.rates[0], m.rates[1], m.rates[2])));
}

template <class S>
std::optional<HeadingSample<S>> own_heading_of(const link::FollowTarget& m) {
  if ((m.est_capabilities & link::mav::kFollowAttitude) == 0 ||
      !within(kFastestTurn_radps, m.rates[0], m.rates[1], m.rates[2])) {
    return std::nullopt;
  }
  const auto q = normalised<S>(m.attitude_q);
  if (!q) return std::nullopt;
  const auto turning = turning_of(false, *q, m.rates[1], m.rates[2]);
  if (!turning) return std::nullopt;
  return HeadingSample<S>{follow_stamp_us(m), turning->psi_rad, turning->r_radps};
}

template <class S>
std::optional<Sample<S>> sample_of(const link::FollowTarget& m, const HeadingSample<S>& heading) {
  if (!is_usable(m)) return std::nullopt;
  Sample<S> sample = joined(heading, follow_stamp_us(m));
  sample.at = {m.lat, m.lon};
  set_velocity_n(sample, scalar<S>(m.vel[0]), scalar<S>(m.vel[1]));
  return sample;
}

template <class S>
std::optional<AisReport<S>> ais_report_of(const link::AisVessel& m) {
  namespace mav = link::mav;
  constexpr int kFullTurn_cdeg = 36'000;
  constexpr std::uint16_t kMoves = mav::kAisCourse | mav::kAisSpeed;
  if (!is_fix(m.lat, m.lon)) return std::nullopt;
  // Receivers also report a course of 360 deg or a speed of 102.3 kn for "not available".
  const bool moves = (m.flags & (kMoves | mav::kAisFast)) == kMoves && m.COG < kFullTurn_cdeg &&
                     m.velocity <= kFastestShip_cmps;
  // tslc counts whole seconds, rounded down: adds one.
  AisReport<S> out{{}, (std::int64_t{m.tslc} + 1) * 1'000'000, S(0), rests(m)};
  out.sample.at = {m.lat, m.lon};
  if (moves) {
    constexpr float kPerCdeg_rad = 2 * 3.14159265358979F / kFullTurn_cdeg;
    out.sample.psi_rad = scalar<S>(kPerCdeg_rad * static_cast<float>(m.COG));
    out.sample.u_mps = S(int{m.velocity}) / S(kCentimetres);
  }
  if ((m.flags & mav::kAisDimensions) != 0) {
    // The greatest lengths and widths that AIS can report.
    const auto far = [](int a, int b, int most) { return S(std::min(std::max(a, b), most)); };
    out.reach_m = core::hypot(far(m.dimension_bow, m.dimension_stern, 511),
                              far(m.dimension_port, m.dimension_starboard, 63));
  }
  return out;
}

template <class S>
void move_to_reference_point(Sample<S>& antenna, S x, S y) {
  if (x == S(0) && y == S(0)) return;
  const S r = antenna.r_radps;
  antenna.u_mps = antenna.u_mps + r * y;  // v_reference = v_antenna − ω × offset
  antenna.v_mps = antenna.v_mps - r * x;
  const core::Vec2<S> offset_n = core::to_north_east(antenna.psi_rad, core::Vec2<S>{x, y});
  antenna.north_m = antenna.north_m - offset_n.x;
  antenna.east_m = antenna.east_m - offset_n.y;
}

bool is_valid(const link::GpsGlobalOrigin& o) { return is_fix(o.latitude, o.longitude); }

#define FLOTILLA_INSTANTIATE(S)                                                          \
  template Reading<S> sample_of<S>(const link::Odometry&);                               \
  template std::optional<HeadingSample<S>> heading_of<S>(const link::Attitude&);         \
  template std::optional<Sample<S>> sample_of<S>(const link::LocalPositionNed&,          \
                                                 const HeadingSample<S>&);               \
  template std::optional<Sample<S>> sample_of<S>(const link::GlobalPositionInt&,         \
                                                 const HeadingSample<S>&);               \
  template std::optional<Sample<S>> sample_of<S>(const link::FollowTarget&,              \
                                                 const HeadingSample<S>&);               \
  template std::optional<HeadingSample<S>> own_heading_of<S>(const link::FollowTarget&); \
  template std::optional<AisReport<S>> ais_report_of<S>(const link::AisVessel&);         \
  template void move_to_reference_point<S>(Sample<S>&, S, S);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
FLOTILLA_INSTANTIATE(core::Q16)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app::convert
