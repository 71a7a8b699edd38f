// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <optional>
#include <string_view>
#include <vector>

#include "app/guidance/fleet_reports.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::uint8_t kOwn = 1, kFollower = 2;

/// A boat that leads, and a follower that sends its reference ten times a second.
struct Fleet {
  FleetReports reports;
  std::int64_t now_us = kSecond_us;
  bool follows = true, speaks = true;
  std::uint8_t root = kOwn;

  Fleet() { reports.configure(kOwn, 100, 30 * kSecond_us); }

  void hear(const link::Message& message, std::uint8_t from = kFollower) {
    reports.hear({{from, 1}, message}, now_us);
  }
  void run(double s, const std::vector<std::uint8_t>& followers = {kFollower}) {
    for (int k = 0; k < static_cast<int>(10 * s); ++k) {
      now_us += kSecond_us / 10;
      link::FormationReference m{};
      m.root = root;
      m.flags = follows ? link::mav::kReferenceFollowed : std::uint8_t{0};
      for (const std::uint8_t follower : followers) {
        if (speaks) hear(m, follower);
      }
      late();
    }
  }
  void in_slot(float value, std::uint8_t from = kFollower) {
    link::NamedValueFloat m{};
    constexpr std::string_view kName = "IN_SLOT";
    std::copy(kName.begin(), kName.end(), m.name.begin());
    m.value = value;
    hear(m, from);
  }
  std::optional<std::uint8_t> late() { return reports.late(now_us); }
};

TEST_CASE("the leader waits for a follower that falls out of its slot, until it is back") {
  Fleet fleet;
  fleet.run(1);
  fleet.in_slot(1);
  CHECK_FALSE(fleet.late());
  fleet.in_slot(0);
  CHECK(fleet.late() == kFollower);
  fleet.run(20);
  fleet.in_slot(0);
  CHECK(fleet.late() == kFollower);
  fleet.in_slot(1);
  CHECK_FALSE(fleet.late());
}

TEST_CASE(
    "the leader waits for at most WP_WAIT_S, and later only as long as the follower was back") {
  Fleet fleet;
  fleet.run(1);
  fleet.in_slot(1);
  fleet.in_slot(0);
  fleet.run(29.5);
  CHECK(fleet.late());
  fleet.run(1);
  fleet.in_slot(0);
  CHECK_FALSE(fleet.late());
  fleet.in_slot(1);
  SUBCASE("it left and came back") {
    fleet.follows = false;
    fleet.run(0.1);
    fleet.follows = true;
    fleet.run(0.1);
    fleet.in_slot(1);
  }
  SUBCASE("it never left") {}
  fleet.in_slot(0);
  fleet.run(0.5);
  CHECK_FALSE(fleet.late());
  fleet.in_slot(1);
  fleet.run(5);
  fleet.in_slot(0);
  CHECK(fleet.late());
  fleet.run(5.2);
  CHECK_FALSE(fleet.late());
}

TEST_CASE("the leader waits for at most WP_WAIT_S for followers that are late in turn") {
  Fleet fleet;
  const std::vector<std::uint8_t> both{2, 3};
  fleet.run(1, both);
  fleet.in_slot(1, 2);
  fleet.in_slot(1, 3);
  int waited_s = 0;
  for (int s = 0; s < 200; ++s) {
    const bool first = s / 10 % 2 == 0;
    fleet.in_slot(first ? 0.0F : 1.0F, 2);
    fleet.in_slot(first ? 1.0F : 0.0F, 3);
    fleet.run(1, both);
    if (fleet.late()) ++waited_s;
  }
  CHECK(waited_s == 30);
  fleet.in_slot(1, 2);
  fleet.in_slot(1, 3);
  fleet.run(20, both);
  fleet.in_slot(0, 2);
  fleet.run(0.1, both);
  CHECK(fleet.late());
  fleet.run(25, both);
  CHECK_FALSE(fleet.late());
  fleet.reports.forget_waits(fleet.now_us);
  CHECK(fleet.late());
}

TEST_CASE("a boat that stays out of its slot does not use up the wait for others") {
  Fleet fleet;
  const std::vector<std::uint8_t> both{2, 3};
  fleet.run(1, both);
  fleet.in_slot(1, 2);
  fleet.in_slot(1, 3);
  fleet.in_slot(0, 2);
  fleet.run(70, both);
  CHECK_FALSE(fleet.late());
  fleet.in_slot(0, 3);
  fleet.run(20, both);
  CHECK(fleet.late() == 3);
}

TEST_CASE("while the plan waits for nobody, no wait is used up") {
  Fleet fleet;
  fleet.run(1);
  fleet.in_slot(1);
  fleet.in_slot(0);
  fleet.run(29);
  for (int tenth = 0; tenth < 150; ++tenth) {
    fleet.reports.forget_waits(fleet.now_us);
    fleet.now_us += kSecond_us / 10;
  }
  fleet.run(0.1);
  fleet.in_slot(0);
  fleet.run(29);
  CHECK(fleet.late() == kFollower);
  fleet.run(1);
  CHECK_FALSE(fleet.late());
}

TEST_CASE("the leader does not wait for a boat that was never in its slot") {
  Fleet fleet;
  fleet.run(1);
  fleet.in_slot(0);
  CHECK_FALSE(fleet.late());
}

TEST_CASE("a boat that takes over waits for boats that were in their slots behind the old leader") {
  constexpr std::uint8_t kParent = 100, kOldRoot = 77, kStranger = 88;
  Fleet fleet;
  fleet.root = kOldRoot;
  fleet.run(1, {kParent, kFollower});
  fleet.in_slot(1);
  fleet.in_slot(0);
  CHECK_FALSE(fleet.late());
  double away_s = 0;
  SUBCASE("it follows at once") {}
  SUBCASE("it coasts meanwhile") {
    fleet.follows = false;
    away_s = 15;
  }
  SUBCASE("it is away for too long") {
    fleet.speaks = false;
    away_s = 21;
  }
  SUBCASE("it follows another root meanwhile") {
    fleet.root = kStranger;
    fleet.run(0.1);
    fleet.in_slot(1);
  }
  fleet.run(away_s);
  const bool away = away_s > 20 || fleet.root == kStranger;
  fleet.follows = fleet.speaks = true;
  fleet.root = kOwn;
  fleet.run(0.1);
  CHECK_FALSE(fleet.late());
  fleet.in_slot(0);
  CHECK(fleet.late().has_value() != away);
}

TEST_CASE("the leader does not wait for a boat that is silent, has left, or follows another") {
  Fleet fleet;
  fleet.run(1);
  fleet.in_slot(1);
  fleet.in_slot(0);
  SUBCASE("silent") {
    fleet.speaks = false;
    fleet.run(3.1);
  }
  SUBCASE("not in FORMATION any more") {
    fleet.follows = false;
    fleet.run(0.1);
  }
  SUBCASE("behind another root") {
    fleet.root = 77;
    fleet.run(0.1);
  }
  CHECK_FALSE(fleet.late());
}

TEST_CASE("WP_WAIT_S 0: the leader does not wait") {
  Fleet fleet;
  fleet.reports.configure(kOwn, 100, 0);
  fleet.run(1);
  fleet.in_slot(1);
  fleet.in_slot(0);
  CHECK_FALSE(fleet.late());
}

TEST_CASE("three armed heartbeats in a row from the leader announce its return") {
  Fleet fleet;
  link::Heartbeat beat{};
  beat.custom_mode = 11;
  beat.type = link::mav::kTypeSurfaceBoat;
  beat.base_mode = link::mav::kModeFlagCustom | link::mav::kModeFlagArmed;
  fleet.hear(beat, 50);
  CHECK_FALSE(fleet.reports.leader_returns(fleet.now_us));
  for (int heard = 1; heard <= 3; ++heard) {
    fleet.hear(beat, 100);
    CHECK(fleet.reports.leader_returns(fleet.now_us) == (heard == 3));
  }
  CHECK_FALSE(fleet.reports.leader_returns(fleet.now_us + 3 * kSecond_us));
  SUBCASE("another mode") { beat.custom_mode = 10; }
  SUBCASE("disarmed") { beat.base_mode = link::mav::kModeFlagCustom; }
  fleet.hear(beat, 100);
  CHECK_FALSE(fleet.reports.leader_returns(fleet.now_us));
}

}  // namespace
}  // namespace flotilla::app
