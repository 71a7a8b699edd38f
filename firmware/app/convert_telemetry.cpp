// SPDX-License-Identifier: MIT
#include "app/convert_telemetry.hpp"

#include <algorithm>
#include <cmath>

namespace flotilla::app::convert {
namespace {

constexpr double kDegreesPerRadian = 57.29577951308232;

struct Slot {
  double north_m, east_m;   ///< from the own origin
  core::Vec2<double> to_n;  ///< from the boat to it
};

/// e is the boat seen from the slot, along the boat's axes.
Slot slot_from(const OwnState<double>& state, const core::Error<double>& e) {
  const auto e_n = core::to_north_east(state.motion.psi, core::Vec2<double>{e.x, e.y});
  return {state.north_m + state.motion.moved_n.x - e_n.x,
          state.east_m + state.motion.moved_n.y - e_n.y,
          {-e_n.x, -e_n.y}};
}

std::int16_t degrees(double rad) {
  return static_cast<std::int16_t>(std::lround(core::wrap_pi(rad) * kDegreesPerRadian));
}

}  // namespace

link::Odometry odometry_of(const OwnState<double>& state, std::uint32_t time_boot_ms) {
  const link::LocalPositionNed at = local_position_of(state, time_boot_ms);
  const double half = 0.5 * core::wrap_pi(state.motion.psi);
  const auto& nu = state.motion.nu;
  return {std::uint64_t{time_boot_ms} * 1000,
          at.x,
          at.y,
          0,
          {static_cast<float>(std::cos(half)), 0, 0, static_cast<float>(std::sin(half))},
          static_cast<float>(nu.u),
          static_cast<float>(nu.v),
          0,
          0,
          0,
          static_cast<float>(nu.r),
          link::mav::kFrameLocalNed,
          link::mav::kFrameBodyFrd};
}

link::NavControllerOutput nav_controller_output_of(const OwnState<double>& state,
                                                   const core::Error<double>& error) {
  const core::Vec2<double> to = slot_from(state, error).to_n;
  const double distance_m = std::min(std::hypot(to.x, to.y), 65535.0);
  return {degrees(state.motion.psi - error.psi), degrees(std::atan2(to.y, to.x)),
          static_cast<std::uint16_t>(std::lround(distance_m)), static_cast<float>(error.y)};
}

link::PositionTargetLocalNed slot_of(const OwnState<double>& state,
                                     const core::Error<double>& error, std::uint32_t time_boot_ms) {
  constexpr std::uint16_t kNotVelocity = 8 | 16 | 32, kNotAcceleration = 64 | 128 | 256,
                          kNotYawRate = 2048;
  const Slot slot = slot_from(state, error);
  link::PositionTargetLocalNed out{};
  out.time_boot_ms = time_boot_ms;
  out.coordinate_frame = link::mav::kFrameLocalNed;
  out.type_mask = kNotVelocity | kNotAcceleration | kNotYawRate;
  out.x = static_cast<float>(slot.north_m);
  out.y = static_cast<float>(slot.east_m);
  out.yaw = static_cast<float>(core::wrap_pi(state.motion.psi - error.psi));
  return out;
}

link::BatteryStatus battery_of(const std::optional<link::EscStatus>& port,
                               const std::optional<link::EscStatus>& stbd) {
  link::BatteryStatus out{UINT16_MAX, -1};
  double current_A = 0;
  int currents = 0;
  for (const auto* esc : {&port, &stbd}) {
    if (!*esc) continue;
    const double voltage_V = double{(*esc)->voltage}, amperes = double{(*esc)->current};
    if (voltage_V >= 0 && voltage_V < 65.5) {
      const auto mV = static_cast<std::uint16_t>(std::lround(voltage_V * 1000));
      out.voltage_mV = std::min(out.voltage_mV, mV);
    }
    if (std::abs(amperes) < 150) {  // false for NaN
      current_A += amperes;
      ++currents;
    }
  }
  if (currents == 2 && current_A >= 0) {  // half of it would be no figure
    out.current_cA = static_cast<std::int16_t>(std::lround(current_A * 100));
  }
  return out;
}

std::int16_t centidegrees_of_kelvin(float kelvin) {
  const double celsius = double{kelvin} - 273.15;
  if (!(std::abs(celsius) < 327)) return INT16_MAX;
  return static_cast<std::int16_t>(std::lround(celsius * 100));
}

bool is_dead(double share, const Parameters& p) {
  const float most_N = share < 0 ? p.THR_REV_MAX : p.THR_FWD_MAX;
  return std::abs(share) * double{most_N} < double{p.THR_DEAD};
}

std::optional<double> stick_of(std::int16_t axis) {
  if (axis < -1000 || axis > 1000) return std::nullopt;
  return axis / 1000.0;
}

}  // namespace flotilla::app::convert
