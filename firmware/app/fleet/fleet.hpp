// SPDX-License-Identifier: MIT
// The boat as a member of a fleet: keeps the table, hears the other members, determines the
// leader. firmware/docs/FLEET.md explains it.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "app/fleet/assignment.hpp"
#include "app/fleet/ledger.hpp"
#include "app/fleet/move.hpp"
#include "app/fleet/paths.hpp"
#include "app/fleet/peers.hpp"
#include "app/fleet/succession.hpp"
#include "app/parameters/configuration.hpp"
#include "app/schedule.hpp"

namespace flotilla::app {

/// Where the fleet is in its plan: opaque id and item.
struct FleetPlace {
  std::uint32_t plan_id = 0;
  std::uint16_t item = 0;
};

/// The state of this boat in a tick.
struct FleetReport {
  std::uint8_t system = 0;
  core::State state = core::State::kDisarmed;
  bool fit = false;      ///< could begin LOITER, and keeps its slot
  FleetPlace place;      ///< of its own plan
  bool stopped = false;  ///< disarmed, or in HOLD by order: the plan that it led ends
};

/// Inactive without a table; requests a table when a beacon names one.
class Fleet {
 public:
  /// Rights of a sender: may command; may, as a member, supply the first table.
  enum class Trust : std::uint8_t { kNone, kMember, kCommands };

  /// Takes any message.
  void hear(const link::Received& received, Trust trust, std::int64_t now_us);

  /// Whether a request to assign places is due: give_places() needs the root's predicted motion.
  bool asks_outlook(std::int64_t now_us) const { return request_ && now_us >= request_->due_us; }
  void give_places(const FleetOutlook& outlook, std::int64_t now_us);

  /// One step per tick. `own`: the configured formation; if an operator changes it, the boat
  /// ignores the table until the next one.
  FleetOrder step(const FleetReport& report, const Configuration::Formation& own,
                  std::int64_t leader_limit_us, std::int64_t now_us);

  /// Confirms kStop, which is repeated until this call.
  void confirm_stop();

  /// Whether applied() has changed since the last call.
  [[nodiscard]] bool take_change() { return std::exchange(changed_, false); }

  bool is_member() const { return ledger_.current() && ledger_.current()->rank_of(system_); }

  /// The parameters, with leader and slot from the table if there is one.
  Parameters applied(const Parameters& own) const;

  /// False for a system outside the table that assigns this boat its slot.
  bool may_claim(std::uint8_t system) const;

  /// How far a member's hull reaches beyond this boat's, 0 if it is no longer; nullopt: unknown.
  std::optional<float> reach_m(std::uint8_t system) const;

  /// The slot's motion while the shape changes.
  const SlotMotion& slot_motion() const { return slot_motion_; }

  /// Whether the shape changes: places move, or boats still settle in them.
  bool moves(std::int64_t now_us) const { return paths_.moves(now_us); }

  /// Plan and item that the last leader reported; no plan if it sailed none, had paused its plan,
  /// or was stopped by an operator.
  const FleetPlace& place() const { return place_; }

  /// Id of the plan that the fleet sailed last, to which the item of place() belongs; 0: none.
  std::uint32_t last_plan_id() const { return plan_id_; }

  /// Messages that are due.
  std::optional<link::FleetBeacon> beacon(std::int64_t now_us);
  std::optional<link::FleetTable> table(std::int64_t now_us);

  /// For the operator, since the last call: a refused table; the epoch of one that came into force.
  std::optional<TableVerdict> take_refusal() { return std::exchange(refusal_, std::nullopt); }
  std::optional<std::uint16_t> take_epoch() { return std::exchange(told_epoch_, std::nullopt); }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  struct Attachment {
    std::uint8_t leader = 0;
    float north_m = 0, east_m = 0;
    bool turns = false;
    bool operator==(const Attachment&) const = default;
  };

  /// A request to assign the places.
  struct Request {
    FleetTable table;
    std::int64_t valid_us = 0, due_us = 0;
  };

  void take(const link::Received& received, const link::FleetTable& message, Trust trust,
            std::int64_t now_us);
  void take(std::uint8_t from, const link::FleetBeacon& beacon, std::int64_t now_us);
  void take(const FleetTable& table, std::int64_t valid_us, std::int64_t now_us);
  void take_member(std::size_t rank, const link::FleetBeacon& beacon, std::int64_t now_us);
  void contradict(const FleetPeer& peer, std::int64_t now_us);
  void note_stop(std::uint8_t system, std::int64_t now_us);
  void note_place(const FleetPlace& place);
  bool is_stop(const FleetTable& table) const;
  bool concerns_us(const FleetTable& table) const;
  bool lacks_leader() const;
  bool has_missed_stop(std::size_t own, const FleetTable& table, std::int64_t since_us) const;
  std::optional<std::int64_t> gives_in(const FleetTable& requested) const;
  void begin(const Configuration::Formation& own, core::State state, std::int64_t now_us);
  std::optional<Attachment> attachment(std::size_t own, std::int64_t now_us) const;
  void update_beacon(const FleetReport& report, bool yields, std::int64_t now_us);

  FleetLedger ledger_;
  Succession succession_;
  FleetPeers peers_;
  bool stops_ = false;  // a table orders a stop, not yet confirmed
  std::optional<Attachment> attachment_;
  Configuration::Formation by_parameters_;  // when the table came into force
  bool by_hand_ = false;
  bool changed_ = false;
  bool sailed_ = false;          // by the law, since this program began
  bool leader_stopped_ = false;  // the last leader, by an operator
  FleetPlace place_;
  std::uint32_t plan_id_ = 0;  // the last one sailed
  core::State state_{};        // in the last step
  std::optional<Request> request_;
  FleetPaths paths_;
  SlotMotion slot_motion_;
  link::FleetBeacon told_{};
  std::size_t repeats_ = 0;                         // of a changed beacon
  bool asks_ = false;                               // without a table
  std::int64_t beacon_us_ = 0, table_us_ = kNever;  // due
  std::int64_t passed_us_ = kNever;                 // the newest table was last heard or sent
  std::int64_t next_burst_us_ = kNever;             // of contradict(), at the earliest
  // when operators last stopped a member, and another one before; since this boat began to sail
  std::int64_t last_stop_us_ = kNever, stop_before_us_ = kNever;
  std::uint8_t last_stopped_ = 0;  // system id of that member
  std::uint8_t system_ = 0;
  std::optional<TableVerdict> refusal_;
  std::optional<std::uint16_t> told_epoch_;
};

}  // namespace flotilla::app
