// SPDX-License-Identifier: MIT
// The courses on which a boat that gives way would leave its fence.
#include <doctest/doctest.h>

#include <vector>

#include "app/plan/fence_watch.hpp"
#include "core/separation.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

constexpr unsigned kNorth = 0, kEast = 4, kSouth = 8, kWest = 12;

/// A fence at the equator, with corners in metres north and east of (0, 0).
struct Fenced {
  std::vector<PlanItem> items;
  std::vector<Fence::Place> corners;
  Fence fence{{}};

  Fenced(std::uint16_t command, const std::vector<std::array<int, 2>>& places) {
    add(command, places);
  }

  void add(std::uint16_t command, const std::vector<std::array<int, 2>>& places) {
    for (const auto& [north, east] : places) {
      constexpr double kPerMetre = 1e7 / 111'195.0;
      PlanItem item{.param = {static_cast<float>(places.size()), 0, 0, 0},
                    .x = static_cast<std::int32_t>(north * kPerMetre),
                    .y = static_cast<std::int32_t>(east * kPerMetre)};
      item.command = command;
      items.push_back(item);
    }
    corners.assign(items.size(), {});
    fence = Fence(corners);
    fence.set(items);
    fence.locate({});
  }

  /// The closed courses of a boat that stops within 5 m.
  std::uint16_t closed(double north_m, double east_m) const {
    const Configuration::Stopping stopping{1.0F, 0.125F, 0.0F};
    return FenceWatch::closed_courses(fence, {north_m, east_m, {}}, stopping, core::Q16(1));
  }
  bool is_closed(double north_m, double east_m, unsigned course) const {
    return (closed(north_m, east_m) >> course & 1U) != 0;
  }
};

const std::vector<std::array<int, 2>> kSquare{{-50, -50}, {-50, 50}, {50, 50}, {50, -50}};

TEST_CASE("well inside its fence, or without one, no course is closed to a boat") {
  Fenced boat(mav::kFenceInclusion, kSquare);
  CHECK(boat.closed(0, 0) == 0);
  CHECK(boat.closed(39, 0) == 0);
  CHECK(boat.closed(41, 0) != 0);
  boat.fence.enable(false);
  CHECK(boat.closed(41, 0) == 0);
}

TEST_CASE("beside an edge the courses that cross it are closed, and no others") {
  const Fenced boat(mav::kFenceInclusion, kSquare);
  CHECK(boat.closed(49, 0) ==
        (1U << 14 | 1U << 15 | 1U << 0 | 1U << 1 | 1U << 2 | 1U << 3 | 1U << 13));
  CHECK(boat.is_closed(0, 45, kEast));
  CHECK_FALSE(boat.is_closed(0, 45, kWest));
  CHECK_FALSE(boat.is_closed(0, 45, kNorth));
  CHECK(boat.is_closed(-45, -45, kSouth));
  CHECK(boat.is_closed(-45, -45, kWest));
}

TEST_CASE("a thin wall closes the courses through it") {
  Fenced boat(mav::kFenceInclusion, kSquare);
  boat.add(mav::kFenceExclusion, {{5, -10}, {5, 10}, {6, 10}, {6, -10}});
  CHECK(boat.is_closed(0, 0, kNorth));
  CHECK_FALSE(boat.is_closed(0, 0, kSouth));
}

TEST_CASE("outside its fence a boat may come nearer to it, but not go farther out") {
  const Fenced boat(mav::kFenceInclusion, kSquare);
  CHECK(boat.is_closed(60, 0, kNorth));
  CHECK_FALSE(boat.is_closed(60, 0, kSouth));
}

/// In the choice of a velocity: the same courses.
TEST_CASE("a velocity belongs to the nearest of the courses") {
  for (unsigned course = 0; course < core::kCourses; ++course) {
    for (const double off : {-0.19, 0.0, 0.19}) {
      const auto w =
          core::to_north_east(0.39269908169872414 * course + off, core::Vec2<double>{0.3, 0});
      CHECK(core::is_closed(static_cast<std::uint16_t>(1U << course), w));
      CHECK_FALSE(core::is_closed(static_cast<std::uint16_t>(~(1U << course)), w));
    }
  }
  CHECK_FALSE(core::is_closed(0xFFFF, core::Vec2<double>{}));
}

}  // namespace
}  // namespace flotilla::app
