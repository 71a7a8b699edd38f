// SPDX-License-Identifier: MIT
// The only place where units, frames and scalars change: the wire on one side, core on the other.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>

#include "app/convert/convert_scalar.hpp"
#include "app/convert/law.hpp"
#include "app/convert/times.hpp"
#include "core/drive.hpp"
#include "core/estimation/track.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app::convert {

/// A global position in MAVLink's units, and how far true north there is turned clockwise from the
/// north of the local frame that the point was computed in.
struct GlobalPoint {
  std::int32_t latitude, longitude;  ///< degE7
  double turn_rad = 0;
  bool operator==(const GlobalPoint&) const = default;
};

/// A vessel's state from one message or pair of messages: north-east from the sender's own origin,
/// or a global position; heading clockwise from north, velocity over ground in body axes.
template <class S>
struct Sample {
  std::int64_t stamp_us;  ///< sender's clock
  Metres north_m, east_m;
  S psi_rad;
  S u_mps, v_mps, r_radps;
  std::optional<GlobalPoint> at{};
};

enum class Refusal : std::uint8_t { kBadValue, kBadFrame };

/// A sample, or why there is none. Accepts ODOMETRY poses in NED or ENU, with any legal velocity
/// frame.
template <class S>
struct Reading {
  std::optional<Sample<S>> sample;
  Refusal refusal = Refusal::kBadValue;
};
template <class S = double>
Reading<S> sample_of(const link::Odometry& message);

/// Heading and its rate; nothing if a field is not finite or the vessel is upside down.
template <class S>
struct HeadingSample {
  std::int64_t stamp_us;
  S psi_rad;
  S r_radps;
};
template <class S = double>
std::optional<HeadingSample<S>> heading_of(const link::Attitude& message);

/// Position and velocity, joined with the heading extrapolated to the position's stamp.
template <class S>
std::optional<Sample<S>> sample_of(const link::LocalPositionNed& message,
                                   const HeadingSample<S>& heading);

template <class S>
std::optional<Sample<S>> sample_of(const link::GlobalPositionInt& message,
                                   const HeadingSample<S>& heading);

/// The same for FOLLOW_TARGET, whose position and velocity must be known, and its own heading if it
/// has one.
template <class S>
std::optional<Sample<S>> sample_of(const link::FollowTarget& message,
                                   const HeadingSample<S>& heading);
template <class S = double>
std::optional<HeadingSample<S>> own_heading_of(const link::FollowTarget& message);

/// A vessel that an AIS receiver reports: the report's age on arrival, and how far the hull reaches
/// from the position, m (0: unknown). Without a course or a speed the vessel counts as stationary.
/// Nothing if there is no fix. The vessel rests below 0.3 m/s, or below 3 kn at anchor, moored or
/// aground.
template <class S>
struct AisReport {
  Sample<S> sample;  ///< heading: the course
  std::int64_t age_us;
  S reach_m;
  bool rests = false;  ///< reports only every three minutes (ITU-R M.1371)
};
template <class S>
std::optional<AisReport<S>> ais_report_of(const link::AisVessel& message);

/// Position and velocity are known, and every field flagged as known is in range.
bool is_usable(const link::FollowTarget& message);

/// Moves a sample from the antenna, x_m ahead and y_m to starboard, to the reference point.
template <class S>
void move_to_reference_point(Sample<S>& antenna, S x_m, S y_m);

/// A vessel's position in metres from its own origin, and that origin.
struct Position {
  Metres north_m, east_m;
  link::GpsGlobalOrigin origin{};
};

/// A global sample as north-east from an origin, heading from that origin's north.
template <class S>
Sample<S> in_plane(const Sample<S>& sample, const link::GpsGlobalOrigin& origin);

/// Near enough for one local frame: within 100 km.
bool reaches(const link::GpsGlobalOrigin& origin, const GlobalPoint& at);

/// The global position of a point of the boat's local frame, whose origin must be known.
GlobalPoint global_of(const Position& position);

/// Rejects latitudes over 89°, longitudes over 180°, and 0, 0, which units without a fix send.
bool is_valid(const link::GpsGlobalOrigin& origin);

/// Greatest distance for one plane: five times the greatest FORM_OFS_N or FORM_OFS_E.
constexpr float kNear_m = 5000;

/// A greatest distance, and a side of a square that lies within it.
struct Reach {
  constexpr Reach(float within_m) : m(within_m), surely_m(0.7F * within_m) {}

  float m;
  Metres surely_m;
};
constexpr Reach kNear{kNear_m};
bool near(const Position& own, const Position& leader, const Reach& within = kNear);

/// Straight-line distance; infinity between opposite sides of the globe.
double distance_m(const Position& a, const Position& b);

/// Vector from the leader to us, m, north-east in the plane of our origin, and whether it is near.
/// Exact if both have the same origin; in Q16 limited to ±15 km.
template <class S>
struct Separation {
  core::Vec2<S> n{};
  bool near = false;
};
template <class S>
Separation<S> separation(const Position& own, const Position& leader);

/// Vector to a point at sea level, m, north-east in the plane of the position's origin, and whether
/// it is within `within_m`; zero if not.
template <class S>
Separation<S> way_to(const Position& from, const GlobalPoint& to, float within_m);

/// The law's input: two positions and the motions since, in the plane of our origin.
template <class S>
core::ControllerInput<S> controller_input_of(const Position& own, const core::Motion<S>& own_motion,
                                             const Position& leader,
                                             const core::Motion<S>& leader_motion);

/// Converts a script's velocities from double to the law's scalar.
template <class S>
core::Drive<S> drive_of(const core::Drive<double>& told) {
  core::Drive<S> out{scalar<S>(told.u), scalar<S>(told.r), {}};
  if (told.course) out.course = scalar<S>(*told.course);
  return out;
}

template <class S>
core::Nu<S> nu_of(const Sample<S>& sample) {
  return {sample.u_mps, sample.v_mps, sample.r_radps};
}

/// The last whole millisecond, as MAVLink counts it (wraps after 49 days) and in µs.
inline std::uint32_t boot_ms(std::int64_t us) { return static_cast<std::uint32_t>(us / 1000); }
inline std::int64_t us_of_ms(std::int64_t us) { return us / 1000 * 1000; }

/// The time nearest to `near_us` among those equal to `us` modulo 2³² ms.
inline std::int64_t unwrapped_us(std::int64_t us, std::int64_t near_us) {
  constexpr std::int64_t kTurn_us = (std::int64_t{1} << 32U) * 1000;
  if (std::abs(us - near_us) < kTurn_us / 2) return us;
  const std::int64_t off = (us - near_us) % kTurn_us;
  const std::int64_t least = off > kTurn_us / 2 ? off - kTurn_us : off;
  return near_us + (least < -kTurn_us / 2 ? least + kTurn_us : least);
}

/// Command in RawCommand counts, rounded, saturated at ±kRawFull; NaN gives 0.
template <class S>
std::int16_t raw_of(S command) {
  if (!(command <= S(kRawFull)) && !(command > S(kRawFull))) return 0;
  const S counts = core::clamp(command, S(-kRawFull), S(kRawFull));
  return static_cast<std::int16_t>(whole(counts < S(0) ? counts - S(0.5) : counts + S(0.5)));
}

}  // namespace flotilla::app::convert
