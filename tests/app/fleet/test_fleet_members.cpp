// SPDX-License-Identifier: MIT
// Members that a table leaves out, that restart, that were never fit, or that send no beacons.
#include <doctest/doctest.h>

#include <utility>

#include "app/fleet/harbour.hpp"

namespace flotilla::app {
namespace {

using core::State;
using testing::Harbour;
using testing::kOperator;
using testing::table_of_four;
using testing::tablet_leads;
using testing::taken_over;
using testing::under_way;
using testing::yielding;

/// A table without boat 2, in which boats 3 and 4 follow boat 1.
FleetTable without_boat_2(std::uint16_t epoch) {
  FleetTable table = table_of_four(epoch);
  table.members[1] = table.members[2];
  table.members[2] = table.members[3];
  table.members[1].leader = table.members[2].leader = 1;
  table.count = 3;
  return table_of(message_of(table, 0));
}

TEST_CASE("a camera with a leading tablet's system id does not keep the tablet alive") {
  Harbour harbour = under_way();
  tablet_leads(harbour);
  for (int tenth = 0; tenth < 70; ++tenth) {
    for (std::size_t who = 1; who < 4; ++who) {
      if (tenth < 50) harbour.hear(who, link::Attitude{}, {50, 1});
      harbour.hear(who, link::Heartbeat{}, {50, 100});
    }
    harbour.sail(0.1);
  }
  CHECK(harbour.boats[1].state == State::kLoiter);
}

TEST_CASE("a boat does not yield to a root without beacons that was never heard") {
  Harbour harbour = under_way();
  FleetTable tablet = table_of_four(2);
  for (std::size_t i = 3; i > 0; --i) tablet.members[i].system = tablet.members[i - 1].system;
  tablet.members[0].system = 50;
  tablet.members[0].only_leads = true;
  for (std::size_t i = 1; i < 4; ++i) tablet.members[i].leader = tablet.members[i - 1].system;
  tablet = table_of(message_of(tablet, 0));
  for (std::size_t i = 0; i < 4; ++i) harbour.hear(i, message_of(tablet, 0), kOperator);
  for (int tick = 0; tick < 300; ++tick) {
    harbour.sail(0.01);
    CHECK(harbour.boats[0].state == State::kAuto);
  }
}

TEST_CASE("a leader that a new table no longer lets lead follows the next one") {
  Harbour harbour = under_way();
  FleetTable next = table_of_four(2);
  std::swap(next.members[0], next.members[1]);
  next.members[0].leader = 0;
  next.members[1].leader = 2;
  next.members[1].can_lead = false;
  next = table_of(message_of(next, 0));
  harbour.hear(0, message_of(next, 0), kOperator);
  harbour.sail(5);
  CHECK(harbour.boats[0].state == State::kFormation);
  CHECK(harbour.boats[1].state == State::kAuto);
  CHECK(harbour.leader_of(0) == 2);
}

TEST_CASE(
    "a boat that took over stops when a table leaves it out; one that its operator sent goes on") {
  for (const bool sent : {false, true}) {
    CAPTURE(sent);
    Harbour harbour = sent ? under_way() : taken_over();
    if (sent) harbour.boats[1].state = State::kGuided;
    harbour.sail(1);
    harbour.hear(1, message_of(without_boat_2(2), 0), kOperator);
    harbour.sail(1);
    CHECK(harbour.boats[1].state == (sent ? State::kGuided : State::kHold));
  }
}

TEST_CASE(
    "a boat that took over, and yields but cannot follow yet, stops when a table leaves it out") {
  Harbour harbour = yielding();
  harbour.hear(1, message_of(without_boat_2(2), 0), kOperator);
  harbour.sail(1);
  CHECK(harbour.boats[1].state == State::kHold);
}

TEST_CASE("a leader that the next table leaves out is replaced at once if it stops before") {
  Harbour harbour = taken_over();
  harbour.hear(1, message_of(without_boat_2(2), 10'000), kOperator);
  harbour.sail(2);
  harbour.boats[1].state = State::kHold;
  harbour.sail(1);
  CHECK(harbour.boats[2].state == State::kAuto);
}

TEST_CASE(
    "a leader that restarts has failed, unlike one stopped by its operator: boat 2 takes over") {
  for (const bool is_lost : {false, true}) {  // the first beacon after the restart, without a table
    CAPTURE(is_lost);
    Harbour harbour = under_way();
    harbour.sail(60);  // its beacons have higher numbers by now
    harbour.boats[0].fleet = {};
    harbour.boats[0].state = State::kDisarmed;
    harbour.boats[0].stopped = true;
    if (is_lost) harbour.cut_off(0);
    harbour.sail(0.3);
    harbour.reach(0);
    harbour.sail(1.2);
    CHECK(harbour.boats[1].state == State::kAuto);
  }
}

TEST_CASE("a failed leader repeats its beacon while a member still reports that it leads") {
  Harbour harbour = under_way();
  harbour.boats[0].state = State::kDisarmed;
  harbour.boats[1].deaf_to = 1;
  const auto bytes_in_two_seconds = [&] {
    const std::size_t before = harbour.boats[0].bytes;
    for (int tenth = 0; tenth < 20; ++tenth) {
      // Boat 2 receives its other messages.
      harbour.hear(1, link::Attitude{}, {1, 1});
      harbour.sail(0.1);
    }
    return harbour.boats[0].bytes - before;
  };
  harbour.sail(0.6);  // the usual repetitions of a change
  CHECK(bytes_in_two_seconds() >= 6 * 25);
  CHECK(harbour.boats[1].state == State::kFormation);
  harbour.boats[1].deaf_to = 0;
  harbour.sail(1.5);
  CHECK(harbour.boats[1].state == State::kAuto);
  harbour.sail(3);
  CHECK(bytes_in_two_seconds() <= 2 * 25);
}

TEST_CASE("a beacon of minutes ago, and one of a member with another table, change nothing") {
  Harbour harbour = under_way();
  harbour.sail(120);
  harbour.boats[0].state = State::kDisarmed;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == State::kAuto);
  link::FleetBeacon old{};
  old.epoch = 1;
  old.digest = table_of_four(1).digest;
  old.flags = FleetPeers::kLeads;
  old.sequence = 60;
  harbour.hear(1, old, {1, 1});
  harbour.sail(0.5);
  CHECK(harbour.boats[1].state == State::kAuto);
  // Of a table that nobody has; it would name boat 1.
  link::FleetBeacon foreign{};
  foreign.epoch = 1;
  foreign.digest = 65'535;
  foreign.flags = 1U << FleetPeers::kHears;
  harbour.sail(3);
  const std::size_t before = harbour.boats[0].bytes;
  for (int tenth = 0; tenth < 30; ++tenth) {
    ++foreign.sequence;
    harbour.hear(0, foreign, {3, 1});
    harbour.sail(0.1);
  }
  CHECK(harbour.boats[0].bytes - before <= 4 * 25);
}

TEST_CASE("however often members report a leader that is none, it repeats its beacon rarely") {
  Harbour harbour = under_way();
  harbour.boats[0].state = State::kDisarmed;
  harbour.sail(5);
  link::FleetBeacon wrong{};
  wrong.epoch = 1;
  wrong.digest = table_of_four(1).digest;
  wrong.flags = FleetPeers::kFit | 1U << FleetPeers::kHears;
  wrong.sequence = 100;
  const std::size_t before = harbour.boats[0].bytes;
  for (int tenth = 0; tenth < 120; ++tenth) {
    ++wrong.sequence;
    harbour.hear(0, wrong, {4, 1});
    harbour.sail(0.1);
  }
  CHECK(harbour.boats[0].bytes - before >= 20 * 25);
  CHECK(harbour.boats[0].bytes - before <= 44 * 25);
}

TEST_CASE("a late beacon from before a boat got its table changes nothing") {
  Harbour harbour = under_way();
  link::FleetBeacon late{};
  late.sequence = 1;
  for (std::size_t who = 1; who < 4; ++who) harbour.hear(who, late, {1, 1});
  for (const std::size_t who : {0U, 2U, 3U}) harbour.hear(who, late, {2, 1});
  harbour.sail(2);
  CHECK(harbour.boats[0].state == State::kAuto);
  CHECK(harbour.boats[1].state == State::kFormation);
  CHECK(harbour.leader_of(2) == 2);
}

TEST_CASE("a boat that was never fit has no followers in a fleet under way, until it is fit") {
  Harbour harbour;
  harbour.boats[1].state = State::kDisarmed;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(5);
  CHECK(harbour.leader_of(2) == 1);
  harbour.boats[1].state = State::kFormation;
  harbour.sail(2);
  CHECK(harbour.leader_of(2) == 2);
}

TEST_CASE("a boat that alone loses the leader sends frequent beacons for two seconds only") {
  Harbour harbour = under_way();
  harbour.boats[1].deaf_to = 1;
  harbour.sail(1.2);  // FS_LEADER_S and 0.2 s
  const std::size_t before = harbour.boats[1].bytes;
  harbour.sail(2.4);
  const std::size_t soon = harbour.boats[1].bytes;
  CHECK(soon - before >= 12 * 25);
  harbour.sail(12);
  CHECK(harbour.boats[1].bytes - soon <= 12 * 25);
  CHECK(harbour.boats[1].state == State::kFormation);
}

TEST_CASE("a root that was no member before is replaced only if it stays silent") {
  for (const bool speaks : {true, false}) {
    CAPTURE(speaks);
    Harbour harbour = under_way();
    harbour.boats.emplace_back();
    harbour.boats[4].system = 9;
    harbour.boats[4].state = State::kAuto;
    FleetTable next = table_of_four(2);
    next.members[0].system = 9;
    next.members[1].leader = next.members[3].leader = 9;
    next = table_of(message_of(next, 0));
    harbour.boats[4].on = speaks;
    harbour.hear(4, message_of(next, 1000), kOperator);
    for (std::size_t i = 0; i < 4; ++i) harbour.hear(i, message_of(next, 1000), kOperator);
    harbour.boats[0].on = false;
    for (int tick = 0; tick < 200; ++tick) {
      harbour.sail(0.01);
      if (speaks) CHECK(harbour.boats[1].state == State::kFormation);
    }
    harbour.sail(1.5);
    CHECK(harbour.boats[1].state == (speaks ? State::kFormation : State::kAuto));
  }
}

TEST_CASE("a boat that was left out of a table does not take over when it comes back") {
  Harbour harbour = under_way();
  FleetTable two = table_of_four(2);
  two.count = 2;
  for (std::size_t i = 0; i < 4; ++i) harbour.hear(i, message_of(two, 0), kOperator);
  harbour.sail(2);
  for (testing::Boat& boat : harbour.boats) boat.state = State::kHold;
  harbour.sail(2);
  harbour.boats[2].state = State::kFormation;
  for (std::size_t i = 0; i < 4; ++i) {
    harbour.hear(i, message_of(table_of_four(3), 0), kOperator);
  }
  harbour.sail(5);
  CHECK(harbour.boats[2].state == State::kFormation);
}

}  // namespace
}  // namespace flotilla::app
