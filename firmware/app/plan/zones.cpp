// SPDX-License-Identifier: MIT
#include "app/plan/zones.hpp"

#include <algorithm>
#include <cmath>

#include "core/fence.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::Q16;
using Place = core::Vec2<Q16>;

constexpr std::size_t kLeastCorners = 3;
constexpr Q16 kApart = Q16(0.1);  // corners and edges of a polygon, m

bool is_corner(const PlanItem& item) {
  return item.command == mav::kFenceInclusion || item.command == mav::kFenceExclusion;
}

bool is_circle(const PlanItem& item) {
  return item.command == mav::kFenceCircleInclusion || item.command == mav::kFenceCircleExclusion;
}

bool keeps_in(const PlanItem& item) {
  return item.command == mav::kFenceInclusion || item.command == mav::kFenceCircleInclusion;
}

/// Corners of the polygon that the item belongs to; 0: impossible.
std::size_t corners_of(const PlanItem& item) {
  const float count = item.param[0];
  const bool possible = count >= kLeastCorners && count <= 65535;
  const auto whole = possible ? static_cast<std::size_t>(count) : 0;
  return static_cast<float>(whole) == count ? whole : 0;
}

/// Number of items of the incomplete polygon at the end, without the last item.
std::size_t begun(Plan fence) {
  std::size_t at = 0;
  while (at + 1 < fence.size()) {
    const std::size_t size = is_corner(fence[at]) ? corners_of(fence[at]) : 1;
    if (at + size >= fence.size()) return fence.size() - 1 - at;
    at += size;
  }
  return 0;
}

PlanFault fault_of_command(const PlanItem& item) {
  if (is_corner(item) && corners_of(item) == 0) {
    return {mav::kMissionInvalidParam1, "polygon needs 3 or more corners"};
  }
  if (is_circle(item)) {
    const float radius_m = item.param[0];
    if (!(radius_m >= kLeastCircle_m && radius_m <= kGreatestCircle_m)) {
      return {mav::kMissionInvalidParam1, "radius must be 1 to 2000 m"};
    }
  }
  if (!is_corner(item) && !is_circle(item)) {
    if (item.command == mav::kFenceReturnPoint) {
      return {mav::kMissionUnsupported, "no return point: send rally points"};
    }
    return {mav::kMissionUnsupported, "not a fence item"};
  }
  const bool grouped = !std::isnan(item.param[1]) && item.param[1] != 0;
  if (keeps_in(item) && grouped) return {mav::kMissionInvalidParam2, "inclusion group must be 0"};
  return {};
}

/// Whether the edge from b to c folds back over the edge from a to b.
bool folds(const Place& a, const Place& b, const Place& c) {
  return core::distance_to(c, a, b) < kApart || core::distance_to(a, b, c) < kApart;
}

constexpr PlanFault kCrossing{mav::kMissionInvalid, "the polygon crosses itself"};

/// Judges the edge to a polygon's last corner, and the closing edge if the polygon is complete.
PlanFault fault_of_edges(Plan corners) {
  const convert::Position from{0, 0, {corners[0].x, corners[0].y, 0, 0}};
  const auto place = [&](std::size_t i) {
    return convert::way_to<Q16>(from, {corners[i].x, corners[i].y}, 2 * kPlanReach_m).n;
  };
  const std::size_t last = corners.size() - 1;
  if (last == 0) return {};
  const bool closes = corners.size() == corners_of(corners[0]);
  const Place first = place(0), new_one = place(last), before = place(last - 1);
  if (core::hypot(new_one.x - before.x, new_one.y - before.y) < kApart ||
      core::hypot(new_one.x - first.x, new_one.y - first.y) < kApart) {
    return {mav::kMissionInvalidX, "two corners within 0.1 m"};
  }
  if (last < 2) return {};
  if (folds(place(last - 2), before, new_one)) return kCrossing;
  if (closes && (folds(before, new_one, first) || folds(new_one, first, place(1)))) {
    return kCrossing;
  }
  Place a = first;
  for (std::size_t i = 1; i < last; ++i) {  // the edge from corner i − 1 to i
    const Place b = place(i);
    if (i + 1 < last && core::distance_between(a, b, before, new_one) < kApart) return kCrossing;
    if (closes && i > 1 && core::distance_between(a, b, new_one, first) < kApart) return kCrossing;
    a = b;
  }
  return {};
}

}  // namespace

ZoneItems first_zone(Plan fence) {
  const PlanItem& item = fence[0];
  if (is_circle(item)) return {fence.first(1), item.param[0], keeps_in(item)};
  return {fence.first(std::min(corners_of(item), fence.size())), 0, keeps_in(item)};
}

PlanFault fault_of_last_zone(Plan fence) {
  const PlanItem& item = fence.back();
  if (const PlanFault fault = fault_of_command(item)) return fault;
  if (const PlanFault fault = fault_of_place(item)) return fault;
  if (const PlanFault fault = fault_of_reach(fence[0], item)) return fault;
  const Plan corners = fence.last(begun(fence) + 1);
  if (corners.size() > 1) {
    if (item.command != corners[0].command) {
      return {mav::kMissionInvalid, "previous polygon is incomplete"};
    }
    if (item.param[0] != corners[0].param[0]) {
      return {mav::kMissionInvalidParam1, "corner counts differ"};
    }
  }
  return is_corner(item) ? fault_of_edges(corners) : PlanFault{};
}

PlanFault fault_of_zones(Plan fence) {
  if (fence.empty()) return {};
  const std::size_t last = fence.size() - 1;
  const PlanItem& item = fence[last];
  if (!is_corner(item) || begun(fence) + 1 == corners_of(item)) return {};
  return {mav::kMissionInvalid, "last polygon is incomplete", last};
}

PlanFault fault_of_last_rally(Plan points) {
  const PlanItem& item = points.back();
  if (item.command != mav::kRallyPoint) return {mav::kMissionUnsupported, "not a rally point"};
  if (const PlanFault fault = fault_of_place(item)) return fault;
  return fault_of_reach(points[0], item);
}

}  // namespace flotilla::app
