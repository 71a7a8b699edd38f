// SPDX-License-Identifier: MIT
// The only place where a unit, a frame or a scalar changes: wire on one side, core on the other.
#pragma once

#include <cstdint>
#include <optional>

#include "app/parameters.hpp"
#include "core/controller.hpp"
#include "core/dead_reckoning.hpp"
#include "core/thrust_curve.hpp"
#include "core/track.hpp"
#include "link/messages.hpp"

namespace flotilla::app::convert {

/// A vessel's state as one message or pair of messages gave it: north-east from the sender's own
/// origin, heading clockwise from north, velocity over ground in the vessel's axes.
struct Sample {
  std::int64_t stamp_us;  ///< sender's clock
  double north_m, east_m;
  double psi_rad;
  double u_mps, v_mps, r_radps;
};

/// Why a message is not taken.
enum class Refusal : std::uint8_t { kBadValue, kBadFrame };

/// A sample, or why there is none. ODOMETRY: any pose in NED or ENU with any legal velocity frame.
struct Reading {
  std::optional<Sample> sample;
  Refusal refusal = Refusal::kBadValue;
};
Reading sample_of(const link::Odometry& message);

/// Heading and its rate of change; nothing where a field is not finite or the vessel is upside
/// down.
struct HeadingSample {
  std::int64_t stamp_us;
  double psi_rad;
  double r_radps;
};
std::optional<HeadingSample> heading_of(const link::Attitude& message);

/// Position and velocity joined with the heading carried over to the position's stamp.
std::optional<Sample> sample_of(const link::LocalPositionNed& message,
                                const HeadingSample& heading);

/// From the navigation antenna, x_m ahead and y_m to starboard, to the vessel's reference point.
Sample at_reference_point(const Sample& antenna, double x_m, double y_m);

/// Where a vessel is: metres from its own origin, and that origin.
struct Position {
  double north_m = 0, east_m = 0;
  link::GpsGlobalOrigin origin{};
};

/// Not off the globe, too near a pole, or 0, 0, which is what units without a fix say.
bool is_valid(const link::GpsGlobalOrigin& origin);

/// Near enough for a slot: within 5 km, five times the farthest.
bool near(const Position& own, const Position& leader);

/// From the leader to us, north-east, m; origins are differenced as integers, metres as doubles.
template <class S>
core::Vec2<S> separation(const Position& own, const Position& leader);

template <class S>
core::Nu<S> nu_of(const Sample& sample) {
  return {S(sample.u_mps), S(sample.v_mps), S(sample.r_radps)};
}

template <class S>
S seconds(std::int64_t us) {
  return S(static_cast<double>(us) * 1e-6);
}

/// µs; 0 for a rate of 0.
inline std::int64_t period_us(float rate_Hz) {
  return rate_Hz > 0.0F ? static_cast<std::int64_t>(1e6 / double{rate_Hz} + 0.5) : 0;
}
inline std::int64_t half_period_us(float rate_Hz) { return period_us(rate_Hz) / 2; }

/// The whole millisecond that has begun, as MAVLink counts it (wraps after 49 days) and in µs.
inline std::uint32_t boot_ms(std::int64_t us) { return static_cast<std::uint32_t>(us / 1000); }
inline std::int64_t us_of_ms(std::int64_t us) { return us / 1000 * 1000; }

/// A time that is known modulo 2³² ms, near another one.
inline std::int64_t unwrapped_us(std::int64_t us, std::int64_t near_us) {
  constexpr std::int64_t kTurn_us = (std::int64_t{1} << 32U) * 1000;
  const std::int64_t off = (us - near_us) % kTurn_us;
  const std::int64_t least = off > kTurn_us / 2 ? off - kTurn_us : off;
  return near_us + (least < -kTurn_us / 2 ? least + kTurn_us : least);
}

inline std::int64_t microseconds(float s) { return static_cast<std::int64_t>(double{s} * 1e6); }

/// Parameters in the law's own terms.
template <class S>
core::ControllerParams<S> controller_params(const Parameters& p);
template <class S>
core::ThrustCurveParams<S> thrust_curve_params(const Parameters& p);

/// Command in [−1, 1] to RawCommand's ±8191 (AM32 and VESC divide by 8192), and back. NaN, which
/// is no command, is zero.
template <class S>
std::int16_t raw_of(S command) {
  if (!(command <= S(1)) && !(command > S(1))) return 0;
  const S scaled = core::clamp(command, S(-1), S(1)) * S(8191);
  return static_cast<std::int16_t>(
      static_cast<int>(scaled < S(0) ? scaled - S(0.5) : scaled + S(0.5)));
}
template <class S>
S command_of(std::int16_t raw) {
  return S(raw) / S(8191);
}

/// The own state for followers, at a whole millisecond of our clock.
template <class S>
struct OwnState {
  double north_m, east_m;
  core::Motion<S> motion;
};
template <class S>
link::Attitude attitude_of(const OwnState<S>& state, std::uint32_t time_boot_ms);
template <class S>
link::LocalPositionNed local_position_of(const OwnState<S>& state, std::uint32_t time_boot_ms);

}  // namespace flotilla::app::convert
