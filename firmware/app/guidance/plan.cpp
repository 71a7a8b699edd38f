// SPDX-License-Identifier: MIT
#include "app/guidance/plan.hpp"

#include <algorithm>
#include <cmath>

#include "app/guidance/voyage.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

constexpr float kLargestRadius_m = 100, kSlowest_mps = 0.05F, kFastest_mps = 5;
/// Unused parameters are NaN.
float or_zero(float param) { return std::isnan(param) ? 0.0F : param; }

bool is_within(float param, float most) { return or_zero(param) >= 0 && or_zero(param) <= most; }

bool has_place(const PlanItem& item) {
  return item.command == mav::kNavWaypoint || item.command == mav::kNavLoiterUnlimited ||
         item.command == mav::kNavLoiterTime || is_voyage(item);
}

/// A loiter at 0, 0 is where the boat is then.
bool is_here(const PlanItem& item) {
  return item.command != mav::kNavWaypoint && !is_voyage(item) && item.x == 0 && item.y == 0;
}

bool leads_somewhere(const PlanItem& item) { return has_place(item) && !is_here(item); }

bool waits(const PlanItem& item) { return has_place(item) || item.command == mav::kNavDelay; }

PlanFault fault_of_frame(const PlanItem& item) {
  if (is_global(item.frame)) return {};
  return {mav::kMissionUnsupportedFrame, "places are global"};
}

PlanFault fault_of_speed(const PlanItem& item, float fastest_mps) {
  const float speed_mps = or_zero(item.param[1]);
  if (!is_within(item.param[0], 1)) return {mav::kMissionInvalidParam1, "speed of the boat only"};
  if (speed_mps < 0) return {};  // −1: no change, −2: the default
  if (speed_mps < kSlowest_mps || !(speed_mps <= kFastest_mps)) {
    return {mav::kMissionInvalidParam2, "speed 0.05 to 5 m/s"};
  }
  if (fastest_mps > 0 && speed_mps > fastest_mps) {
    return {mav::kMissionInvalidParam2, "speed is above LAW_U_MAX"};
  }
  return {};
}

PlanFault fault_of_item(const PlanItem& item, const PlanDefaults& defaults) {
  if (is_voyage(item)) {
    const PlanFault fault = fault_of_voyage(item);
    return fault ? fault : fault_of_place(item);
  }
  const bool timed = waits(item) && item.command != mav::kNavLoiterUnlimited;
  if (timed && !is_within(item.param[0], kLongestWait_s)) {
    return {mav::kMissionInvalidParam1, "waits 0 to 30000 s"};
  }
  if (item.command == mav::kNavWaypoint && !is_within(item.param[1], kLargestRadius_m)) {
    return {mav::kMissionInvalidParam2, "radius 0 to 100 m"};
  }
  if (has_place(item)) return is_here(item) ? fault_of_frame(item) : fault_of_place(item);
  switch (item.command) {
    case mav::kNavDelay:
    case mav::kDoSetRoi:
      return {};
    case mav::kDoChangeSpeed:
      return fault_of_speed(item, defaults.fastest_mps);
    default:
      return {mav::kMissionUnsupported, "boats do not know that command"};
  }
}

}  // namespace

bool is_global(std::uint8_t frame) {
  constexpr std::array<std::uint8_t, 5> kGlobal{0, 3, 5, 6, 11};
  return std::ranges::find(kGlobal, frame) != kGlobal.end();
}

bool is_speed(double mps, const PlanDefaults& defaults) {
  const bool limited = defaults.fastest_mps > 0;
  const float most = limited ? std::min(defaults.fastest_mps, kFastest_mps) : kFastest_mps;
  return mps >= double{kSlowest_mps} && mps <= double{most};
}

PlanFault fault_of_place(const PlanItem& item) {
  if (const PlanFault fault = fault_of_frame(item)) return fault;
  if (convert::is_valid({item.x, item.y, 0, 0})) return {};
  const bool turned = item.x < -890'000'000 || item.x > 890'000'000;
  return {turned ? mav::kMissionInvalidX : mav::kMissionInvalidY, "no such place"};
}

PlanFault fault_of_reach(const PlanItem& first, const PlanItem& item) {
  const convert::Position from{0, 0, {first.x, first.y, 0, 0}};
  if (convert::way_to<double>(from, {item.x, item.y}, kPlanReach_m).near) return {};
  return {mav::kMissionInvalidX, "over 2 km from the first"};
}

std::optional<convert::GlobalPoint> place_of(const PlanItem& item) {
  if (!leads_somewhere(item)) return std::nullopt;
  return convert::GlobalPoint{item.x, item.y};
}

PlanFault fault_of_last(Plan plan, const PlanDefaults& defaults) {
  const PlanItem& last = plan.back();
  const PlanFault fault = fault_of_item(last, defaults);
  if (fault || !leads_somewhere(last)) return fault;
  return fault_of_reach(*std::ranges::find_if(plan, leads_somewhere), last);
}

PlanFault fault_of(Plan plan) {
  const auto first = std::ranges::find_if(plan, leads_somewhere);
  if (first == plan.end()) return {mav::kMissionInvalid, "it has no waypoint"};
  if (std::any_of(plan.begin(), first, waits))
    return {mav::kMissionInvalid, "it begins with a wait"};
  return {};
}

void PlanReader::begin(Plan plan, std::size_t first, const PlanDefaults& defaults) {
  *this = {};
  defaults_ = defaults;
  first_ = first;
  if (defaults.fastest_mps > 0) {
    defaults_.speed_mps = std::min(defaults.speed_mps, defaults.fastest_mps);
  }
  speed_mps_ = defaults_.speed_mps;
  while (at_ < std::min(first, plan.size())) note_speed(plan[at_++]);
}

void PlanReader::note_speed(const PlanItem& item) {
  if (item.command != mav::kDoChangeSpeed) return;
  const float told_mps = or_zero(item.param[1]);
  if (told_mps > 0) speed_mps_ = told_mps;
  if (told_mps == -2) speed_mps_ = defaults_.speed_mps;
}

std::optional<PlanPoint> PlanReader::next(Plan plan) {
  std::optional<PlanPoint> point;
  for (; at_ < plan.size(); ++at_) {
    const PlanItem& item = plan[at_];
    if (leads_somewhere(item)) {
      if (point) return point;
      const float told_m = item.command == mav::kNavWaypoint ? or_zero(item.param[1]) : 0;
      point =
          PlanPoint{at_, {item.x, item.y}, speed_mps_, told_m > 0 ? told_m : defaults_.radius_m};
    }
    if (item.command == mav::kNavLoiterUnlimited || (is_voyage(item) && at_ != first_)) {
      at_ = plan.size();
      return point;
    }
    if (waits(item) && !is_voyage(item) && point) point->wait_s += or_zero(item.param[0]);
    note_speed(item);
  }
  return point;
}

}  // namespace flotilla::app
