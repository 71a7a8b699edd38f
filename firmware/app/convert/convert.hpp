// SPDX-License-Identifier: MIT
// The only place where a unit, a frame or a scalar changes: wire on one side, core on the other.
#pragma once

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include "app/convert/convert_scalar.hpp"
#include "app/parameters.hpp"
#include "core/controller.hpp"
#include "core/estimation/observer.hpp"
#include "core/estimation/plausibility.hpp"
#include "core/estimation/track.hpp"
#include "core/station.hpp"
#include "core/thrust_curve.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app::convert {

/// Degrees, as MAVLink counts them, and how far the true north there is turned clockwise from the
/// north of the local frame that the point was taken from.
struct GlobalPoint {
  std::int32_t latitude, longitude;  ///< degE7
  double turn_rad = 0;
};

/// A vessel's state as one message or pair of messages gave it: north-east from the sender's own
/// origin, or from a point of the globe; heading clockwise from north, velocity over ground in the
/// vessel's axes.
template <class S>
struct Sample {
  std::int64_t stamp_us;  ///< sender's clock
  Metres north_m, east_m;
  S psi_rad;
  S u_mps, v_mps, r_radps;
  std::optional<GlobalPoint> at{};
};

/// Why a message is not taken.
enum class Refusal : std::uint8_t { kBadValue, kBadFrame };

/// A sample, or why there is none. ODOMETRY: any pose in NED or ENU with any legal velocity frame.
template <class S>
struct Reading {
  std::optional<Sample<S>> sample;
  Refusal refusal = Refusal::kBadValue;
};
template <class S = double>
Reading<S> sample_of(const link::Odometry& message);

/// Heading and its rate of change; nothing where a field is not finite or the vessel is upside
/// down.
template <class S>
struct HeadingSample {
  std::int64_t stamp_us;
  S psi_rad;
  S r_radps;
};
template <class S = double>
std::optional<HeadingSample<S>> heading_of(const link::Attitude& message);

/// Position and velocity joined with the heading carried over to the position's stamp.
template <class S>
std::optional<Sample<S>> sample_of(const link::LocalPositionNed& message,
                                   const HeadingSample<S>& heading);

template <class S>
std::optional<Sample<S>> sample_of(const link::GlobalPositionInt& message,
                                   const HeadingSample<S>& heading);

/// The same of FOLLOW_TARGET, whose position and velocity must be known; its own heading, where it
/// has one.
template <class S>
std::optional<Sample<S>> sample_of(const link::FollowTarget& message,
                                   const HeadingSample<S>& heading);
template <class S = double>
std::optional<HeadingSample<S>> own_heading_of(const link::FollowTarget& message);

/// Its position and velocity are known, and all that is said to be known can be.
bool is_usable(const link::FollowTarget& message);

/// From the navigation antenna, x_m ahead and y_m to starboard, to the vessel's reference point.
template <class S>
Sample<S> at_reference_point(const Sample<S>& antenna, S x_m, S y_m);

/// Where a vessel is: metres from its own origin, and that origin.
struct Position {
  Metres north_m, east_m;
  link::GpsGlobalOrigin origin{};
};

/// A state at a point of the globe, north-east from an origin, heading from that origin's north.
template <class S>
Sample<S> in_plane(const Sample<S>& sample, const link::GpsGlobalOrigin& origin);

/// Near enough for one local frame: 100 km.
bool reaches(const link::GpsGlobalOrigin& origin, const GlobalPoint& at);

/// Of a point of the own local frame, whose origin must be known.
GlobalPoint global_of(const Position& position);

/// Not off the globe, too near a pole, or 0, 0, which is what units without a fix say.
bool is_valid(const link::GpsGlobalOrigin& origin);

/// Near enough for a slot: within 5 km, five times the farthest.
bool near(const Position& own, const Position& leader);

/// Straight from one to the other.
double distance_m(const Position& a, const Position& b);

/// From the leader to us, m, north-east in the plane of our origin, and whether that is near; of two
/// places with one origin exactly.
template <class S>
struct Separation {
  core::Vec2<S> n;
  bool near;
};
template <class S>
Separation<S> separation(const Position& own, const Position& leader);

/// What the law sees: two positions and the motions since, in the plane of our origin.
template <class S>
core::ControllerInput<S> controller_input_of(const Position& own, const core::Motion<S>& own_motion,
                                             const Position& leader,
                                             const core::Motion<S>& leader_motion);

template <class S>
core::Nu<S> nu_of(const Sample<S>& sample) {
  return {sample.u_mps, sample.v_mps, sample.r_radps};
}

/// µs, at most an hour; 0 for a rate of 0.
inline std::int64_t period_us(float rate_Hz) {
  if (!(rate_Hz > 0.0F)) return 0;
  const double us = 1e6 / double{rate_Hz} + 0.5;
  return static_cast<std::int64_t>(us < 3.6e9 ? us : 3.6e9);
}
inline std::int64_t half_period_us(float rate_Hz) { return period_us(rate_Hz) / 2; }

/// The whole millisecond that has begun, as MAVLink counts it (wraps after 49 days) and in µs.
inline std::uint32_t boot_ms(std::int64_t us) { return static_cast<std::uint32_t>(us / 1000); }
inline std::int64_t us_of_ms(std::int64_t us) { return us / 1000 * 1000; }

/// A time that is known modulo 2³² ms, near another one.
inline std::int64_t unwrapped_us(std::int64_t us, std::int64_t near_us) {
  constexpr std::int64_t kTurn_us = (std::int64_t{1} << 32U) * 1000;
  if (std::abs(us - near_us) < kTurn_us / 2) return us;
  const std::int64_t off = (us - near_us) % kTurn_us;
  const std::int64_t least = off > kTurn_us / 2 ? off - kTurn_us : off;
  return near_us + (least < -kTurn_us / 2 ? least + kTurn_us : least);
}

/// The whole microseconds of a time that is not negative, at most 2²³ s; by the bits alone, since it
/// is asked in every tick.
inline std::int64_t microseconds(float s) {
  constexpr unsigned kFraction = 23, kBias = 127;
  const auto bits = std::bit_cast<std::uint32_t>(s);
  const unsigned right = kBias + kFraction - (bits >> kFraction);  // of the point
  if (right > 63) return 0;                                        // no normal number
  const std::uint64_t units = (bits & ((1U << kFraction) - 1)) | 1U << kFraction;
  return static_cast<std::int64_t>(units * 1'000'000U >> right);
}

/// Parameters in the law's own terms.
template <class S>
core::ControllerParams<S> controller_params(const Parameters& p);
template <class S>
core::StationParams<S> station_params(const Parameters& p);
template <class S>
core::ObserverParams<S> observer_params(const Parameters& p);
template <class S>
core::ThrustCurveParams<S> thrust_curve_params(const Parameters& p);

/// What the boat can do by its propellers and by the water; carried: by hand, or on a trailer.
template <class S>
core::PlausibilityLimits<S> plausibility_limits(const Parameters& p, bool carried);

/// A command of all that a propeller gives, in RawCommand (AM32 and VESC divide by 8192).
constexpr int kRawFull = 8191;

/// Command in RawCommand's counts, rounded and within ±kRawFull. NaN, which is no command, is zero.
template <class S>
std::int16_t raw_of(S command) {
  if (!(command <= S(kRawFull)) && !(command > S(kRawFull))) return 0;
  const S counts = core::clamp(command, S(-kRawFull), S(kRawFull));
  return static_cast<std::int16_t>(whole(counts < S(0) ? counts - S(0.5) : counts + S(0.5)));
}

}  // namespace flotilla::app::convert
