// SPDX-License-Identifier: MIT
#include "app/boat/conditions.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "app/boat/parts.hpp"

namespace flotilla::app {
namespace {

template <class S>
bool coasts_on(const Parts<S>& boat, std::int64_t now_us) {
  const auto since_us = boat.supervisor.coasting_since_us();
  if (!since_us) return true;
  return now_us - *since_us < boat.configuration().failsafes.coast_us && boat.guidance.can_coast();
}

}  // namespace

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
  if (just_armed) {
    asks_home_ = true;
    home_near_ = false;
    left_from_.reset();
    home_.reset();
  }
  if (seen.place && seen.sure && std::exchange(asks_home_, false)) {
    late_home_ = seen.armed && !just_armed;
    left_from_ = seen.place;
    const auto at = convert::global_of(*seen.place);
    home_ = {at.latitude, at.longitude, seen.place->origin.altitude};
  }
  const auto& [battery_V, fence_m] = std::tie(failsafes.battery_V, failsafes.fence_m);
  const auto above = [least_V = battery_V.value_or(0.0F)](const auto& esc) {
    return esc && esc->voltage >= least_V;  // false for NaN
  };
  battery_good_.update(std::ranges::all_of(seen.escs, above), seen.now_us);
  met_ = 0;
  if (battery_good_.value() || !battery_V) met_ |= core::kBatteryGood;
  if (!fence_m || inside(*fence_m, seen)) met_ |= core::kInsideFence;
  if (seen.place && left_from_ && seen.now_us >= home_due_us_) {
    home_near_ = convert::distance_m(*left_from_, *seen.place) < double{kErrandReach_m};
    home_due_us_ = seen.now_us + 1'000'000;
  }
  if (home_near_) met_ |= core::kHomeNear;
}

void FailsafeLimits::set_home(const convert::GlobalPoint& place) {
  asks_home_ = false;
  const std::int32_t altitude = home_ ? home_->altitude_mm : 0;
  left_from_ = convert::Position{0, 0, {place.latitude, place.longitude, altitude, 0}};
  home_ = {place.latitude, place.longitude, altitude};
}

/// A disarmed boat counts as inside, because home will be where it is armed.
bool FailsafeLimits::inside(float fence_m, const Seen& seen) const {
  if (!seen.place) return false;
  return !seen.armed ||
         (left_from_ && convert::distance_m(*left_from_, *seen.place) <= double{fence_m});
}

template <class S>
core::Conditions heard_of(const Parts<S>& boat, std::int64_t now_us) {
  static_assert(((core::kManualDrive | core::kDrive | core::kCoastDrive | core::kAutoDrive |
                  core::kGuidedDrive | core::kReturnDrive | core::kTestDrive) &
                 core::kClear) == 0);
  core::Conditions met = boat.vehicle.conditions(now_us) | boat.guidance.heard(now_us) |
                         propulsion_of(boat.can, boat.configuration().propulsion, now_us);
  if (boat.host.bus_up) met |= core::kBusUp;
  if (boat.host.why_not_to_arm.empty()) met |= core::kParametersSaved;
  return met;
}

template <class S>
core::Conditions conditions_of(const Parts<S>& boat, const Judged& judged, std::int64_t now_us) {
  const Guidance<S>& guidance = boat.guidance;
  const bool sails = core::law_drives(boat.state());
  core::Conditions met = judged.heard | boat.supervisor.conditions(now_us) |
                         guidance.conditions(now_us) | boat.limits.conditions();
  core::Conditions denied = 0;  // by a second part that must agree
  if (coasts_on(boat, now_us)) met |= core::kCoastRunning;
  if (judged.in_range) met |= core::kInRange;
  if (judged.rally_near && boat.limits.home()) met |= core::kHomeNear;
  if (!judged.slot_astern && guidance.claims().is_free(now_us, sails)) {
    met |= core::kSlotSound;
  }
  const bool lost = judged.voyage_lost && boat.state() == core::State::kAuto;
  if ((guidance.station_loss() == core::StationLoss::kNo && !lost) || !sails) {
    met |= core::kOnStation;
  }
  if (!boat.fence_watch.stays()) denied |= core::kInsideFence;
  if (guidance.located()) met |= core::kLocated;
  const MissionService& missions = boat.vehicle.missions();
  const bool reached = !core::sails_alone(boat.state()) || guidance.plan_vessel().is_sound();
  if (!reached) denied |= core::kHomeNear;
  if (!missions.plan().empty() && guidance.located() && reached &&
      missions.plan_is_sound(boat.state() == core::State::kAuto)) {
    met |= core::kPlanReady;
  }
  if (boat.vehicle.doubled(now_us)) denied |= core::kSoleVessel;
  const bool follows = core::follows(boat.state());
  if (follows && guidance.leader_jumped()) denied |= core::kLeaderSteady;  // until a new request
  return met & ~denied;
}

#define FLOTILLA_CONDITIONS(S)                                          \
  template core::Conditions heard_of<S>(const Parts<S>&, std::int64_t); \
  template core::Conditions conditions_of<S>(const Parts<S>&, const Judged&, std::int64_t);
FLOTILLA_CONDITIONS(float)
FLOTILLA_CONDITIONS(double)
FLOTILLA_CONDITIONS(core::Q16)
#undef FLOTILLA_CONDITIONS

}  // namespace flotilla::app
