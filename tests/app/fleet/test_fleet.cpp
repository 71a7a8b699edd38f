// SPDX-License-Identifier: MIT
// A fleet with a table: which boats hold it, which boat leads, which boats stop.
#include <doctest/doctest.h>

#include "app/fleet/harbour.hpp"

namespace flotilla::app {
namespace {

using testing::Boat;
using testing::Harbour;
using testing::kOperator;
using testing::table_of_four;
using testing::under_way;

TEST_CASE("without a fleet table nothing is sent and nothing changes") {
  Harbour harbour;
  harbour.sail(10);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(harbour.boats[i].bytes == 0);
    CHECK_FALSE(harbour.boats[i].fleet.take_change());
    CHECK(harbour.leader_of(i) == 100);
  }
}

TEST_CASE(
    "a table sent to one boat comes into force on all at one instant, despite clock offsets") {
  Harbour harbour;
  harbour.hear(2, message_of(table_of_four(1), 3000), kOperator);
  harbour.sail(2.9);
  for (std::size_t i = 0; i < 4; ++i) CHECK(harbour.leader_of(i) == 100);
  harbour.sail(0.2);
  CHECK(harbour.leader_of(1) == 1);
  CHECK(harbour.leader_of(2) == 2);
  CHECK(harbour.leader_of(3) == 1);
  CHECK(harbour.applied(2).FORM_OFS_N == -4);
  CHECK(harbour.applied(3).FORM_OFS_N == -12);
  CHECK(harbour.applied(3).FORM_FRAME == 0);
}

TEST_CASE("a boat left out of a new table receives that table, stops, and does not take over") {
  Harbour harbour = under_way();
  FleetTable next = table_of_four(2);
  next.members[1] = next.members[3];
  next.members[2].leader = 1;
  next.count = 3;
  harbour.boats[1].on = false;
  for (const std::size_t i : {0U, 2U, 3U}) harbour.hear(i, message_of(next, 0), kOperator);
  harbour.sail(0.5);
  harbour.boats[1].on = true;
  harbour.sail(4);
  CHECK(harbour.boats[1].fleet.take_epoch() == 2);
  harbour.sail(20);
  CHECK(harbour.boats[1].state == core::State::kHold);
  CHECK(harbour.boats[0].state == core::State::kAuto);
}

TEST_CASE("two boats lead while a table is pending: the higher rank keeps the lead") {
  Harbour harbour = under_way();
  harbour.boats[0].state = core::State::kHold;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == core::State::kAuto);
  harbour.hear(0, message_of(table_of_four(2), 9000), kOperator);
  harbour.sail(3);
  harbour.boats[0].state = core::State::kAuto;
  harbour.sail(3);
  CHECK(harbour.boats[0].state == core::State::kAuto);
  CHECK(harbour.boats[1].state == core::State::kFormation);
  CHECK(harbour.leader_of(1) == 1);
}

TEST_CASE("a boat that was away while the table changed gets it within three seconds") {
  Harbour harbour;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(3);
  harbour.boats[3].on = false;
  FleetTable next = table_of_four(2);
  next.members[3].slot_cm = {0, 800};
  harbour.hear(0, message_of(next, 0), kOperator);
  harbour.sail(5);
  CHECK(harbour.applied(3).FORM_OFS_E == 0);
  harbour.boats[3].on = true;
  harbour.sail(3);
  CHECK(harbour.applied(3).FORM_OFS_E == 8);
}

TEST_CASE(
    "a boat that all others hear, but that hears only one of them, gets the newest table too") {
  Harbour harbour = under_way();
  harbour.boats[3].on = false;
  harbour.hear(0, message_of(table_of_four(2), 0), kOperator);
  harbour.sail(5);
  harbour.boats[3].on = true;
  harbour.boats[3].hears = 3;
  harbour.sail(10);
  CHECK(harbour.boats[3].fleet.take_epoch() == 2);
}

TEST_CASE("a boat that restarts without a table asks for it") {
  Harbour harbour;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(3);
  harbour.boats[2].fleet = Fleet{};
  harbour.sail(4);
  CHECK(harbour.leader_of(2) == 2);
}

TEST_CASE("leader silent: the next boat leads within two seconds, all others follow it") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == core::State::kAuto);
  CHECK(harbour.boats[1].fleet.place().plan_id == 77);
  CHECK(harbour.leader_of(2) == 2);
  CHECK(harbour.leader_of(3) == 2);
  CHECK(harbour.applied(3).FORM_OFS_N == -8);
}

TEST_CASE("leader silent: the next boat leads soon though the radio loses eight reports in a row") {
  Harbour harbour = under_way();
  harbour.boats[3].lost_reports = 8;
  harbour.boats[0].on = false;
  harbour.sail(2.2);
  CHECK(harbour.boats[3].lost_reports == 0);
  CHECK(harbour.boats[1].state == core::State::kAuto);
}

TEST_CASE("after a stop no boat takes over until a boat has led again") {
  Harbour harbour = under_way();
  for (Boat& boat : harbour.boats) boat.state = core::State::kHold;
  harbour.sail(2);
  for (std::size_t i = 1; i < 4; ++i) harbour.boats[i].state = core::State::kFormation;
  harbour.sail(5);
  for (std::size_t i = 1; i < 4; ++i) CHECK(harbour.boats[i].state == core::State::kFormation);
  harbour.boats[0].state = core::State::kAuto;
  harbour.sail(3);
  harbour.boats[0].on = false;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == core::State::kAuto);
}

TEST_CASE("another component with a dead leader's system id does not keep it alive") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  for (int tenth = 0; tenth < 20; ++tenth) {
    for (std::size_t who = 1; who < 4; ++who) harbour.hear(who, link::Attitude{}, {1, 100});
    harbour.sail(0.1);
  }
  CHECK(harbour.boats[1].state == core::State::kAuto);
}

TEST_CASE("a beacon delayed by a slower link does not depose the leader") {
  for (const std::uint8_t late : {std::uint8_t{99}, std::uint8_t{250}}) {
    for (const std::uint8_t system : {std::uint8_t{1}, std::uint8_t{2}}) {
      CAPTURE(late);
      CAPTURE(system);
      Harbour harbour = under_way();
      link::FleetBeacon beacon{};
      beacon.epoch = 1;
      beacon.digest = table_of_four(1).digest;
      beacon.plan_id = 77;
      const auto hear = [&](std::uint8_t flags, std::uint8_t sequence) {
        beacon.flags = flags;
        beacon.sequence = sequence;
        for (std::size_t who = 0; who < 4; ++who) {
          if (who + 1 != system) harbour.hear(who, beacon, {system, 1});
        }
      };
      hear(system == 1 ? 3 : 1, static_cast<std::uint8_t>(late + 20));  // fit; boat 1 leads
      hear(0, late);
      for (int tick = 0; tick < 100; ++tick) {
        harbour.sail(0.01);
        CHECK(harbour.boats[1].order == FleetOrder::kNone);
        CHECK(harbour.leader_of(1) == 1);
        CHECK(harbour.leader_of(2) == 2);
      }
      harbour.boats[system - 1].state = core::State::kHold;  // its own beacons have smaller numbers
      harbour.sail(5);
      CHECK(harbour.leader_of(2) == (system == 1 ? 2 : 1));
      CHECK((harbour.boats[1].state == core::State::kAuto) == (system == 1));
    }
  }
}

TEST_CASE("a member that leads by a table unknown to all others is followed for only ten seconds") {
  Harbour harbour = under_way();
  harbour.boats[3].on = false;
  link::FleetBeacon beacon{};
  beacon.epoch = 60'000;
  beacon.flags = 3;  // fit, leads
  beacon.plan_id = 77;
  beacon.sequence = 100;
  const auto repeat = [&](int tenths) {
    for (int tenth = 0; tenth < tenths; ++tenth) {
      for (std::size_t who = 0; who < 3; ++who) harbour.hear(who, beacon, {4, 1});
      harbour.sail(0.1);
    }
  };
  repeat(95);
  CHECK(harbour.leader_of(1) == 4);
  CHECK(harbour.leader_of(2) == 2);
  CHECK(harbour.boats[0].state == core::State::kFormation);
  repeat(25);  // the first one leads again
  CHECK(harbour.boats[0].state == core::State::kAuto);
  CHECK(harbour.leader_of(2) == 2);
  CHECK(harbour.leader_of(1) == 1);
  harbour.hear(0, message_of(table_of_four(2), 0), kOperator);
  repeat(50);  // boat 4 is still ignored after a new table
  CHECK(harbour.boats[0].state == core::State::kAuto);
  CHECK(harbour.leader_of(1) == 1);
}

TEST_CASE("a boat that a table makes leader follows none of its followers") {
  Harbour harbour = under_way();
  FleetTable next = table_of_four(2);
  std::swap(next.members[0].system, next.members[1].system);
  next.members[1].leader = next.members[2].leader = next.members[3].leader = 2;
  for (Boat& boat : harbour.boats) boat.state = core::State::kHold;
  harbour.hear(0, message_of(next, 0), kOperator);
  harbour.sail(3);
  CHECK(harbour.leader_of(1) == 100);
  CHECK(harbour.leader_of(0) == 2);
  harbour.boats[1].own.leader = 1;  // the parameters name the same leader
  next.epoch = 3;
  harbour.hear(0, message_of(next, 0), kOperator);
  harbour.sail(3);
  CHECK(harbour.leader_of(1) == 0);
}

TEST_CASE("half of the fleet continues without the leader: it is no majority, so it waits") {
  Harbour harbour = under_way();
  harbour.boats[0].on = harbour.boats[1].on = false;
  harbour.sail(2);
  CHECK(harbour.boats[2].state == core::State::kLoiter);
  CHECK(harbour.leader_of(3) == 3);
}

TEST_CASE("an inner boat in HOLD: its follower follows the boat's leader until the next table") {
  Harbour harbour = under_way();
  harbour.boats[1].state = core::State::kHold;
  harbour.sail(0.2);
  CHECK(harbour.leader_of(2) == 1);
  CHECK(harbour.applied(2).FORM_OFS_N == -8);
  harbour.boats[1].state = core::State::kFormation;
  harbour.sail(5);
  CHECK(harbour.leader_of(1) == 1);
  CHECK(harbour.leader_of(2) == 1);
  harbour.hear(3, message_of(table_of_four(2), 0), kOperator);
  harbour.sail(3);
  CHECK(harbour.leader_of(2) == 2);
}

TEST_CASE("an inner boat that failed before a table came has no followers until it is back") {
  Harbour harbour = under_way();
  harbour.boats[1].on = false;
  harbour.sail(3);
  CHECK(harbour.leader_of(2) == 1);
  harbour.hear(0, message_of(table_of_four(2), 0), kOperator);
  harbour.sail(1);
  REQUIRE(harbour.boats[2].fleet.take_epoch() == 2);
  harbour.sail(2);
  CHECK(harbour.leader_of(2) == 1);
  harbour.boats[1].on = true;
  harbour.sail(3);
  CHECK(harbour.leader_of(2) == 2);
}

/// Boats 1 and 2 do not hear each other.
void part_first_two(Harbour& harbour) {
  harbour.boats[0].deaf_to = 2;
  harbour.boats[1].deaf_to = 1;
}

TEST_CASE("a boat that hears others, but not the leader, follows one that does") {
  Harbour harbour = under_way();
  part_first_two(harbour);
  harbour.boats[0].place.item = 5;
  for (int tick = 0; tick < 1000; ++tick) {
    harbour.sail(0.01);
    REQUIRE(harbour.boats[1].state == core::State::kFormation);
  }
  CHECK(harbour.leader_of(1) == 4);  // which follows the leader; boat 3 follows boat 2
  CHECK(harbour.applied(1).FORM_OFS_N == 8);
  CHECK(harbour.leader_of(2) == 2);
  harbour.hear(0, message_of(table_of_four(2), 0), kOperator);
  for (int tick = 0; tick < 500; ++tick) {
    harbour.sail(0.01);
    REQUIRE(harbour.boats[1].state == core::State::kFormation);
  }
  CHECK(harbour.leader_of(1) == 4);
  CHECK(harbour.boats[1].fleet.place().item == 5);
  harbour.boats[0].on = false;
  harbour.sail(3);
  CHECK(harbour.boats[1].state == core::State::kAuto);
  CHECK(harbour.leader_of(3) == 2);
}

TEST_CASE("two boats that lead and do not hear each other: one yields within two seconds") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(3);
  REQUIRE(harbour.boats[1].state == core::State::kAuto);
  part_first_two(harbour);
  harbour.boats[0].on = true;
  harbour.sail(2);
  CHECK(harbour.boats[0].state == core::State::kAuto);
  CHECK(harbour.boats[1].state == core::State::kFormation);
  harbour.sail(3);
  CHECK(harbour.leader_of(1) == 4);  // which hears the leader
  CHECK(harbour.leader_of(2) == 2);
  CHECK(harbour.leader_of(3) == 1);
}

TEST_CASE(
    "its own leader now leads the fleet, but a boat cannot hear it: it follows a boat that can") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(3);
  REQUIRE(harbour.boats[1].state == core::State::kAuto);
  REQUIRE(harbour.leader_of(2) == 2);
  harbour.boats[2].deaf_to = 2;
  harbour.sail(5);
  CHECK(harbour.leader_of(2) == 4);
}

TEST_CASE(
    "a leader does not yield to one that it can follow neither directly nor by another boat") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(3);
  harbour.boats[3].on = false;
  harbour.sail(3);
  REQUIRE(harbour.boats[1].state == core::State::kAuto);
  part_first_two(harbour);
  harbour.boats[2].state = core::State::kHold;  // hears both
  harbour.boats[0].on = true;
  harbour.sail(5);
  CHECK(harbour.boats[0].state == core::State::kAuto);
  CHECK(harbour.boats[1].state == core::State::kAuto);
}

TEST_CASE("a longer hull needs more room, by half of the difference") {
  FleetTable mixed = table_of_four(1);
  mixed.members[0].length_dm = 49;
  mixed.members[2].length_dm = 0;
  Harbour harbour;
  harbour.hear(0, message_of(table_of(message_of(mixed, 0)), 0), kOperator);
  harbour.sail(3);
  CHECK(harbour.boats[1].fleet.reach_m(1) == doctest::Approx(1.8));
  CHECK(harbour.boats[1].fleet.reach_m(4) == 0);
  CHECK(harbour.boats[0].fleet.reach_m(2) == 0);
  CHECK_FALSE(harbour.boats[1].fleet.reach_m(3));
  CHECK_FALSE(harbour.boats[1].fleet.reach_m(9));
}

TEST_CASE("an operator's leader or slot overrides the table until the next table") {
  Harbour harbour = under_way();
  harbour.boats[2].own.east_m = 9;
  harbour.sail(5);
  CHECK(harbour.leader_of(2) == 100);
  harbour.boats[0].on = false;
  harbour.boats[1].state = core::State::kHold;
  harbour.sail(5);
  CHECK(harbour.boats[2].state == core::State::kFormation);  // it does not take over
  CHECK(harbour.boats[3].state == core::State::kAuto);
}

TEST_CASE("a stop reaches all at once; nobody takes over after it") {
  Harbour harbour = under_way();
  harbour.hear(3, message_of(table_of_four(2, true), 9000), kOperator);
  harbour.sail(2);
  for (const Boat& boat : harbour.boats) CHECK(boat.state == core::State::kHold);
  harbour.sail(20);
  for (const Boat& boat : harbour.boats) CHECK(boat.state == core::State::kHold);
}

TEST_CASE("a stop is ordered once, also to a boat in HOLD or under an RC pilot") {
  Harbour harbour = under_way();
  harbour.boats[1].state = core::State::kHold;
  harbour.boats[2].state = core::State::kManual;
  for (std::size_t i = 0; i < 4; ++i) {
    harbour.hear(i, message_of(table_of_four(2, true), 0), kOperator);
  }
  for (int tick = 0; tick < 100; ++tick) {
    harbour.sail(0.01);
    harbour.boats[2].state = core::State::kManual;  // as an RC pilot's switch does
  }
  for (const Boat& boat : harbour.boats) CHECK(boat.stops == 1);
}

TEST_CASE("a table of a stranger is ignored, an unsound one is refused") {
  Harbour harbour;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(3);
  harbour.hear(0, message_of(table_of_four(9), 0), {66, 1});
  FleetTable bad = table_of_four(9);
  bad.members[1].system = 1;
  harbour.hear(0, message_of(bad, 0), kOperator);
  const auto refused = harbour.boats[0].fleet.take_refusal();
  REQUIRE(refused);
  CHECK(refused->fault == TableFault::kTwice);
  harbour.sail(3);
  CHECK(harbour.boats[0].fleet.take_epoch() == 1);
}

TEST_CASE(
    "a table of another fleet is ignored, also by an operator and by a boat without a table") {
  FleetTable others = table_of_four(9);
  for (std::size_t i = 0; i < others.count; ++i) {
    others.members[i].system = static_cast<std::uint8_t>(11 + i);
    others.members[i].leader = i == 0 ? 0 : 11;
  }
  Harbour harbour;
  harbour.sail(0.1);
  harbour.hear(0, message_of(others, 0), kOperator);
  harbour.sail(1);
  CHECK_FALSE(harbour.boats[0].fleet.take_epoch());
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(3);
  harbour.hear(0, message_of(others, 0), kOperator);
  harbour.sail(3);
  CHECK(harbour.boats[0].fleet.take_epoch() == 1);
}

TEST_CASE("a boat that knows no leader under way sends a beacon every 0.2 s") {
  FleetTable table = table_of_four(1);
  for (std::size_t i = 1; i < 4; ++i) table.members[i].can_lead = false;
  Harbour harbour;
  harbour.hear(0, message_of(table_of(message_of(table, 0)), 0), kOperator);
  harbour.sail(5);
  harbour.boats[0].on = false;
  harbour.sail(3);
  const std::size_t before = harbour.boats[2].bytes;
  harbour.sail(4);
  CHECK((harbour.boats[2].bytes - before) / 25 == 20);
  harbour.boats[2].state = core::State::kHold;  // it no longer waits for a leader
  harbour.sail(2);
  const std::size_t at_rest = harbour.boats[2].bytes;
  harbour.sail(4);
  CHECK((harbour.boats[2].bytes - at_rest) / 25 <= 4);
}

TEST_CASE("without events, beacons of eight boats take at most 5 % of 57,600 Bd, even signed") {
  Harbour harbour;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(10);
  const std::size_t before = harbour.boats[0].bytes;
  harbour.sail(60);
  const double rate_Bps = static_cast<double>(harbour.boats[0].bytes - before) / 60;
  const double signed_Bps = rate_Bps * (24 + 13) / 24;
  CHECK(8 * signed_Bps <= 0.05 * 57'600 / 10);
  CHECK(rate_Bps > 0);
}

}  // namespace
}  // namespace flotilla::app
