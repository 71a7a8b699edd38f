// SPDX-License-Identifier: MIT
// A boat that takes over knows whether the fleet sails its plan, and the fleet's place in it.
#include <doctest/doctest.h>

#include <initializer_list>

#include "app/fleet/harbour.hpp"

namespace flotilla::app {
namespace {

using core::State;
using testing::Harbour;
using testing::sail_behind_tablet;
using testing::tablet_leads;
using testing::under_way;

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
  sail_behind_tablet(harbour, 50);
  CHECK(harbour.leader_of(1) == 50);
  harbour.sail(3);
  CHECK(harbour.boats[1].state == State::kLoiter);
}

TEST_CASE("an operator's HOLD or DISARM of the leader ends the plan, a failure does not") {
  for (const State state : {State::kHold, State::kDisarmed}) {
    for (const bool stopped : {true, false}) {
      CAPTURE(static_cast<int>(state));
      CAPTURE(stopped);
      Harbour harbour = under_way();
      harbour.boats[0].state = state;
      harbour.boats[0].stopped = stopped;
      harbour.sail(3);
      CHECK(harbour.boats[1].state == (stopped ? State::kLoiter : State::kAuto));
    }
  }
}

TEST_CASE("a boat that hears the leader only through another knows that its plan has ended") {
  for (const bool stopped : {true, false}) {
    CAPTURE(stopped);
    Harbour harbour = under_way();
    harbour.boats[1].deaf_to = 1;
    harbour.sail(5);
    CHECK(harbour.boats[1].fleet.place().plan_id == 77);
    harbour.boats[0].state = State::kHold;
    harbour.boats[0].stopped = stopped;
    harbour.sail(3);
    CHECK(harbour.boats[1].state == (stopped ? State::kLoiter : State::kAuto));
  }
}

TEST_CASE("a follower that its operator has stopped does not end the plan of others") {
  for (int start = 0; start < 24; ++start) {
    CAPTURE(start);
    Harbour harbour = under_way();
    harbour.stop(3);
    harbour.sail(3 + 0.05 * start);
    harbour.boats[1].deaf_to = 1;
    harbour.sail(0.2);
    harbour.boats[0].on = false;
    harbour.sail(4);
    CHECK(harbour.boats[1].state == State::kAuto);
  }
}

TEST_CASE("a boat that takes over from a paused leader knows the fleet's place in its plan") {
  Harbour harbour = under_way();
  harbour.boats[0].place = {77, 5};
  harbour.sail(3);
  harbour.boats[0].place = {0, 5};  // paused
  harbour.sail(2);
  harbour.boats[0].on = false;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == State::kLoiter);
  CHECK(harbour.boats[1].fleet.last_plan_id() == 77);
  CHECK(harbour.boats[1].fleet.place().item == 5);
}

TEST_CASE(
    "a leader in another mode, or without beacons, does not change the fleet's place in its plan") {
  for (const bool tablet : {false, true}) {
    CAPTURE(tablet);
    Harbour harbour = under_way();
    harbour.boats[0].place = {77, 9};
    harbour.sail(3);
    if (tablet) {
      tablet_leads(harbour);
      sail_behind_tablet(harbour, 30);
    } else {
      harbour.boats[0].state = State::kGuided;
      harbour.boats[0].place = {88, 2};
      harbour.sail(3);
      harbour.boats[0].on = false;
    }
    harbour.sail(3);
    CHECK(harbour.boats[1].state == State::kLoiter);
    CHECK(harbour.boats[1].fleet.last_plan_id() == 77);
    CHECK(harbour.boats[1].fleet.place().item == 9);
  }
}

}  // namespace
}  // namespace flotilla::app
