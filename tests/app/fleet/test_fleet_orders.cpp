// SPDX-License-Identifier: MIT
// The rule of succession respects an operator's orders: it does not undo them.
#include <doctest/doctest.h>

#include <initializer_list>

#include "app/fleet/harbour.hpp"

namespace flotilla::app {
namespace {

using core::State;
using testing::Boat;
using testing::Harbour;
using testing::kOperator;
using testing::table_of_four;
using testing::taken_over;
using testing::under_way;
using testing::yielding;

TEST_CASE("a new slot for the leading boat does not end its lead") {
  Harbour harbour = under_way();
  harbour.boats[0].own.north_m = 9;
  harbour.sail(5);
  CHECK(harbour.boats[0].state == State::kAuto);
  CHECK(harbour.boats[0].fleet.place().plan_id == 77);
  CHECK(harbour.boats[1].state == State::kFormation);
  CHECK(harbour.leader_of(1) == 1);
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

TEST_CASE(
    "a boat that leads in its operator's RTL or LOITER keeps it when a better leader appears") {
  for (const State state : {State::kReturn, State::kLoiter}) {
    CAPTURE(static_cast<int>(state));
    Harbour harbour = taken_over();
    harbour.boats[1].state = state;
    harbour.sail(2);
    harbour.boats[0].on = true;
    harbour.sail(5);
    CHECK(harbour.boats[1].state == state);
    CHECK(harbour.leader_of(3) == 1);
  }
}

TEST_CASE("a boat that took over and waits yields to a better leader") {
  Harbour harbour = under_way();
  harbour.boats[0].place = {0, 3};
  harbour.sail(0.5);
  harbour.boats[0].on = false;
  harbour.sail(3);
  REQUIRE(harbour.boats[1].state == State::kLoiter);
  harbour.boats[0].on = true;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == State::kFormation);
}

TEST_CASE("a root in LOITER or RTL leads: others take over from it, and none leads beside it") {
  for (const State state : {State::kLoiter, State::kReturn}) {
    CAPTURE(static_cast<int>(state));
    Harbour harbour;
    harbour.boats[0].state = state;
    harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
    harbour.sail(5);
    harbour.boats[3].state = State::kGuided;
    harbour.sail(5);
    CHECK(harbour.leader_of(1) == 1);
    harbour.boats[0].on = false;
    harbour.boats[3].state = State::kHold;
    harbour.sail(3);
    CHECK(harbour.boats[1].state == State::kLoiter);
  }
}

TEST_CASE("a root in LOITER or RTL leaves the fleet to the boat that already leads it") {
  for (const State state : {State::kLoiter, State::kReturn}) {
    CAPTURE(static_cast<int>(state));
    Harbour harbour = under_way();
    harbour.boats[0].state = State::kHold;  // a failure
    harbour.sail(3);
    harbour.boats[0].state = state;
    harbour.sail(5);
    CHECK(harbour.leader_of(2) == 2);
    harbour.cut_off(0);
    harbour.sail(3);
    harbour.reach(0);
    harbour.sail(3);
    CHECK(harbour.boats[1].state == State::kAuto);
    CHECK(harbour.leader_of(2) == 2);
  }
}

TEST_CASE("a root that is sent to LOITER or RTL out of reach leaves the fleet to its leader") {
  for (const State state : {State::kLoiter, State::kReturn}) {
    for (int start = 0; start < 24; ++start) {
      CAPTURE(static_cast<int>(state));
      CAPTURE(start);
      Harbour harbour = under_way();
      harbour.cut_off(0);
      harbour.boats[0].state = State::kHold;  // a failure
      harbour.sail(3 + 0.05 * start);
      REQUIRE(harbour.boats[1].state == State::kAuto);
      harbour.boats[0].state = state;
      harbour.sail(5);
      harbour.reach(0);
      harbour.sail(5);
      CHECK(harbour.boats[0].state == state);
      CHECK(harbour.boats[1].state == State::kAuto);
      CHECK(harbour.leader_of(2) == 2);
    }
  }
}

TEST_CASE("a root that waits alone leads as soon as it hears the others, if none of them leads") {
  Harbour harbour;
  for (Boat& boat : harbour.boats) boat.state = State::kHold;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(5);
  harbour.cut_off(0);
  harbour.boats[0].state = State::kLoiter;
  harbour.sail(5);
  harbour.reach(0);
  for (std::size_t who = 1; who < 4; ++who) harbour.boats[who].state = State::kFormation;
  harbour.sail(3);
  CHECK(harbour.leader_of(1) == 1);
  harbour.boats[0].on = false;
  harbour.sail(3);
  CHECK(harbour.boats[1].state == State::kLoiter);
}

TEST_CASE("if the boat that took over from a waiting root fails, the next one sails on") {
  Harbour harbour = under_way();
  harbour.boats[0].state = State::kHold;  // a failure
  harbour.sail(3);
  harbour.boats[0].state = State::kLoiter;
  harbour.sail(3);
  harbour.boats[1].on = false;
  harbour.sail(3);
  CHECK(harbour.boats[2].state == State::kAuto);
}

TEST_CASE("a boat that misses an operator's HOLD of all boats stops too") {
  for (std::size_t missed = 1; missed < 4; ++missed) {
    for (const bool leader_last : {false, true}) {
      CAPTURE(missed);
      CAPTURE(leader_last);
      Harbour harbour = under_way();
      for (std::size_t i = 0; i < 4; ++i) {
        const std::size_t who = leader_last ? 3 - i : i;
        if (who == missed) continue;
        harbour.stop(who);
        harbour.sail(0.3);
      }
      harbour.sail(3);
      CHECK(harbour.boats[missed].state == State::kHold);
      harbour.boats[missed].state = State::kLoiter;  // by its operator
      harbour.sail(5);
      CHECK(harbour.boats[missed].state == State::kLoiter);
    }
  }
}

TEST_CASE("a boat that misses a HOLD stops even if it does not hear the leader, or took over") {
  for (const bool took_over : {false, true}) {
    CAPTURE(took_over);
    Harbour harbour = under_way();
    if (took_over) {
      harbour.boats[0].on = false;
    } else {
      harbour.boats[1].deaf_to = 1;
    }
    harbour.sail(5);
    REQUIRE(harbour.boats[1].state == (took_over ? State::kAuto : State::kFormation));
    for (const std::size_t who : {0U, 2U, 3U}) {
      harbour.stop(who);
    }
    harbour.sail(took_over ? 0.5 : 3.5);
    CHECK(harbour.boats[1].state == State::kHold);
    CHECK(harbour.boats[1].stops == 1);
  }
}

TEST_CASE("a boat that may not lead, and misses a HOLD of all boats, stops too") {
  Harbour harbour;
  FleetTable table = table_of_four(1);
  table.members[3].can_lead = false;
  harbour.hear(0, message_of(table_of(message_of(table, 0)), 0), kOperator);
  harbour.sail(5);
  for (std::size_t who = 0; who < 3; ++who) {
    harbour.stop(who);
  }
  harbour.sail(3);
  CHECK(harbour.boats[3].state == State::kHold);
  harbour.boats[3].state = State::kFormation;  // by its operator
  harbour.boats[3].stopped = false;
  harbour.sail(5);
  CHECK(harbour.boats[3].state == State::kFormation);
}

TEST_CASE("stopping one boat twice, or adding boats that are laid up, is no HOLD of all boats") {
  for (const bool twice : {true, false}) {
    CAPTURE(twice);
    Harbour harbour = under_way();
    harbour.boats[0].on = harbour.boats[3].on = false;
    harbour.sail(5);
    REQUIRE(harbour.boats[1].state == State::kLoiter);
    harbour.stop(2);
    harbour.sail(1);
    if (twice) {
      harbour.boats[2].state = State::kFormation;
      harbour.boats[2].stopped = false;
      harbour.sail(1);
      harbour.stop(2);
    } else {
      FleetTable table = table_of_four(2);
      table.members[0].system = 9;
      for (std::size_t who = 1; who < 4; ++who) {
        if (table.members[who].leader == 1) table.members[who].leader = 9;
      }
      harbour.hear(1, message_of(table_of(message_of(table, 0)), 0), kOperator);
      harbour.sail(0.2);
      link::FleetBeacon laid_up{};
      laid_up.epoch = 2;
      laid_up.flags = FleetPeers::kEnds;
      harbour.hear(1, laid_up, {9, 1});
    }
    harbour.sail(2);
    CHECK(harbour.boats[1].state == State::kLoiter);
  }
}

TEST_CASE("a boat that was sent to sail alone beside a leader does not lead after that leader") {
  for (const State sent : {State::kGuided, State::kAuto}) {
    CAPTURE(static_cast<int>(sent));
    Harbour harbour = under_way();
    harbour.boats[3].state = sent;
    harbour.sail(2);
    harbour.boats[0].on = false;
    harbour.sail(5);
    CHECK(harbour.boats[3].state == sent);
    CHECK(harbour.boats[1].state == State::kAuto);
    CHECK(harbour.leader_of(2) == 2);
  }
}

TEST_CASE("a boat that took over sails on if one boat is stopped and the others fall silent") {
  for (const bool pair : {false, true}) {
    CAPTURE(pair);
    Harbour harbour = under_way();
    harbour.boats[0].on = false;
    if (pair) harbour.boats[3].on = false;
    harbour.sail(5);
    const State state = pair ? State::kLoiter : State::kAuto;  // two boats of four are no majority
    REQUIRE(harbour.boats[1].state == state);
    harbour.boats[2].state = State::kDisarmed;
    harbour.boats[2].stopped = true;
    harbour.sail(2);
    harbour.boats[3].on = false;
    harbour.sail(5);
    CHECK(harbour.boats[1].state == state);
  }
}

TEST_CASE("a boat that took over and is steered by a pilot does not stop with the others") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(5);
  harbour.boats[1].state = State::kManual;
  harbour.sail(1);
  for (const std::size_t who : {2U, 3U}) {
    harbour.stop(who);
  }
  harbour.sail(5);
  CHECK(harbour.boats[1].state == State::kManual);
}

TEST_CASE("boats that have restarted, or are stopped while the leader sails on, stop no other") {
  for (const bool restarted : {false, true}) {
    CAPTURE(restarted);
    Harbour harbour = under_way();
    for (const std::size_t who : {2U, 3U}) {
      if (restarted) harbour.boats[who].fleet = {};
      harbour.boats[who].state = State::kDisarmed;
      harbour.boats[who].stopped = true;
    }
    harbour.sail(5);
    if (restarted) {
      harbour.stop(0);
    } else {
      harbour.boats[0].on = false;
    }
    harbour.sail(3);
    CHECK(harbour.boats[1].state == (restarted ? State::kLoiter : State::kAuto));
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

}  // namespace
}  // namespace flotilla::app
