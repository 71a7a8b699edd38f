// SPDX-License-Identifier: MIT
#include "app/conditions.hpp"

#include <algorithm>

namespace flotilla::app {

core::Conditions choices_of(const Parameters& p) {
  core::Conditions chosen = 0;
  const int leader_act = static_cast<int>(p.FS_LEADER_ACT),
            gcs_act = static_cast<int>(p.FS_GCS_ACT);
  if (leader_act == 0) chosen |= core::kLeaderLossHolds;
  if (leader_act == 1) chosen |= core::kLeaderLossCoasts;
  if (gcs_act == 0) chosen |= core::kGcsLossHolds;
  if (gcs_act == 1) chosen |= core::kGcsLossCoasts;
  return chosen;
}

core::Conditions propulsion_of(const CanNode& can, const Parameters& p, std::int64_t now_us) {
  const std::int64_t limit_us = convert::microseconds(p.FS_ESC_S);
  const auto port = static_cast<std::uint8_t>(p.ESC_PORT);
  const auto stbd = static_cast<std::uint8_t>(p.ESC_STBD);
  core::Conditions met = 0;
  if (can.esc_online(port, now_us, limit_us) && can.esc_online(stbd, now_us, limit_us)) {
    met |= core::kEscsOnline;
  }
  if (can.escs_obey(port, stbd, now_us)) met |= core::kEscsObey;
  if (!can.foreign_controller(now_us)) met |= core::kSoleController;
  return met;
}

void Limits::look(const Parameters& p, const Seen& seen) {
  const bool just_armed = seen.armed && !was_armed_;
  was_armed_ = seen.armed;
  if (seen.place && (!home_ || just_armed)) {
    left_from_ = seen.place;
    const auto at = convert::global_of(*seen.place);
    home_ = {at.latitude, at.longitude, seen.place->origin.altitude};
  }
  const auto above = [&p](const std::optional<link::EscStatus>& esc) {
    return esc && esc->voltage >= p.FS_BATT_V;  // false for NaN
  };
  battery_good_.look(std::ranges::all_of(seen.escs, above), seen.now_us);
  met_ = 0;
  if (battery_good_.is() || p.FS_BATT_V == 0) met_ |= core::kBatteryGood;
  if (p.FS_FENCE_M == 0 || inside(p.FS_FENCE_M, seen)) met_ |= core::kInsideFence;
}

/// A boat that is not armed is at home: there it will be armed.
bool Limits::inside(float fence_m, const Seen& seen) const {
  if (!seen.place) return false;
  return !seen.armed || convert::distance_m(*left_from_, *seen.place) <= double{fence_m};
}

}  // namespace flotilla::app
