// SPDX-License-Identifier: MIT
// The rule of succession respects an operator's orders: it does not undo them.
#include <doctest/doctest.h>

#include <initializer_list>

#include "app/fleet/harbour.hpp"

namespace flotilla::app {
namespace {

using core::State;
using testing::Harbour;
using testing::kOperator;
using testing::table_of_four;
using testing::under_way;

/// A table in which tablet 50, which sends no beacons, takes boat 1's place.
void tablet_leads(Harbour& harbour) {
  FleetTable tablet = table_of_four(2);
  tablet.members[0].system = 50;
  tablet.members[0].only_leads = true;
  tablet.members[1].leader = tablet.members[3].leader = 50;
  harbour.hear(1, message_of(table_of(message_of(tablet, 0)), 0), kOperator);
}

TEST_CASE("a boat that takes over from a leader without a plan waits and starts none") {
  for (const State state : {State::kGuided, State::kLoiter, State::kReturn}) {
    CAPTURE(static_cast<int>(state));
    Harbour harbour = under_way();
    harbour.boats[0].state = state;
    harbour.sail(0.5);  // before a beacon could repeat the old place
    harbour.boats[0].on = false;
    harbour.sail(2);
    CHECK(harbour.boats[1].fleet.place().plan_id == 0);
    CHECK(harbour.boats[1].state == State::kLoiter);
  }
}

TEST_CASE("a boat that takes over from a leader with a paused plan waits") {
  Harbour harbour = under_way();
  harbour.boats[0].place = {0, 3};
  harbour.sail(0.5);
  harbour.boats[0].on = false;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == State::kLoiter);
}

TEST_CASE("an earlier plan of the fleet is not resumed after a root without a plan") {
  Harbour harbour = under_way();
  harbour.boats[0].state = State::kHold;
  tablet_leads(harbour);
  for (int tenth = 0; tenth < 50; ++tenth) {
    for (std::size_t who = 1; who < 4; ++who) harbour.hear(who, link::Attitude{}, {50, 1});
    harbour.sail(0.1);
  }
  CHECK(harbour.leader_of(1) == 50);
  harbour.sail(3);
  CHECK(harbour.boats[1].state == State::kLoiter);
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

TEST_CASE("a new slot for the leading boat does not end its lead") {
  Harbour harbour = under_way();
  harbour.boats[0].own.north_m = 9;
  harbour.sail(5);
  CHECK(harbour.boats[0].state == State::kAuto);
  CHECK(harbour.boats[0].fleet.place().plan_id == 77);
  CHECK(harbour.boats[1].state == State::kFormation);
  CHECK(harbour.leader_of(1) == 1);
}

/// Boat 2 has taken over. Boat 1 is back, so boat 2 must yield to it, but cannot follow it yet.
Harbour yielding() {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(3);
  REQUIRE(harbour.boats[1].state == State::kAuto);
  harbour.boats[1].may_follow = false;
  harbour.boats[0].on = true;
  harbour.sail(0.5);
  CHECK(harbour.boats[1].order == FleetOrder::kFollow);
  return harbour;
}

TEST_CASE("a boat that yields, but cannot follow yet, keeps the mode set by its operator") {
  for (const State state : {State::kReturn, State::kLoiter, State::kGuided}) {
    CAPTURE(static_cast<int>(state));
    Harbour harbour = yielding();
    harbour.boats[1].state = state;
    harbour.sail(0.5);
    harbour.boats[1].may_follow = true;
    harbour.sail(5);
    CHECK(harbour.boats[1].state == state);
    CHECK(harbour.boats[0].state == State::kAuto);
  }
}

TEST_CASE("a boat that yields follows as soon as it can") {
  Harbour harbour = yielding();
  harbour.sail(5);
  CHECK(harbour.boats[1].state == State::kAuto);
  harbour.boats[1].may_follow = true;
  harbour.sail(0.1);
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

TEST_CASE("a leader steered by a pilot still leads: no other boat starts the plan") {
  Harbour harbour = under_way();
  harbour.boats[0].state = State::kManual;
  for (int tick = 0; tick < 1000; ++tick) {
    harbour.sail(0.01);
    for (std::size_t i = 1; i < 4; ++i) REQUIRE(harbour.boats[i].state == State::kFormation);
  }
  CHECK(harbour.leader_of(1) == 1);
  CHECK(harbour.boats[1].fleet.place().plan_id == 0);
  harbour.boats[0].state = State::kAuto;
  harbour.sail(3);
  CHECK(harbour.boats[1].fleet.place().plan_id == 77);
  harbour.boats[0].state = State::kManual;
  harbour.sail(2);
  harbour.boats[0].state = State::kHold;  // as after the sticks fell silent
  harbour.sail(2);
  CHECK(harbour.boats[1].state == State::kLoiter);
}

TEST_CASE("takeover never moves a piloted boat: a leader in MANUAL yields only the lead") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(3);
  REQUIRE(harbour.boats[1].state == State::kAuto);
  harbour.boats[1].state = State::kManual;
  harbour.sail(2);
  harbour.boats[0].on = true;
  for (int tick = 0; tick < 500; ++tick) {
    harbour.sail(0.01);
    REQUIRE(harbour.boats[1].order == FleetOrder::kNone);
  }
  CHECK(harbour.leader_of(3) == 1);
}

TEST_CASE("a follower in MANUAL does not take over") {
  Harbour harbour = under_way();
  harbour.boats[1].state = State::kManual;
  harbour.boats[0].on = false;
  harbour.sail(3);
  CHECK(harbour.boats[1].state == State::kManual);
  CHECK(harbour.boats[2].state != State::kFormation);
}

TEST_CASE("a leader that its operator makes a follower does not take over again") {
  Harbour harbour = under_way();
  harbour.boats[0].state = State::kFormation;
  harbour.sail(5);
  CHECK(harbour.boats[0].state == State::kFormation);
  CHECK(harbour.boats[1].state == State::kFormation);
  CHECK(harbour.leader_of(1) == 1);
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
