// SPDX-License-Identifier: MIT
// Fleets of the shipped class that hear each other's messages.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <vector>

#include "app/fleet/fleet.hpp"
#include "app/fleet/tables.hpp"

namespace flotilla::app {
namespace {

using testing::table_of_four;

constexpr std::int64_t kSecond_us = 1'000'000, kTick_us = 10'000;
constexpr link::Address kOperator{255, 190};

struct Boat {
  std::uint8_t system = 0;
  core::State state = core::State::kFormation;
  Configuration::Formation own{};
  Fleet fleet{};
  FleetOrder order = FleetOrder::kNone;
  std::int64_t clock_us = 0;  ///< its own clock's zero
  float most_mps = 1.5F;
  bool on = true;
  std::size_t bytes = 0;
  int stops = 0;

  bool moves(std::int64_t now_us) const { return fleet.moves(now_us + clock_us); }
};

/// Boats that hear each other without loss; the radio can be cut.
struct Harbour {
  std::vector<Boat> boats{4};
  std::int64_t now_us = 0;

  Harbour() {
    for (std::size_t i = 0; i < boats.size(); ++i) {
      boats[i].system = static_cast<std::uint8_t>(i + 1);
      boats[i].own.leader = 100;
      boats[i].clock_us = static_cast<std::int64_t>(i) * 3600 * kSecond_us;
    }
    boats[0].state = core::State::kAuto;
  }

  void hear(std::size_t who, const link::Message& message, link::Address from) {
    link::Received received;
    received.message = message;
    received.from = from;
    const auto trust = from == kOperator ? Fleet::Trust::kCommands : Fleet::Trust::kMember;
    boats[who].fleet.hear(received, trust, now_us + boats[who].clock_us);
  }

  void spread(std::size_t from, const link::Message& message, std::size_t bytes) {
    boats[from].bytes += bytes;
    for (std::size_t to = 0; to < boats.size(); ++to) {
      if (to != from && boats[to].on) hear(to, message, {boats[from].system, 1});
    }
  }

  void sail(double s) {
    const auto end_us = now_us + static_cast<std::int64_t>(s * 1e6);
    for (; now_us < end_us; now_us += kTick_us) {
      for (std::size_t i = 0; i < boats.size(); ++i) {
        Boat& boat = boats[i];
        if (!boat.on) continue;
        const std::int64_t clock_us = now_us + boat.clock_us;
        if (now_us % 100'000 == 0) spread(i, link::Attitude{}, 0);
        if (boat.fleet.asks_outlook(clock_us)) {
          const FleetOutlook outlook{.at = {{{0.6F, 0.0F, 0.0F}}}, .most_mps = boat.most_mps};
          boat.fleet.give_places(outlook, clock_us);
        }
        const FleetReport report{boat.system, boat.state, true, {77, 3}};
        boat.order = boat.fleet.step(report, boat.own, kSecond_us, clock_us);
        const bool planned = boat.fleet.place().plan_id != 0;
        if (boat.order == FleetOrder::kLead) {
          boat.state = planned ? core::State::kAuto : core::State::kLoiter;
        }
        if (boat.order == FleetOrder::kFollow) boat.state = core::State::kFormation;
        if (boat.order == FleetOrder::kStop) {
          boat.state = core::State::kHold;
          boat.fleet.stopped();
          ++boat.stops;
        }
        if (const auto beacon = boat.fleet.beacon(clock_us)) spread(i, *beacon, 24);
        if (const auto table = boat.fleet.table(clock_us)) spread(i, *table, 49);
      }
    }
  }

  Parameters applied(std::size_t who) const {
    Parameters p;
    p.FORM_LEADER = 100;
    return boats[who].fleet.applied(p);
  }
  float leader_of(std::size_t who) const { return applied(who).FORM_LEADER; }
};

/// Five seconds behind boat 1, by the first table.
Harbour under_way() {
  Harbour harbour;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(5);
  return harbour;
}

TEST_CASE("without a table nothing is said and nothing changes") {
  Harbour harbour;
  harbour.sail(10);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(harbour.boats[i].bytes == 0);
    CHECK_FALSE(harbour.boats[i].fleet.take_change());
    CHECK(harbour.leader_of(i) == 100);
  }
}

TEST_CASE("a table that one boat gets is in force on all at one instant, on clocks apart") {
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

TEST_CASE("a new shape moves all places together, at the speed that the law is told") {
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

TEST_CASE("a request to give the places: who hears it does, and all agree") {
  Harbour harbour = under_way();
  FleetTable wish = table_of_four(2);
  wish.assigns = true;
  wish.members[1].slot_cm = {-1200, 100};
  wish.members[2].slot_cm = {-400, 100};
  wish.members[3].slot_cm = {-800, 100};
  harbour.hear(2, message_of(wish, 0), {9, 1});
  harbour.sail(3);
  CHECK(harbour.applied(3).FORM_OFS_E == 0);  // nobody gives orders but an operator
  harbour.hear(2, message_of(wish, 0), kOperator);
  harbour.sail(30);
  CHECK(harbour.applied(1).FORM_OFS_N == -4);
  CHECK(harbour.applied(2).FORM_OFS_N == -4);  // behind boat 2
  CHECK(harbour.applied(3).FORM_OFS_N == -12);
  for (std::size_t i : {1U, 3U}) CHECK(harbour.applied(i).FORM_OFS_E == 1);
  wish.members[3].slot_cm = {-800, 900};
  harbour.hear(1, message_of(wish, 0), kOperator);  // an epoch that all have
  harbour.sail(30);
  CHECK(harbour.applied(3).FORM_OFS_E == 1);
}

TEST_CASE(
    "boats that hear the same request leave it to the leader; if it has not heard it they do") {
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

TEST_CASE("a boat without a table leaves a request to those that have one") {
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

TEST_CASE("assigned places too near for the hulls are refused, as in any table") {
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

TEST_CASE("a boat that a new table leaves out gets that table, and does not take over") {
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
  CHECK(harbour.boats[1].state == core::State::kFormation);
  CHECK(harbour.boats[0].state == core::State::kAuto);
}

TEST_CASE("two boats lead while a table waits: the one of higher rank goes on") {
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

TEST_CASE("a shape that changes again under way: places and speeds go on without a step") {
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

TEST_CASE("a boat that restarts without a table asks for it") {
  Harbour harbour;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(3);
  harbour.boats[2].fleet = Fleet{};
  harbour.sail(4);
  CHECK(harbour.leader_of(2) == 2);
}

TEST_CASE("the leader falls silent: the next one leads within two seconds, all hang on it") {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(2);
  CHECK(harbour.boats[1].state == core::State::kAuto);
  CHECK(harbour.boats[1].fleet.place().plan_id == 77);
  CHECK(harbour.leader_of(2) == 2);
  CHECK(harbour.leader_of(3) == 2);
  CHECK(harbour.applied(3).FORM_OFS_N == -8);
}

TEST_CASE("after a stop nobody takes over before somebody has led again") {
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

TEST_CASE("a member that leads by a table which nobody has is believed for ten seconds") {
  Harbour harbour = under_way();
  harbour.boats[3].on = false;
  link::FleetBeacon beacon{};
  beacon.epoch = 60'000;
  beacon.flags = 3;  // fit, leads
  beacon.plan_id = 77;
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
  repeat(50);  // a new table does not make it credible
  CHECK(harbour.boats[0].state == core::State::kAuto);
  CHECK(harbour.leader_of(1) == 1);
}

TEST_CASE("a boat that is to lead follows none of those that are to follow it") {
  Harbour harbour = under_way();
  FleetTable next = table_of_four(2);
  std::swap(next.members[0].system, next.members[1].system);
  next.members[1].leader = next.members[2].leader = next.members[3].leader = 2;
  for (Boat& boat : harbour.boats) boat.state = core::State::kHold;
  harbour.hear(0, message_of(next, 0), kOperator);
  harbour.sail(3);
  CHECK(harbour.leader_of(1) == 100);
  CHECK(harbour.leader_of(0) == 2);
  harbour.boats[1].own.leader = 1;  // the parameters name one of them too
  next.epoch = 3;
  harbour.hear(0, message_of(next, 0), kOperator);
  harbour.sail(3);
  CHECK(harbour.leader_of(1) == 0);
}

TEST_CASE("half of the members go on without the leader: they have no plan, so that they wait") {
  Harbour harbour = under_way();
  harbour.boats[0].on = harbour.boats[1].on = false;
  harbour.sail(2);
  CHECK(harbour.boats[2].state == core::State::kLoiter);
  CHECK(harbour.leader_of(3) == 3);
}

TEST_CASE("an inner boat in HOLD: its follower hangs on its leader until the next table") {
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

TEST_CASE("an operator's own leader or slot is above the table until the next one") {
  Harbour harbour = under_way();
  harbour.boats[2].own.east_m = 9;
  harbour.sail(5);
  CHECK(harbour.leader_of(2) == 100);
  harbour.boats[0].on = false;
  harbour.boats[1].state = core::State::kHold;
  harbour.sail(5);
  CHECK(harbour.boats[2].state == core::State::kFormation);  // it takes nothing over
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

TEST_CASE("in peace eight boats' beacons take 5 % of 57,600 Bd at the most, even signed") {
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
