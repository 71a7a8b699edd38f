// SPDX-License-Identifier: MIT
// Hundreds of meetings of two vessels; test_separation.cpp has single ones.
#include <algorithm>
#include <cmath>

#include "core/sailor.hpp"

namespace flotilla::core {
namespace {

using testing::kMin;
using testing::leader_at;
using testing::only;
using testing::Random;
using testing::Sailor;

TEST_CASE("in 200 chance meetings of two boats the one that yields keeps away, and both arrive") {
  constexpr std::uint32_t kSeed = 75;
  INFO("seed ", kSeed);
  Random random(kSeed);
  double closest = 1e9;
  int nearer_without = 0;
  for (int run = 0; run < 200; ++run) {
    const double bearing = random.angle(), psi = random.angle();
    const double c = std::cos(bearing), s = std::sin(bearing);
    for (const bool looks : {false, true}) {
      // The second boat's slot is on the far side of the first boat's.
      Sailor first({0, 0, 0, 0, 0, 0}), second({8 * c, 8 * s, psi, 0, 0, 0});
      double least = 1e9;
      for (int k = 0; k < 6000; ++k) {
        const auto to_first = only(second.seen_by(first, false));
        const auto to_second = only(first.seen_by(second, true));
        const double t = first.h * k;
        first.sail(leader_at(0.5 * t, 0), looks ? to_first : Traffic<double>{});
        second.sail(leader_at(0.5 * t - 3 * c, -3 * s), looks ? to_second : Traffic<double>{});
        least = std::min(least, length(minus(first.place(), second.place())));
      }
      if (looks) {
        closest = std::min(closest, least);
        CHECK(std::hypot(first.out.error.e.x, first.out.error.e.y) < 0.05);
        CHECK(std::hypot(second.out.error.e.x, second.out.error.e.y) < 0.05);
      } else if (least < kMin) {
        ++nearer_without;
      }
    }
  }
  MESSAGE("closest ", closest, " m; too near without: ", nearer_without);
  CHECK(closest > kMin);
  CHECK(nearer_without > 20);
}

/// A vessel that keeps its course and speed past a boat in a slot that moves north.
struct Encounter {
  double slot_mps;
  Vec2<double> there, v;
};

/// Least distance, and whether the boat crossed ahead of the vessel's bow.
struct Passing {
  double least = 1e9;
  bool ahead = false, arrived = false;
};

Passing pass(const Encounter& met) {
  Sailor boat({0, 0, 0, met.slot_mps, 0, 0});
  Passing out;
  double side = 0;
  for (int k = 0; k < 12'000; ++k) {
    const double t = boat.h * k, speed = length(met.v);
    const Vec2<double> ship = {met.there.x + t * met.v.x, met.there.y + t * met.v.y};
    const Vec2<double> to = minus(ship, boat.place());
    const double was = side;
    side = met.v.x * -to.y + met.v.y * to.x;
    const double along = -dot(to, met.v) / speed;
    if (was * side < 0 && 0 < along && along < 12) out.ahead = true;
    out.least = std::min(out.least, length(to));
    boat.sail(leader_at(met.slot_mps * t, 0, met.slot_mps), only({to, met.v, 0, true, true}));
  }
  out.arrived = std::hypot(boat.out.error.e.x, boat.out.error.e.y) < 0.1;
  return out;
}

TEST_CASE(
    "a stranger that comes from starboard is passed astern, and one bow to bow port to port") {
  constexpr std::uint32_t kSeed = 77;
  INFO("seed ", kSeed);
  Random random(kSeed);
  int ahead = 0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    // They would meet after that time.
    const double slot = random(0.3, 1.1), speed = random(0.4, 1.8), t = random(8, 15);
    const double course = random(-testing::kPi, -1.2);  // from starboard; neither vessel overtakes
    const Vec2<double> v = {speed * std::cos(course), speed * std::sin(course)};
    const Passing met = pass({slot, {(slot - v.x) * t, -v.y * t}, v});
    CHECK(met.least > kMin);
    CHECK(met.arrived);
    if (met.ahead) ++ahead;
  }
  MESSAGE("crossed ahead in ", ahead, " of ", kRuns);
  CHECK(ahead == 0);
  const Passing bow_to_bow = pass({0.8, {20, 0.2}, {-0.8, 0}});
  CHECK((bow_to_bow.least > kMin && bow_to_bow.arrived));
}

}  // namespace
}  // namespace flotilla::core
