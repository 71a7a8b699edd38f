// SPDX-License-Identifier: MIT
#include "app/convert/convert_telemetry.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/convert/portable.hpp"

namespace flotilla::app::convert {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

struct Slot {
  double north_m, east_m;   ///< from the boat's origin
  core::Vec2<double> to_n;  ///< from the boat to the slot
};

core::Vec2<double> rotated(double rad, const core::Vec2<double>& v) {
  const auto [s, c] = portable::sin_cos(rad);
  return {c * v.x - s * v.y, s * v.x + c * v.y};
}

std::int16_t cm_per_s(double mps) {
  return static_cast<std::int16_t>(portable::nearest(100 * std::clamp(mps, -300.0, 300.0)));
}

/// e is the boat's position relative to the slot, in body axes.
Slot slot_from(const OwnState& state, const core::Error<double>& e) {
  const auto e_n = rotated(state.psi_rad, {e.x, e.y});
  return {state.north_m - e_n.x, state.east_m - e_n.y, {-e_n.x, -e_n.y}};
}

std::int16_t degrees(double rad) {
  return static_cast<std::int16_t>(portable::nearest(portable::wrap_pi(rad) * kDegreesPerRadian));
}

}  // namespace

template <class S>
OwnState own_state_of(const Position& from, const core::Motion<S>& motion) {
  const auto& [moved_n, psi, nu, nu_dot] = motion;
  const core::Vec2<S> v_n = core::to_north_east(psi, core::Vec2<S>{nu.u, nu.v});
  return {number(from.north_m + moved_n.x),
          number(from.east_m + moved_n.y),
          number(core::wrap_pi(psi)),
          in_double(nu),
          {number(v_n.x), number(v_n.y)},
          in_double(nu_dot),
          from.origin};
}

link::Attitude attitude_of(const OwnState& state, std::uint32_t time_boot_ms) {
  return {
      time_boot_ms, 0, 0, static_cast<float>(state.psi_rad), 0, 0, static_cast<float>(state.nu.r)};
}

link::LocalPositionNed local_position_of(const OwnState& state, std::uint32_t time_boot_ms) {
  return {time_boot_ms,
          static_cast<float>(state.north_m),
          static_cast<float>(state.east_m),
          0,
          static_cast<float>(state.v_n.x),
          static_cast<float>(state.v_n.y),
          0};
}

link::GlobalPositionInt global_position_of(const OwnState& state, std::uint32_t time_boot_ms) {
  const GlobalPoint at = global_of({state.north_m, state.east_m, state.origin});
  const auto v_n = rotated(-at.turn_rad, state.v_n);
  const double turn_cdeg = 18'000 / portable::kPi * (state.psi_rad - at.turn_rad);
  const auto hdg = static_cast<std::uint16_t>((portable::nearest(turn_cdeg) + 72'000) % 36'000);
  return {time_boot_ms,    at.latitude, at.longitude, state.origin.altitude, 0, cm_per_s(v_n.x),
          cm_per_s(v_n.y), 0,           hdg};
}

link::VfrHud vfr_hud_of(const OwnState& state, const core::Thrust<double>& thrust_N,
                        double most_N) {
  constexpr double kWhole = 100;
  const GlobalPoint at = global_of({state.north_m, state.east_m, state.origin});
  const double turn_deg = kDegreesPerRadian * (state.psi_rad - at.turn_rad);
  const double both_N = std::abs(thrust_N.port) + std::abs(thrust_N.stbd);
  const double share = most_N > 0 ? both_N / (2 * most_N) : 0;
  return {static_cast<float>(portable::hypot(state.v_n.x, state.v_n.y)),
          static_cast<float>(state.origin.altitude * 1e-3),
          static_cast<std::int16_t>((portable::nearest(turn_deg) + 720) % 360),
          static_cast<std::uint16_t>(portable::nearest(kWhole * std::min(share, 1.0)))};
}

link::FollowTarget follow_target_of(const OwnState& state, std::uint64_t timestamp_ms) {
  namespace mav = link::mav;
  const GlobalPoint at = global_of({state.north_m, state.east_m, state.origin});
  const double psi_n = portable::wrap_pi(state.psi_rad - at.turn_rad);
  const auto& nu = state.nu;
  const auto v_n = rotated(-at.turn_rad, state.v_n);
  const auto a_n = rotated(psi_n, {state.nu_dot.u - nu.r * nu.v, state.nu_dot.v + nu.r * nu.u});
  const auto [s, c] = portable::sin_cos(0.5 * psi_n);
  const auto f = [](double value) { return static_cast<float>(value); };
  return {timestamp_ms,
          at.latitude,
          at.longitude,
          static_cast<float>(state.origin.altitude * 1e-3),
          {f(v_n.x), f(v_n.y), 0},
          {f(a_n.x), f(a_n.y), 0},
          {f(c), 0, 0, f(s)},
          {0, 0, f(nu.r)},
          mav::kFollowPosition | mav::kFollowVelocity | mav::kFollowAcceleration |
              mav::kFollowAttitude};
}

link::Odometry odometry_of(const OwnState& state, std::uint32_t time_boot_ms) {
  const link::LocalPositionNed at = local_position_of(state, time_boot_ms);
  const auto [s, c] = portable::sin_cos(0.5 * state.psi_rad);
  const auto& nu = state.nu;
  return {std::uint64_t{time_boot_ms} * 1000,
          at.x,
          at.y,
          0,
          {static_cast<float>(c), 0, 0, static_cast<float>(s)},
          static_cast<float>(nu.u),
          static_cast<float>(nu.v),
          0,
          0,
          0,
          static_cast<float>(nu.r),
          link::mav::kFrameLocalNed,
          link::mav::kFrameBodyFrd,
          0,
          0,
          {std::numeric_limits<float>::quiet_NaN()}};  // unknown
}

link::NavControllerOutput nav_controller_output_of(const OwnState& state,
                                                   const core::Error<double>& error) {
  const core::Vec2<double> to = slot_from(state, error).to_n;
  const double distance_m = std::min(portable::hypot(to.x, to.y), 65535.0);
  return {degrees(state.psi_rad - error.psi), degrees(portable::atan2(to.y, to.x)),
          static_cast<std::uint16_t>(portable::nearest(distance_m)), static_cast<float>(error.y)};
}

link::PositionTargetLocalNed slot_of(const OwnState& state, const core::Error<double>& error,
                                     std::uint32_t time_boot_ms) {
  constexpr std::uint16_t kNotVelocity = 8 | 16 | 32, kNotAcceleration = 64 | 128 | 256,
                          kNotYawRate = 2048;
  const Slot slot = slot_from(state, error);
  link::PositionTargetLocalNed out{};
  out.time_boot_ms = time_boot_ms;
  out.coordinate_frame = link::mav::kFrameLocalNed;
  out.type_mask = kNotVelocity | kNotAcceleration | kNotYawRate;
  out.x = static_cast<float>(slot.north_m);
  out.y = static_cast<float>(slot.east_m);
  out.yaw = static_cast<float>(portable::wrap_pi(state.psi_rad - error.psi));
  return out;
}

link::BatteryStatus battery_of(const std::optional<link::EscStatus>& port,
                               const std::optional<link::EscStatus>& stbd) {
  link::BatteryStatus out{};
  out.voltages.fill(UINT16_MAX);  // cell voltages unknown; the first holds the total
  out.current_battery = -1;
  double current_A = 0;
  int currents = 0;
  for (const auto* esc : {&port, &stbd}) {
    if (!*esc) continue;
    const double voltage_V = double{(*esc)->voltage}, amperes = double{(*esc)->current};
    if (voltage_V >= 0 && voltage_V < 65.5) {
      const auto mV = static_cast<std::uint16_t>(portable::nearest(voltage_V * 1000));
      out.voltages[0] = std::min(out.voltages[0], mV);
    }
    if (std::abs(amperes) < 150) {  // false for NaN
      current_A += amperes;
      ++currents;
    }
  }
  if (currents == 2 && current_A >= 0) {  // one ESC's current alone would mislead
    out.current_battery = static_cast<std::int16_t>(portable::nearest(current_A * 100));
  }
  return out;
}

std::int16_t centidegrees_of_kelvin(float kelvin) {
  const double celsius = double{kelvin} - 273.15;
  if (!(std::abs(celsius) < 327)) return INT16_MAX;
  return static_cast<std::int16_t>(portable::nearest(celsius * 100));
}

bool is_dead(double share, const Configuration::Propulsion& propulsion) {
  const float most_N = share < 0 ? propulsion.astern_N : propulsion.ahead_N;
  return std::abs(share) * double{most_N} < double{propulsion.dead_N};
}

std::optional<double> stick_of(std::int16_t axis) {
  if (axis < -1000 || axis > 1000) return std::nullopt;
  return axis / 1000.0;
}

template OwnState own_state_of<float>(const Position&, const core::Motion<float>&);
template OwnState own_state_of<double>(const Position&, const core::Motion<double>&);
template OwnState own_state_of<core::Q16>(const Position&, const core::Motion<core::Q16>&);

}  // namespace flotilla::app::convert
