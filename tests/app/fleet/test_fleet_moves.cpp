// SPDX-License-Identifier: MIT
// Changes of shape: which boat assigns the places, and how all boats move to them.
#include <doctest/doctest.h>

#include <array>
#include <cmath>

#include "app/fleet/harbour.hpp"

namespace flotilla::app {
namespace {

using testing::Boat;
using testing::Harbour;
using testing::kOperator;
using testing::table_of_four;
using testing::under_way;

TEST_CASE("a new shape moves all slots together, at the speed that the law receives") {
  Harbour harbour = under_way();
  FleetTable next = table_of_four(2);
  next.move_ds = 100;
  next.members[3].slot_cm = {-1200, 800};
  harbour.hear(3, message_of(next, 1000), kOperator);
  harbour.sail(6);
  CHECK(harbour.applied(1).FORM_OFS_N == -4);
  CHECK(harbour.applied(2).FORM_OFS_N == -4);  // behind boat 2
  CHECK(harbour.applied(3).FORM_OFS_N == -12);
  CHECK(harbour.applied(3).FORM_OFS_E == doctest::Approx(4).epsilon(0.1));
  CHECK(harbour.boats[3].fleet.slot_motion().mps[1] == doctest::Approx(1.2).epsilon(0.05));
  CHECK(harbour.boats[3].fleet.slot_motion().soon_mps[1] == doctest::Approx(0.94).epsilon(0.05));
  CHECK(harbour.boats[2].fleet.slot_motion().mps[1] == 0);
  for (const Boat& boat : harbour.boats) CHECK(boat.fleet.moves(harbour.now_us + boat.clock_us));
  harbour.sail(20);
  for (const Boat& boat : harbour.boats) {
    CHECK_FALSE(boat.fleet.moves(harbour.now_us + boat.clock_us));
  }
  CHECK(harbour.applied(3).FORM_OFS_E == 8);
  CHECK(harbour.boats[3].fleet.slot_motion().mps[1] == 0);
}

TEST_CASE("a request to assign slots: the boat that hears it does so, and all agree") {
  Harbour harbour = under_way();
  FleetTable wish = table_of_four(2);
  wish.assigns = true;
  wish.members[1].slot_cm = {-1200, 100};
  wish.members[2].slot_cm = {-400, 100};
  wish.members[3].slot_cm = {-800, 100};
  harbour.hear(2, message_of(wish, 0), {9, 1});
  harbour.sail(3);
  CHECK(harbour.applied(3).FORM_OFS_E == 0);  // only an operator may give orders
  harbour.hear(2, message_of(wish, 0), kOperator);
  harbour.sail(30);
  CHECK(harbour.applied(1).FORM_OFS_N == -4);
  CHECK(harbour.applied(2).FORM_OFS_N == -4);  // behind boat 2
  CHECK(harbour.applied(3).FORM_OFS_N == -12);
  for (std::size_t i : {1U, 3U}) CHECK(harbour.applied(i).FORM_OFS_E == 1);
  wish.members[3].slot_cm = {-800, 900};
  harbour.hear(1, message_of(wish, 0), kOperator);  // an epoch that all boats have
  harbour.sail(30);
  CHECK(harbour.applied(3).FORM_OFS_E == 1);
}

TEST_CASE(
    "the leader assigns slots if it heard the request; otherwise the boats that heard it do so") {
  Harbour harbour = under_way();
  FleetTable wish = table_of_four(2);
  wish.assigns = true;
  wish.members[3].slot_cm = {-1200, 1500};
  for (std::size_t i = 1; i < 4; ++i) harbour.boats[i].most_mps = 0.9F;  // their tables differ
  for (std::size_t i = 0; i < 4; ++i) harbour.hear(i, message_of(wish, 1000), kOperator);
  harbour.sail(4);
  const auto moves = [&](std::size_t i) {
    return harbour.boats[i].fleet.moves(harbour.now_us + harbour.boats[i].clock_us);
  };
  for (std::size_t i = 0; i < 4; ++i) CHECK(moves(i));
  harbour.sail(14 + 15);
  for (std::size_t i = 0; i < 4; ++i) CHECK_FALSE(moves(i));  // 15 m at 1.3 m/s, not 0.6
  wish.epoch = 3;
  wish.members[3].slot_cm = {-1200, 0};
  harbour.hear(2, message_of(wish, 0), kOperator);
  harbour.sail(4);
  CHECK(moves(2));
  CHECK(harbour.applied(3).FORM_OFS_E < 15);
}

TEST_CASE("a boat without a table leaves the assignment of slots to boats that have one") {
  Harbour harbour = under_way();
  FleetTable wish = table_of_four(2);
  wish.assigns = true;
  wish.members[3].slot_cm = {-1200, 1500};
  wish.members[4] = {.system = 5, .leader = 1, .length_dm = 13, .slot_cm = {-2000, 0}};
  wish.count = 5;
  for (const std::uint8_t system : {std::uint8_t{5}, std::uint8_t{6}}) {
    harbour.boats.push_back({.system = system, .state = core::State::kFormation});
  }
  for (std::size_t i = 6; i-- > 0;) harbour.hear(i, message_of(wish, 1000), kOperator);
  harbour.sail(6);
  for (std::size_t i = 0; i < 5; ++i) CHECK(harbour.boats[i].moves(harbour.now_us));
  CHECK(harbour.leader_of(4) == 1);
}

TEST_CASE("assigned slots that are too close for the hulls are refused, as in any table") {
  Harbour harbour = under_way();
  FleetTable wish = table_of_four(2);
  wish.assigns = true;
  wish.members[0].slot_cm = {0, 5000};
  wish.members[1] = {.system = 2, .leader = 1, .length_dm = 13, .slot_cm = {-800, 0}};
  wish.members[2] = {.system = 3, .leader = 1, .length_dm = 60, .slot_cm = {5000, 0}};
  wish.members[3] = {.system = 4, .leader = 1, .length_dm = 60, .slot_cm = {-1200, 0}};
  harbour.hear(0, message_of(wish, 0), kOperator);
  harbour.sail(3);
  const auto refused = harbour.boats[0].fleet.take_refusal();
  REQUIRE(refused);
  CHECK(refused->fault == TableFault::kTooClose);
  CHECK(harbour.boats[0].fleet.take_epoch() == 1);
}

TEST_CASE("a boat that gets a table late is in step with the others") {
  for (const double late_s : {1.0, 3.0, 6.0, 9.0}) {
    CAPTURE(late_s);
    Harbour harbour = under_way();
    FleetTable next = table_of_four(2);
    next.move_ds = 200;
    next.members[3].slot_cm = {-1200, 1200};
    const Harbour start = harbour;
    const auto sail = [&](double silent_s) {
      harbour.hear(0, message_of(next, 0), kOperator);
      harbour.boats[3].on = false;
      harbour.sail(silent_s);
      harbour.boats[3].on = true;
      harbour.sail(13 - silent_s);
      return harbour.applied(3).FORM_OFS_E;
    };
    const float late = sail(late_s);
    harbour = start;
    CHECK(std::abs(late - sail(0)) < 0.3);  // a radio's delay and 0.2 s between two places
  }
}

TEST_CASE("a shape that changes again under way: slots and speeds continue without a step") {
  for (const double after_s : {1.5, 3.0, 7.0, 11.9, 14.0}) {
    CAPTURE(after_s);
    Harbour harbour = under_way();
    FleetTable next = table_of_four(2);
    next.move_ds = 150;
    next.members[3].slot_cm = {-1200, 1200};
    harbour.hear(0, message_of(next, 0), kOperator);
    harbour.sail(after_s);
    next.epoch = 3;
    next.members[3].slot_cm = {-2200, 400};
    harbour.hear(0, message_of(next, 2000), kOperator);
    const auto place = [&] {
      const Parameters p = harbour.applied(3);
      return std::array{p.FORM_OFS_N, p.FORM_OFS_E};
    };
    auto before = place();
    auto speed = harbour.boats[3].fleet.slot_motion().mps;
    for (int step = 0; step < 95; ++step) {
      harbour.sail(0.2);
      const auto now = place(), mps = harbour.boats[3].fleet.slot_motion().mps;
      for (std::size_t axis = 0; axis < 2; ++axis) {
        CHECK(std::abs(mps[axis] - speed[axis]) < 0.15);
        CHECK(std::abs(now[axis] - before[axis] - 0.1F * (mps[axis] + speed[axis])) < 0.03F);
      }
      before = now;
      speed = mps;
    }
    CHECK(before == std::array{-22.0F, 4.0F});
  }
}

}  // namespace
}  // namespace flotilla::app
