// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "app/operator/services/mission_service.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
const link::GpsGlobalOrigin kOrigin{410'000'000, 20'000'000, 0, 0};

/// An item at about these metres from the origin.
convert::GlobalPoint point(double north_m, double east_m) {
  return {kOrigin.latitude + static_cast<std::int32_t>(std::lround(north_m / 0.01111)),
          kOrigin.longitude + static_cast<std::int32_t>(std::lround(east_m / 0.0084))};
}

PlanItem item(std::uint16_t command, double north_m, double east_m, float param = 0) {
  const auto at = point(north_m, east_m);
  return {{param}, at.latitude, at.longitude, 0, command, 6, 1};
}

struct Kept {
  std::array<PlanItem, 5> plan, fence, rally, incoming;
  std::array<Fence::Place, 5> corners;
  MissionService service{{{plan, fence, rally}, incoming, corners}, false};
  PlanDefaults defaults{.speed_mps = 0.5F, .radius_m = 2, .margin_m = 1};
  std::optional<float> fence_m{};

  void store(Stored kind, const std::vector<PlanItem>& items) {
    REQUIRE_FALSE(service.restore(kind, items, defaults));
  }
  convert::GlobalPoint back_from(double north_m, double east_m) {
    return service.return_place({north_m, east_m, kOrigin}, point(1000, 1000), defaults, fence_m);
  }
};

bool same(const convert::GlobalPoint& a, const convert::GlobalPoint& b) {
  return a.latitude == b.latitude && a.longitude == b.longitude;
}

TEST_CASE("a boat returns to the nearest rally point, or home if there is none") {
  Kept kept;
  CHECK(same(kept.back_from(0, 0), point(1000, 1000)));
  kept.store(Stored::kRally, {item(mav::kRallyPoint, 50, 0), item(mav::kRallyPoint, 0, 30)});
  CHECK(same(kept.back_from(0, 0), point(0, 30)));
  CHECK(same(kept.back_from(40, 0), point(50, 0)));
}

TEST_CASE("a boat does not return to a rally point beyond FS_FENCE_M from home") {
  Kept kept;
  kept.store(Stored::kRally, {item(mav::kRallyPoint, 50, 0), item(mav::kRallyPoint, 990, 980)});
  kept.fence_m = 100.0F;
  CHECK(same(kept.back_from(40, 0), point(990, 980)));
  kept.fence_m = 10.0F;
  CHECK(same(kept.back_from(40, 0), point(1000, 1000)));
}

TEST_CASE("a stored plan is kept even if LAW_U_MAX or WP_RADIUS is now less") {
  Kept kept;
  kept.defaults.fastest_mps = 0.6F;
  kept.defaults.radius_m = 0.5F;
  PlanItem speed{};
  speed.command = mav::kDoChangeSpeed;
  speed.param[1] = 1.2F;
  kept.store(Stored::kPlan,
             {item(mav::kNavWaypoint, 0, 0), speed, item(mav::kNavLoiterTurns, 9, 0, 1)});
  CHECK(kept.service.plan().size() == 3);
}

TEST_CASE(
    "a rally point with a free straight path is preferred; one outside the fence is never used") {
  Kept kept;
  kept.service.locate(kOrigin);
  kept.store(Stored::kRally, {item(mav::kRallyPoint, 50, 0), item(mav::kRallyPoint, 0, 30)});
  kept.store(Stored::kFence, {item(mav::kFenceCircleExclusion, 0, 15, 5)});
  CHECK(same(kept.back_from(0, 0), point(50, 0)));
  kept.store(Stored::kFence, {item(mav::kFenceCircleExclusion, 50, 0, 5)});
  CHECK(same(kept.back_from(40, 0), point(0, 30)));
  kept.store(Stored::kFence, {item(mav::kFenceCircleInclusion, -100, -100, 20)});
  CHECK(same(kept.back_from(0, 0), point(1000, 1000)));
  kept.store(Stored::kFence, {item(mav::kFenceCircleExclusion, 500, 500, 400)});
  CHECK(same(kept.back_from(950, 950), point(1000, 1000)));  // straight, unlike the rally points
}

TEST_CASE(
    "a target and the path to it keep the margin, but a boat at the fence's edge may sail inward") {
  Kept kept;
  kept.service.locate(kOrigin);
  kept.store(Stored::kFence, {item(mav::kFenceCircleInclusion, 0, 0, 20)});
  const auto refusal = [&](double north_m, double to_m) {
    return std::string(
        kept.service.fence().refusal_of(convert::Position{north_m, 0, kOrigin}, point(to_m, 0), 2));
  };
  CHECK(refusal(0, 17).empty());
  CHECK(refusal(0, 18.5) == "too near the fence");
  CHECK(refusal(0, 21) == "outside the fence");
  CHECK(refusal(19.5, 0).empty());
  CHECK(refusal(21, 0) == "the boat is outside the fence");
  CHECK(refusal(0, 4100) == "over 4 km from the fence");
}

TEST_CASE("a boat that is sent to a delay is judged by the way to the place after it") {
  Kept kept;
  PlanItem delay{};
  delay.command = mav::kNavDelay;
  kept.store(Stored::kPlan,
             {item(mav::kNavWaypoint, 0, 0), delay, item(mav::kNavWaypoint, 0, 1500)});
  const auto refusal = [&](double east_m) {
    return std::string(kept.service.refusal_of_way({0, east_m, kOrigin}, 1, kept.defaults));
  };
  CHECK(refusal(-1300).empty());
  CHECK(refusal(-1500) == "too far away");
}

/// All points of a plan of MissionService, from its current item on.
std::vector<PlanPoint> points_of(const MissionService& service, const PlanDefaults& defaults) {
  PlanReader reader;
  reader.begin({service.current(), point(-50, 0), {}, service.progress()}, defaults);
  std::vector<PlanPoint> points;
  while (const auto point = reader.next(service.plan())) points.push_back(*point);
  return points;
}

TEST_CASE("a plan that is stopped on the way to any place goes on as it would have") {
  const auto bare = [](std::uint16_t command, float param1, float param2) {
    return PlanItem{{param1, param2}, 0, 0, 0, command, 2, 1};
  };
  const std::vector<PlanItem> plan{
      item(mav::kNavWaypoint, 0, 0),      item(mav::kNavWaypoint, 50, 0),
      bare(mav::kDoChangeSpeed, 1, 0.3F), item(mav::kNavLoiterTurns, 50, 50, 0.5F),
      bare(mav::kDoJump, 1, 2),           item(mav::kNavWaypoint, 0, 50),
      bare(mav::kDoChangeSpeed, 1, -2),   bare(mav::kDoJump, 0, 1),
      item(mav::kNavWaypoint, -50, 0)};
  std::array<PlanItem, 9> stored, incoming;
  MissionService service{{{stored, {}, {}}, incoming, {}}, false};
  const PlanDefaults defaults{.speed_mps = 0.5F, .radius_m = 2};
  REQUIRE_FALSE(service.restore(Stored::kPlan, plan, defaults));
  const std::vector<PlanPoint> all = points_of(service, defaults);
  REQUIRE(all.size() == 2 * (1 + 3 * 6 + 1) + 1);
  for (std::size_t i = 0; i < all.size(); ++i) {
    CAPTURE(i);
    service.sailed(all[i].mark, false);
    const bool in_circle = i > 0 && all[i].mark.item == all[i - 1].mark.item;
    if (in_circle) continue;  // the boat sails the whole circle again
    const auto rest = points_of(service, defaults);
    REQUIRE(rest.size() == all.size() - i);
    for (std::size_t k = 0; k < rest.size(); ++k) {
      CHECK(rest[k].mark.item == all[i + k].mark.item);
      CHECK(rest[k].mark.jumps == all[i + k].mark.jumps);
      CHECK(rest[k].speed_mps == all[i + k].speed_mps);
    }
  }
  service.sailed(all.back().mark, true);
  CHECK(points_of(service, defaults).size() == all.size());
}

}  // namespace
}  // namespace flotilla::app
