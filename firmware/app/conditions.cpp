// SPDX-License-Identifier: MIT
#include "app/conditions.hpp"

#include <algorithm>
#include <tuple>

namespace flotilla::app {

core::Conditions propulsion_of(const CanNode& can, const Configuration::Propulsion& propulsion,
                               std::int64_t now_us) {
  const auto& [port, stbd] = std::tie(propulsion.port_esc, propulsion.stbd_esc);
  const std::int64_t limit_us = propulsion.esc_limit_us;
  core::Conditions met = 0;
  if (can.esc_online(port, now_us, limit_us) && can.esc_online(stbd, now_us, limit_us)) {
    met |= core::kEscsOnline;
  }
  if (can.escs_obey(port, stbd, now_us)) met |= core::kEscsObey;
  if (!can.foreign_controller(now_us)) met |= core::kSoleController;
  return met;
}

void FailsafeLimits::look(const Configuration::Failsafes& failsafes, const Seen& seen) {
  const bool just_armed = seen.armed && !was_armed_;
  was_armed_ = seen.armed;
  if (seen.place && (!home_ || just_armed)) {
    left_from_ = seen.place;
    const auto at = convert::global_of(*seen.place);
    home_ = {at.latitude, at.longitude, seen.place->origin.altitude};
  }
  const auto& [battery_V, fence_m] = std::tie(failsafes.battery_V, failsafes.fence_m);
  const auto above = [least_V = battery_V.value_or(0.0F)](const auto& esc) {
    return esc && esc->voltage >= least_V;  // false for NaN
  };
  battery_good_.look(std::ranges::all_of(seen.escs, above), seen.now_us);
  met_ = 0;
  if (battery_good_.is() || !battery_V) met_ |= core::kBatteryGood;
  if (!fence_m || inside(*fence_m, seen)) met_ |= core::kInsideFence;
  if (seen.place && seen.now_us >= home_due_us_) {
    home_near_ = convert::distance_m(*left_from_, *seen.place) < double{kErrandReach_m};
    home_due_us_ = seen.now_us + 1'000'000;
  }
  if (home_near_) met_ |= core::kHomeNear;
}

void FailsafeLimits::set_home(const convert::GlobalPoint& place) {
  const std::int32_t altitude = home_ ? home_->altitude_mm : 0;
  left_from_ = convert::Position{0, 0, {place.latitude, place.longitude, altitude, 0}};
  home_ = {place.latitude, place.longitude, altitude};
}

/// A disarmed boat is inside: arming makes its position the new home.
bool FailsafeLimits::inside(float fence_m, const Seen& seen) const {
  if (!seen.place) return false;
  return !seen.armed || convert::distance_m(*left_from_, *seen.place) <= double{fence_m};
}

}  // namespace flotilla::app
