// SPDX-License-Identifier: MIT
#include "app/plan/plan.hpp"

#include <algorithm>

#include "app/plan/voyage.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

constexpr float kOctagon = 1.0824F;  // distance of its corners / of its sides, from the centre
/// Directions of the corners, north and east; clockwise from the north.
constexpr std::array<std::array<float, 2>, 8> kOctants{{{1, 0},
                                                        {0.70711F, 0.70711F},
                                                        {0, 1},
                                                        {-0.70711F, 0.70711F},
                                                        {-1, 0},
                                                        {-0.70711F, -0.70711F},
                                                        {0, -1},
                                                        {0.70711F, -0.70711F}}};
constexpr float kLargestRadius_m = 100, kSlowest_mps = 0.05F;

bool is_within(float param, float most) { return or_zero(param) >= 0 && or_zero(param) <= most; }

bool has_place(const PlanItem& item) {
  return item.command == mav::kNavWaypoint || item.command == mav::kNavLoiterUnlimited ||
         item.command == mav::kNavLoiterTurns || item.command == mav::kNavLoiterTime ||
         is_voyage(item);
}

bool turns(const PlanItem& item) { return item.command == mav::kNavLoiterTurns; }

bool is_pause(const PlanItem& item) {
  return item.command == mav::kNavDelay || item.command == mav::kConditionDelay;
}

/// Whether home becomes the boat's position at that time.
bool sets_home_here(const PlanItem& item) { return or_zero(item.param[0]) == 1; }

/// Whether an item means the boat's position at that time: a loiter at 0, 0.
bool is_here(const PlanItem& item) {
  return item.command != mav::kNavWaypoint && !turns(item) && !is_voyage(item) && item.x == 0 &&
         item.y == 0;
}

bool leads_somewhere(const PlanItem& item) { return has_place(item) && !is_here(item); }

bool waits(const PlanItem& item) { return has_place(item) || is_pause(item); }

float radius_of(const PlanItem& item, const PlanDefaults& defaults) {
  const float told_m = or_zero(item.param[2]);
  return told_m == 0 ? defaults.radius_m : told_m < 0 ? -told_m : told_m;
}

PlanFault fault_of_frame(const PlanItem& item) {
  if (is_global(item.frame)) return {};
  return {mav::kMissionUnsupportedFrame, "frame must be global"};
}

PlanFault fault_of_speed(const PlanItem& item, float fastest_mps) {
  const float speed_mps = or_zero(item.param[1]);
  if (!is_within(item.param[0], 1)) return {mav::kMissionInvalidParam1, "param1 is not 0 or 1"};
  if (speed_mps < 0) return {};  // −1: no change, −2: the default
  if (speed_mps < kSlowest_mps || !(speed_mps <= kPlanFastest_mps)) {
    return {mav::kMissionInvalidParam2, "speed must be 0.05 to 5 m/s"};
  }
  if (fastest_mps > 0 && speed_mps > fastest_mps) {
    return {mav::kMissionInvalidParam2, "speed is above LAW_U_MAX"};
  }
  return {};
}

PlanFault fault_of_circle(const PlanItem& item, const PlanDefaults& defaults) {
  constexpr float kMaxTurns = 100;
  const float radius_m = radius_of(item, defaults);
  if (!(or_zero(item.param[0]) > 0 && is_within(item.param[0], kMaxTurns))) {
    return {mav::kMissionInvalidParam1, "turns must be 0 to 100"};
  }
  if (!(radius_m >= 1 && radius_m <= kLargestRadius_m)) {
    return {mav::kMissionInvalidParam3, "radius must be 1 to 100 m"};
  }
  return {};
}

PlanFault fault_of_home(const PlanItem& item) {
  if (!is_within(item.param[0], 1)) return {mav::kMissionInvalidParam1, "param1 is not 0 or 1"};
  return sets_home_here(item) ? PlanFault{} : fault_of_place(item);
}

/// Judges the length of the leg between two places, and round them.
PlanFault fault_of_leg(const PlanItem& from, const PlanItem& to, const PlanDefaults& defaults) {
  const convert::Position start{0, 0, {from.x, from.y, 0, 0}};
  const float most_m = kPlanLeg_m - extent_of(from, defaults) - extent_of(to, defaults);
  if (convert::way_to<double>(start, {to.x, to.y}, most_m).near) return {};
  return {mav::kMissionInvalidX, "leg over 2.9 km"};
}

/// The last item of a plan that leads somewhere; nullptr: none does.
const PlanItem* last_place(Plan plan) {
  while (!plan.empty() && !leads_somewhere(plan.back())) plan = plan.first(plan.size() - 1);
  return plan.empty() ? nullptr : &plan.back();
}

/// Judges the last item, a jump. It must lead back over two places or a circle, so that no loop is
/// without progress.
PlanFault fault_of_jump(Plan plan, const PlanDefaults& defaults) {
  const PlanItem& item = plan.back();
  const float target = item.param[0], times = or_zero(item.param[1]);
  const float homes = static_cast<float>(defaults.homes);
  const float last = static_cast<float>(plan.size() - 1) + homes;
  const bool leads_back = target >= homes && target < last;
  if (!leads_back || static_cast<float>(jump_of(item, defaults)) != target - homes) {
    return {mav::kMissionInvalidParam1, "jump must lead back"};
  }
  if (times != -1 && !is_within(times, 30'000)) {
    return {mav::kMissionInvalidParam2, "repeats not -1 to 30000"};
  }
  const Plan loop = plan.subspan(jump_of(item, defaults));
  const auto first = std::ranges::find_if(loop, leads_somewhere);
  const auto moves = [&](const PlanItem& i) {
    return leads_somewhere(i) && (turns(i) || i.x != first->x || i.y != first->y);
  };
  if (std::ranges::none_of(loop, moves)) {
    return {mav::kMissionInvalidParam1, "empty loop"};
  }
  if (const PlanFault fault = fault_of_leg(*last_place(loop), *first, defaults)) return fault;
  const auto is_jump = [](const PlanItem& i) { return i.command == mav::kDoJump; };
  if (std::ranges::any_of(loop.begin(), first, is_jump)) {
    return {mav::kMissionInvalidParam1, "jump to a jump"};
  }
  const auto jumps = static_cast<std::size_t>(std::ranges::count_if(plan, is_jump));
  return jumps > PlanProgress::kJumps ? PlanFault{mav::kMissionNoSpace, {}} : PlanFault{};
}

PlanFault fault_of_item(const PlanItem& item, const PlanDefaults& defaults) {
  if (is_voyage(item)) {
    const PlanFault fault = fault_of_voyage(item);
    return fault ? fault : fault_of_place(item);
  }
  const bool timed = waits(item) && item.command != mav::kNavLoiterUnlimited && !turns(item);
  if (timed && !is_within(item.param[0], kLongestWait_s)) {
    return {mav::kMissionInvalidParam1, "wait must be 0 to 30000 s"};
  }
  if (item.command == mav::kNavWaypoint && !is_within(item.param[1], kLargestRadius_m)) {
    return {mav::kMissionInvalidParam2, "radius must be 0 to 100 m"};
  }
  if (turns(item)) {
    if (const PlanFault fault = fault_of_circle(item, defaults)) return fault;
  }
  if (has_place(item)) return is_here(item) ? fault_of_frame(item) : fault_of_place(item);
  switch (item.command) {
    case mav::kNavReturn:
    case mav::kNavDelay:
    case mav::kConditionDelay:
    case mav::kDoJump:
    case mav::kDoSetRoi:
      return {};
    case mav::kDoSetHome:
      return fault_of_home(item);
    case mav::kDoChangeSpeed:
      return fault_of_speed(item, defaults.fastest_mps);
    default:
      return {mav::kMissionUnsupported, "command not supported"};
  }
}

}  // namespace

bool is_global(std::uint8_t frame) {
  constexpr std::array<std::uint8_t, 5> kGlobal{0, 3, 5, 6, 11};
  return std::ranges::find(kGlobal, frame) != kGlobal.end();
}

bool is_speed(double mps, const PlanDefaults& defaults) {
  const bool limited = defaults.fastest_mps > 0;
  const float most = limited ? std::min(defaults.fastest_mps, kPlanFastest_mps) : kPlanFastest_mps;
  return mps >= double{kSlowest_mps} && mps <= double{most};
}

PlanFault fault_of_place(const PlanItem& item) {
  if (const PlanFault fault = fault_of_frame(item)) return fault;
  if (convert::is_valid({item.x, item.y, 0, 0})) return {};
  const bool turned = item.x < -890'000'000 || item.x > 890'000'000;
  return {turned ? mav::kMissionInvalidX : mav::kMissionInvalidY, "invalid position"};
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

float extent_of(const PlanItem& item, const PlanDefaults& defaults) {
  return turns(item) ? kOctagon * radius_of(item, defaults) : 0;
}

std::size_t jump_of(const PlanItem& item, const PlanDefaults& defaults) {
  return static_cast<std::size_t>(item.param[0]) - defaults.homes;
}

std::optional<convert::GlobalPoint> home_of(const PlanItem& item) {
  if (sets_home_here(item)) return std::nullopt;
  return convert::GlobalPoint{item.x, item.y};
}

PlanFault fault_of_last(Plan plan, const PlanDefaults& defaults) {
  const PlanItem& last = plan.back();
  const PlanFault fault = fault_of_item(last, defaults);
  if (!fault && last.command == mav::kDoJump) return fault_of_jump(plan, defaults);
  const bool needs_place = last.command == mav::kDoSetHome || last.command == mav::kNavReturn;
  if (!fault && needs_place && std::ranges::none_of(plan, leads_somewhere)) {
    return {mav::kMissionInvalid, "needs a waypoint before it"};
  }
  const bool sets_home = last.command == mav::kDoSetHome && !sets_home_here(last);
  if (fault || !(leads_somewhere(last) || sets_home)) return fault;
  if (const PlanFault far = fault_of_reach(*std::ranges::find_if(plan, leads_somewhere), last)) {
    return far;
  }
  const PlanItem* before = last_place(plan.first(plan.size() - 1));
  return before == nullptr || sets_home ? PlanFault{} : fault_of_leg(*before, last, defaults);
}

PlanFault fault_of(Plan plan) {
  const auto first = std::ranges::find_if(plan, leads_somewhere);
  if (first == plan.end()) return {mav::kMissionInvalid, "no waypoint"};
  if (std::ranges::any_of(plan.begin(), first, waits))
    return {mav::kMissionInvalid, "wait before the first waypoint"};
  return {};
}

void PlanReader::begin(const PlanStart& start, const PlanDefaults& defaults) {
  *this = {};
  defaults_ = defaults;
  progress_ = start.progress;
  home_ = start.home;
  last_ = start.here;
  at_ = start.first;
  pauses_ = start.pauses;
  voyage_is_over_ = start.voyage_is_over;
}

float PlanReader::speed_mps() const {
  const float told_mps = progress_.speed_mps() > 0 ? progress_.speed_mps() : defaults_.speed_mps;
  return defaults_.fastest_mps > 0 ? std::min(told_mps, defaults_.fastest_mps) : told_mps;
}

std::size_t PlanProgress::pass(Plan plan, std::size_t item) {
  note_speed(plan[item]);
  if (plan[item].command != mav::kDoJump || !take_jump(plan[item], item)) return item + 1;
  ++taken_;
  return jump_of(plan[item], {});
}

void PlanProgress::go_to(Plan plan, std::size_t item, bool anew) {
  if (anew) *this = {};
  speed_mps_ = 0;
  for (const PlanItem& before : plan.first(item)) note_speed(before);
}

void PlanProgress::note_speed(const PlanItem& item) {
  if (item.command != mav::kDoChangeSpeed) return;
  const float told_mps = or_zero(item.param[1]);
  if (told_mps > 0) speed_mps_ = told_mps;
  if (told_mps == -2) speed_mps_ = 0;
}

/// Counts the jump; true if it is taken.
bool PlanProgress::take_jump(const PlanItem& item, std::size_t at) {
  const float times = or_zero(item.param[1]);
  for (Jump& jump : jumps_) {
    if (jump.taken < 0) jump = {static_cast<std::uint16_t>(at), 0};
    if (jump.item != at) continue;
    if (times >= 0 && static_cast<float>(jump.taken) >= times) {
      jump.taken = 0;  // an outer jump may lead here again
      return false;
    }
    if (times >= 0) ++jump.taken;
    return true;
  }
  return false;
}

PlanPoint PlanReader::point_of(const PlanItem& item, const convert::GlobalPoint& place) {
  const float told_m = item.command == mav::kNavWaypoint ? or_zero(item.param[1]) : 0;
  last_ = place;
  return {mark(), place, speed_mps(), told_m > 0 ? told_m : defaults_.radius_m};
}

convert::GlobalPoint corner_of(const PlanItem& item, const PlanDefaults& defaults,
                               std::size_t octant) {
  const double far_m = double{extent_of(item, defaults)};
  const auto& [north, east] = kOctants[octant];
  return convert::global_of({far_m * double{north}, far_m * double{east}, {item.x, item.y, 0, 0}});
}

/// The next corner of an octagon round the circle; the vessel rounds these corners. The first one
/// is towards the place before.
PlanPoint PlanReader::on_circle(const PlanItem& item) {
  const convert::Position centre{0, 0, {item.x, item.y, 0, 0}};
  if (octants_ == 0) {
    const auto [way, near] = convert::way_to<double>(centre, last_, 2 * kPlanReach_m);
    double most = 0;
    for (std::size_t i = 0; near && i < kOctants.size(); ++i) {
      const double along = way.x * double{kOctants[i][0]} + way.y * double{kOctants[i][1]};
      if (along <= most) continue;
      most = along;
      octant_ = static_cast<std::uint16_t>(i);
    }
  } else if (octants_ > 0) {
    const int on = or_zero(item.param[2]) < 0 ? 7 : 1;
    octant_ = static_cast<std::uint16_t>((octant_ + on) % 8);
  }
  ++octants_;
  return {mark(), corner_of(item, defaults_, octant_), speed_mps(), kLargestRadius_m};
}

/// Goes on to the following item. The boat stops at the point if the plan pauses.
void PlanReader::pass(Plan plan, std::optional<PlanPoint>& point) {
  constexpr float kMoment_s = 0.01F;
  if (pauses_ && point && plan[at_].autocontinue == 0) {
    point->mark.pauses = true;
    point->wait_s = std::max(point->wait_s, kMoment_s);
  }
  at_ = progress_.pass(plan, at_);
}

std::optional<PlanPoint> PlanReader::next(Plan plan) {
  std::optional<PlanPoint> point;
  while (at_ < plan.size()) {
    const PlanItem& item = plan[at_];
    const bool returns = item.command == mav::kNavReturn;
    if (point && (leads_somewhere(item) || (returns && home_))) return point;
    if (turns(item)) {
      point = on_circle(item);
      last_ = point->place;
      if (!(static_cast<float>(octants_) > 8 * or_zero(item.param[0]))) return point;
      octants_ = 0;
      pass(plan, point);
      continue;
    }
    if (leads_somewhere(item)) point = point_of(item, {item.x, item.y});
    if (returns && home_) point = point_of(item, *home_);
    const bool is_over = is_voyage(item) && std::exchange(voyage_is_over_, false);
    if (returns || item.command == mav::kNavLoiterUnlimited || (is_voyage(item) && !is_over)) {
      at_ = plan.size();
      return point;
    }
    if (waits(item) && !is_voyage(item)) {
      if (!point) point = point_of(item, last_);
      point->wait_s += or_zero(item.param[0]);
    }
    if (item.command == mav::kDoSetHome) {
      home_ = sets_home_here(item) ? std::optional(last_) : home_of(item);
      if (!point) point = point_of(item, last_);
      point->mark.home = static_cast<std::uint16_t>(at_);
    }
    pass(plan, point);
  }
  return point;
}

}  // namespace flotilla::app
