// SPDX-License-Identifier: MIT
// The boat as a member of a fleet: keeps the table, hears the other members, says who leads.
// firmware/docs/FLEET.md explains it.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "app/fleet/assignment.hpp"
#include "app/fleet/ledger.hpp"
#include "app/fleet/move.hpp"
#include "app/fleet/succession.hpp"
#include "app/parameters/configuration.hpp"
#include "app/schedule.hpp"

namespace flotilla::app {

/// Where the fleet is in its plan: opaque id and item.
struct FleetPlace {
  std::uint32_t plan_id = 0;
  std::uint16_t item = 0;
};

/// This boat in a tick.
struct FleetReport {
  std::uint8_t system = 0;
  core::State state = core::State::kDisarmed;
  bool fit = false;  ///< could begin LOITER, and keeps its slot
  FleetPlace place;  ///< of its own plan
};

/// Without a table it does nothing, but for asking for one where others speak of one.
class Fleet {
 public:
  /// Of a message's sender: it may command the boat; it may give it a first table as a member.
  enum class Trust : std::uint8_t { kNone, kMember, kCommands };

  /// Any message.
  void hear(const link::Received& received, Trust trust, std::int64_t now_us);

  /// Places are to be given to the members, by a boat that knows how the root will sail.
  bool asks_outlook(std::int64_t now_us) const { return wish_ && now_us >= wish_->due_us; }
  void give_places(const FleetOutlook& outlook, std::int64_t now_us);

  /// Decides anew; once a tick. `own`: as the parameters have it; a change by an operator takes the
  /// boat out of the table's rule until the next table.
  FleetOrder step(const FleetReport& report, const Configuration::Formation& own,
                  std::int64_t leader_limit_us, std::int64_t now_us);

  /// The boat has obeyed kStop, which is ordered until then.
  void stopped();

  /// applied() has changed since the last call.
  [[nodiscard]] bool take_change() { return std::exchange(changed_, false); }

  /// The parameters, with leader and slot by the table if there is one.
  Parameters applied(const Parameters& own) const;

  /// False for a system that is no member of the table that gives the boat its slot.
  bool may_claim(std::uint8_t system) const;

  /// How the slot moves while the shape changes.
  const SlotMotion& slot_motion() const { return slot_motion_; }

  /// The shape changes: places are on their way, or boats still settle in them.
  bool moves(std::int64_t now_us) const;

  /// How far the fleet's last leader was in its plan; no plan if it sailed none, or had paused it.
  const FleetPlace& place() const { return place_; }

  /// Messages that are due.
  std::optional<link::FleetBeacon> beacon(std::int64_t now_us);
  std::optional<link::FleetTable> table(std::int64_t now_us);

  /// News for the operator since the last call: a refused table; the epoch of one in force.
  std::optional<TableVerdict> take_refusal() { return std::exchange(refusal_, std::nullopt); }
  std::optional<std::uint16_t> take_epoch() { return std::exchange(told_epoch_, std::nullopt); }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  struct Hang {
    std::uint8_t leader = 0;
    float north_m = 0, east_m = 0;
    bool turns = false;
    bool operator==(const Hang&) const = default;
  };

  /// A request to give the places.
  struct Wish {
    FleetTable table;
    std::int64_t valid_us = 0, due_us = 0;
  };
  /// A member's place in the shape, and how it moves.
  struct Place {
    std::array<double, 2> cm{}, cmps{}, cmps2{};
  };

  /// A member sends its beacons and all else from one component; 0: no beacon was heard yet.
  /// ahead_ms: since when it names a greater epoch than this boat's; 0: it does not. beacon_ds,
  /// in 0.1 s, and sequence: of its latest beacon.
  struct Heard {
    std::int64_t at_us = kNever;
    std::uint32_t ahead_ms = 0;
    std::uint16_t beacon_ds = 0;
    std::uint8_t component = 0, sequence = 0;
  };

  void take(const link::Received& received, const link::FleetTable& message, Trust trust,
            std::int64_t now_us);
  void take(std::uint8_t from, const link::FleetBeacon& beacon, std::int64_t now_us);
  void take(const FleetTable& table, std::int64_t valid_us, std::int64_t now_us);
  bool is_stop(const FleetTable& table) const;
  static bool is_overtaken(Heard& heard, const link::FleetBeacon& beacon, std::int64_t now_us);
  std::optional<std::int64_t> gives_in(const FleetTable& wanted) const;
  std::optional<Place> place_of(std::uint8_t system, std::int64_t now_us) const;
  static FleetSlot rest_of(const Place& place, double fades_s);
  double since_s(std::int64_t now_us) const;
  FleetMove move(std::int64_t now_us) const;
  double fades_s(std::int64_t now_us, double all_s) const;
  void begin(const Configuration::Formation& own, std::int64_t now_us);
  void listen(std::int64_t limit_us, std::int64_t now_us);
  std::optional<Hang> hang(std::size_t own, std::int64_t now_us) const;
  SlotMotion slot_motion(std::size_t own, std::int64_t now_us) const;
  void speak(const FleetReport& report, std::int64_t now_us);

  FleetLedger ledger_;
  Succession succession_;
  std::array<FleetPeer, FleetTable::kMost> peers_{};
  std::array<Heard, FleetTable::kMost> heard_{};  // by rank
  bool stops_ = false;  // a table ordered a stop, which the boat has not obeyed yet
  std::optional<Hang> hang_;
  Configuration::Formation by_parameters_;  // when the table came into force
  bool by_hand_ = false;
  bool changed_ = false;
  FleetPlace place_;
  core::State state_{};  // in the last step
  std::optional<Wish> wish_;
  // By rank: where the new ways begin, and the speed of the old ones, which fades out meanwhile.
  std::array<FleetSlot, FleetTable::kMost> from_cm_{};
  std::array<FleetSlot, FleetTable::kMost> carried_cmps_{};
  double fades_s_ = 0;
  std::int64_t begun_us_ = 0;
  SlotMotion slot_motion_;
  link::FleetBeacon told_{};
  std::size_t repeats_ = 0;                         // of a changed beacon
  bool asks_ = false;                               // without a table
  std::int64_t beacon_us_ = 0, table_us_ = kNever;  // due
  std::int64_t passed_us_ = kNever;                 // the newest table was last heard or sent
  std::uint8_t system_ = 0;
  std::optional<TableVerdict> refusal_;
  std::optional<std::uint16_t> told_epoch_;
};

}  // namespace flotilla::app
