// SPDX-License-Identifier: MIT
// Fleets of the shipped class that hear each other's messages.
#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "app/fleet/fleet.hpp"
#include "app/fleet/tables.hpp"

namespace flotilla::app::testing {

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
  bool may_follow = true;    ///< FORMATION is granted
  bool stopped = false;      ///< by an operator, not by a failure
  std::uint8_t hears = 0;    ///< the only system that it hears; 0: all
  std::uint8_t deaf_to = 0;  ///< the system that it does not hear
  int lost_reports = 0;      ///< the radio loses this many of its beacons that name no leader
  FleetPlace place{77, 3};
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
      const std::uint8_t system = boats[from].system;
      const bool hears =
          (boats[to].hears == 0 || boats[to].hears == system) && boats[to].deaf_to != system;
      if (to != from && boats[to].on && hears) hear(to, message, {boats[from].system, 1});
    }
  }

  /// An operator puts boats[who] into HOLD.
  void stop(std::size_t who) {
    boats[who].state = core::State::kHold;
    boats[who].stopped = true;
  }

  /// Boats[who] neither hears others nor is heard, until reach(who).
  void cut_off(std::size_t who) {
    for (Boat& boat : boats) boat.deaf_to = boats[who].system;
    boats[who].hears = boats[who].system;
  }
  void reach(std::size_t who) {
    for (Boat& boat : boats) boat.deaf_to = 0;
    boats[who].hears = 0;
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
        const FleetReport report{boat.system, boat.state, true, boat.place, boat.stopped};
        boat.order = boat.fleet.step(report, boat.own, kSecond_us, clock_us);
        const bool planned = boat.fleet.place().plan_id != 0;
        if (boat.order == FleetOrder::kLead) {
          boat.state = planned ? core::State::kAuto : core::State::kLoiter;
          boat.place.item = boat.fleet.place().item;
        }
        const bool joins = boat.order == FleetOrder::kFollow && boat.may_follow;
        if (joins) boat.state = core::State::kFormation;
        if (boat.order == FleetOrder::kStop) {
          boat.state = core::State::kHold;
          boat.fleet.confirm_stop();
          ++boat.stops;
        }
        if (const auto beacon = boat.fleet.beacon(clock_us)) {
          const bool reports = FleetPeers::heard_of(beacon->flags) == 0;
          const bool lost = reports && boat.lost_reports > 0 && boat.lost_reports-- > 0;
          if (!lost) spread(i, *beacon, 25);
        }
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

/// The fleet has sailed behind boat 1 by the first table for five seconds.
inline Harbour under_way() {
  Harbour harbour;
  harbour.hear(0, message_of(table_of_four(1), 0), kOperator);
  harbour.sail(5);
  return harbour;
}

/// A table in which tablet 50, which sends no beacons, takes boat 1's place.
inline void tablet_leads(Harbour& harbour) {
  FleetTable tablet = table_of_four(2);
  tablet.members[0].system = 50;
  tablet.members[0].only_leads = true;
  tablet.members[1].leader = tablet.members[3].leader = 50;
  harbour.hear(1, message_of(table_of(message_of(tablet, 0)), 0), kOperator);
}

/// Sails while tablet 50 sends its motion to all boats except boat 1.
inline void sail_behind_tablet(Harbour& harbour, int tenths) {
  for (int tenth = 0; tenth < tenths; ++tenth) {
    for (std::size_t who = 1; who < 4; ++who) harbour.hear(who, link::Attitude{}, {50, 1});
    harbour.sail(0.1);
  }
}

/// Boat 1 is silent, and boat 2 has taken over.
inline Harbour taken_over() {
  Harbour harbour = under_way();
  harbour.boats[0].on = false;
  harbour.sail(3);
  CHECK(harbour.boats[1].state == core::State::kAuto);
  return harbour;
}

/// Boat 2 has taken over. Boat 1 is back, so boat 2 must yield to it, but cannot follow it yet.
inline Harbour yielding() {
  Harbour harbour = taken_over();
  harbour.boats[1].may_follow = false;
  harbour.boats[0].on = true;
  harbour.sail(0.5);
  CHECK(harbour.boats[1].order == FleetOrder::kFollow);
  return harbour;
}

}  // namespace flotilla::app::testing
