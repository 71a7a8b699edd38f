// SPDX-License-Identifier: MIT
// Outgoing conversion: the boat's state in the wire's units and frames.
#pragma once

#include <cstdint>
#include <optional>

#include "app/convert/convert.hpp"
#include "app/parameters/configuration.hpp"
#include "link/dronecan/messages.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app::convert {

/// The law's numbers in double, telemetry's only scalar.
template <class S>
core::Nu<double> in_double(const core::Nu<S>& nu) {
  return {number(nu.u), number(nu.v), number(nu.r)};
}
template <class S>
core::Tau<double> in_double(const core::Tau<S>& tau) {
  return {number(tau.X), number(tau.N)};
}
template <class S>
core::Error<double> in_double(const core::Error<S>& e) {
  return {number(e.x), number(e.y), number(e.psi)};
}
template <class S>
core::TooFast<double> in_double(const core::TooFast<S>& needs) {
  return {number(needs.u), number(needs.r)};
}

/// The boat's state for its followers, at a whole millisecond of our clock.
struct OwnState {
  double north_m, east_m;
  double psi_rad;                  ///< in (−π, π]
  core::Nu<double> nu;             ///< over ground, in body axes
  core::Vec2<double> v_n;          ///< the same, north-east
  core::Nu<double> nu_dot;         ///< rate of change of nu's components
  link::GpsGlobalOrigin origin{};  ///< of north_m and east_m; global messages need it
};
template <class S>
OwnState own_state_of(const Position& from, const core::Motion<S>& motion);

link::Attitude attitude_of(const OwnState& state, std::uint32_t time_boot_ms);
link::LocalPositionNed local_position_of(const OwnState& state, std::uint32_t time_boot_ms);
link::GlobalPositionInt global_position_of(const OwnState& state, std::uint32_t time_boot_ms);
link::FollowTarget follow_target_of(const OwnState& state, std::uint64_t timestamp_ms);

/// Throttle: thrust of both propellers, ahead or astern, in percent of what they give ahead.
link::VfrHud vfr_hud_of(const OwnState& state, const core::Thrust<double>& thrust_N, double most_N);

/// LOCAL_NED, velocity in BODY_FRD. Sent only on request: an autopilot that hears it would take it
/// for its own external vision.
link::Odometry odometry_of(const OwnState& state, std::uint32_t time_boot_ms);

/// Bearing and distance to the slot, and the error abeam. `error` is the law's (e_x, e_y, e_ψ).
link::NavControllerOutput nav_controller_output_of(const OwnState& state,
                                                   const core::Error<double>& error);

/// The slot's position from the boat's origin, and the slot's heading.
link::PositionTargetLocalNed slot_of(const OwnState& state, const core::Error<double>& error,
                                     std::uint32_t time_boot_ms);

/// The battery as measured by the two ESCs: the lower voltage, the sum of both currents.
link::BatteryStatus battery_of(const std::optional<link::EscStatus>& port,
                               const std::optional<link::EscStatus>& stbd);

/// INT16_MAX (unknown) if the value is no plausible temperature.
std::int16_t centidegrees_of_kelvin(float kelvin);

/// The thrust is below THR_DEAD, so the propeller does not turn. share: of the greatest thrust.
bool is_dead(double share, const Configuration::Propulsion& propulsion);

/// A stick's −1000 … 1000 as −1 … 1; nothing for an unused axis or one out of range.
std::optional<double> stick_of(std::int16_t axis);

}  // namespace flotilla::app::convert
