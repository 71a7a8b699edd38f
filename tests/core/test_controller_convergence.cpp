// SPDX-License-Identifier: MIT
// The product's default law behind leaders of all kinds, from any start.
#include "core/piloted_boat.hpp"

namespace flotilla::core {
namespace {

using testing::PilotedBoat;
using testing::Random;
using testing::Sighting;

constexpr double kH = 0.02;  // CTL_RATE 50

struct Sea {
  testing::Thrusting leader = testing::s_curve;
  double seconds = 120;
  Vec2<double> current{};  ///< of the boat; the leader is virtual
  double T_max = 20;
  Vec2<double> slot{};
  bool turns = false;
};

/// Any place within 20 m, any heading, any speed that the vessel reaches with 3 N.
template <class S>
PilotedBoat<S> anywhere(Random& random, const Sea& sea) {
  PilotedBoat<S> boat;
  boat.hull = {
      {random(-20, 20), random(-20, 20), random.angle(), random(-1.7, 1.7), 0, random(-1, 1)},
      sea.current};
  return boat;
}

double distance(const testing::Hull& hull, const Sighting& leader, const Sea& sea) {
  const Vec2<double> d = sea.turns ? to_north_east(leader.psi, sea.slot) : sea.slot;
  return std::hypot(hull.q[0] - leader.place.x - d.x, hull.q[1] - leader.place.y - d.y);
}

/// Number of boats that are not within 0.05 m of their slot at the end; `watch` is called in each
/// tick of each boat.
template <class S, class Watch>
int astray(std::uint32_t seed, int boats, const Sea& sea, Watch watch) {
  Random random(seed);
  auto params = testing::products_law<S>(sea.T_max);
  params.law.slot.d = {S(sea.slot.x), S(sea.slot.y)};
  params.law.slot.turns = sea.turns;
  const auto leader = testing::voyage(sea.leader, kH, sea.seconds);
  int out = 0;
  for (int i = 0; i < boats; ++i) {
    PilotedBoat<S> boat = anywhere<S>(random, sea);
    double off = 0;
    for (std::size_t k = 0; k < leader.size(); ++k) {
      off = distance(boat.hull, leader[k], sea);
      watch(i, static_cast<double>(k) * kH, boat.hull);
      boat.tick(params, leader[k], kH);
    }
    out += !(off < 0.05);
  }
  return out;
}

template <class S>
int astray(std::uint32_t seed, int boats, const Sea& sea) {
  return astray<S>(seed, boats, sea, [](int, double, const testing::Hull&) {});
}

TEST_CASE("behind the S-curve, all of 1,000 boats that start anywhere come to their slots") {
  constexpr std::uint32_t kSeed = 61;
  INFO("seed ", kSeed);
  CHECK(astray<float>(kSeed, 1000, {}) == 0);
  CHECK(astray<double>(kSeed, 200, {.seconds = 60}) == 0);
}

TEST_CASE_TEMPLATE("boats behind a leader that never turns come to their slots", S, float, double) {
  constexpr std::uint32_t kSeed = 62;
  INFO("seed ", kSeed);
  CHECK(astray<S>(kSeed, 100, {.leader = [](double) { return Tau<double>{2, 0}; }}) == 0);
}

TEST_CASE_TEMPLATE(
    "boats behind a leader on a circle come to their slots, also to those that turn with it", S,
    float, double) {
  constexpr std::uint32_t kSeed = 63;
  INFO("seed ", kSeed);
  Sea sea{.leader = [](double) { return Tau<double>{2, 0.15}; }};
  CHECK(astray<S>(kSeed, 100, sea) == 0);
  sea.slot = {-1.5, -1.5};
  sea.turns = true;
  CHECK(astray<S>(kSeed, 100, sea) == 0);
}

TEST_CASE_TEMPLATE("no boat circles a leader that stops for a minute, and all follow it afterwards",
                   S, float, double) {
  constexpr std::uint32_t kSeed = 64;
  INFO("seed ", kSeed);
  const auto stops = [](double t) {
    return 15 <= t && t < 75 ? Tau<double>{} : testing::s_curve(t);
  };
  double turned = 0, psi_stopped = 0;
  const auto watch = [&](int, double t, const testing::Hull& hull) {
    if (t < 15) psi_stopped = hull.q[2];
    if (15 <= t && t < 75) turned = std::max(turned, std::abs(hull.q[2] - psi_stopped));
  };
  CHECK(astray<S>(kSeed, 100, {.leader = stops, .seconds = 120}, watch) == 0);
  CHECK(turned < 2 * testing::kPi);
}

TEST_CASE_TEMPLATE("a cross current of 0.1 m/s carries no boat away", S, float, double) {
  constexpr std::uint32_t kSeed = 65;
  INFO("seed ", kSeed);
  CHECK(astray<S>(kSeed, 100, {.current = {0, 0.1}}) == 0);
}

TEST_CASE_TEMPLATE("boats with propellers of 3 N come to their slots later", S, float, double) {
  constexpr std::uint32_t kSeed = 66;
  INFO("seed ", kSeed);
  CHECK(astray<S>(kSeed, 100, {.T_max = 3}) == 0);
}

}  // namespace
}  // namespace flotilla::core
