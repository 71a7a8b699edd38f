// SPDX-License-Identifier: MIT
// Chooses the fleet's leader, and the boat to follow, by the table's rule, without a vote.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "app/fleet/table.hpp"

namespace flotilla::app {

/// A member as this boat knows it now.
struct FleetPeer {
  bool heard = false;       ///< not silent
  bool fit = false;         ///< follows in its slot, or could take over; as last reported
  bool leads = false;       ///< as last reported
  std::uint16_t epoch = 0;  ///< 0: no beacon yet, and may be fit
  std::uint8_t hears = FleetTable::kMax;  ///< rank of the leader that it hears itself; kMax: none
  bool behind : 1 = false;                ///< it follows that leader itself
  bool current : 1 = true;   ///< `hears` is not older than this boat's own loss of that leader
  bool stopped : 1 = false;  ///< an operator has stopped it
  bool recent : 1 = true;    ///< its latest beacon is a few seconds old at most
};

/// This boat.
struct FleetSelf {
  std::size_t rank = 0;
  std::uint16_t epoch = 0;  ///< of the newest table that it holds, as its beacons name it
  bool fit = false;         ///< FORMATION or COAST, and could begin LOITER
  bool drives = false;      ///< any mode with thrust
  bool alone = false;       ///< in a mode without a leader
  bool ordered = false;     ///< in AUTO or GUIDED, which only an operator or this class begins
  bool by_hand = false;     ///< an operator has set its leader or slot since the table came
  bool begun = false;       ///< `alone`, and the mode has changed since the last step
  bool by_sticks = false;   ///< MANUAL
};

/// The rule's request to the boat's supervisor, repeated in each step until it is carried out.
enum class FleetOrder : std::uint8_t {
  kNone,
  kLead,    ///< AUTO with the fleet's plan, else LOITER
  kFollow,  ///< FORMATION
  kStop,    ///< HOLD
};

/// Among members that report leading, the highest (epoch, rank) leads; the others yield. If there
/// is none, the first fit member that can lead takes over, but only once the fleet is under way:
/// after a member has led it. If a boat has stopped since, or was ordered to follow instead of
/// leading, the fleet counts as under way for it only when a member leads again. The table's root
/// also leads in LOITER and RTL if it was in that mode before the fleet was under way, but only
/// once it hears another member: if that member's fleet has a leader, the root leaves the fleet to
/// that leader.
///
/// A mode that an operator or a failsafe sets stays, but a leader's AUTO or GUIDED ends if a
/// better leader appears, and every mode without a leader ends if the table no longer lets the
/// boat lead. A leader that its operator steers by MANUAL goes on leading. A boat in AUTO or GUIDED
/// leads unless a better leader was known when that mode began: it was sent to sail alone then.
///
/// A failed member leaves the tree until the next table or, if it has not been fit under this one,
/// until it is fit. Its followers attach to its leader; it may itself still follow.
///
/// A leader that other members hear also counts if this boat does not hear it. The boat then
/// follows one of them that follows the leader itself. That member must have reported this since
/// this boat lost the leader. So no cycle can form when all lose the leader one after another.
class Succession {
 public:
  static constexpr std::size_t kNobody = FleetTable::kMax;

  /// Call when a table comes into force.
  void begin(const FleetTable& table);

  /// One step per tick. `peers`: by rank, this boat's own is not read.
  FleetOrder step(const FleetTable& table, const FleetSelf& self, std::span<const FleetPeer> peers);

  /// Confirms kStop.
  void confirm_stop() { stopping_ = false; }

  bool leads() const { return leads_; }

  /// If it sails without a leader: whether a leader's failure, not an operator, has caused this.
  bool sails_by_rule() const { return by_rule_; }

  /// Rank of the fleet's leader, possibly this boat's own; kNobody: none is known.
  std::size_t leader() const { return leader_; }

  /// The fleet is under way, and no member reports that it hears a leader.
  bool lost() const { return under_way_ && leader_ == kNobody; }

  /// Rank of the leader if this boat hears it itself, and it has no older table than `epoch`.
  std::optional<std::size_t> heard_leader(const FleetTable& table, std::size_t own,
                                          std::uint16_t epoch,
                                          std::span<const FleetPeer> peers) const;

  /// Rank of the member that this boat follows; nullopt: none is known, or the boat leads.
  std::optional<std::size_t> followed() const { return followed_; }

  /// The complete state as a number, for exhaustive search in tests.
  std::uint64_t code() const;

 private:
  void judge(std::span<const FleetPeer> peers, std::size_t own);
  void choose(const FleetTable& table, const FleetSelf& self, std::span<const FleetPeer> peers);
  void attach_to_leader(const FleetTable& table, std::size_t own, std::span<const FleetPeer> peers);
  std::size_t way_to_leader(std::size_t own, std::span<const FleetPeer> peers) const;
  FleetOrder order(const FleetSelf& self);
  static bool first_fit(const FleetTable& table, std::size_t own, std::span<const FleetPeer> peers);

  bool leads_ = false;
  bool taking_ = false;    // takes over, but is not yet in the leader's mode
  bool by_rule_ = false;   // this class began its mode without a leader
  bool beside_ = false;    // it was sent to sail alone beside a better leader
  bool yielding_ = false;  // yields, but is not yet in FORMATION
  bool under_way_ = false;
  bool stopping_ = false;
  std::size_t leader_ = kNobody;
  std::optional<std::size_t> followed_;
  // Bit masks by rank. out_: has left the tree, until the next table or, without was_fit_, until it
  // is fit.
  std::uint32_t was_fit_ = 0, out_ = 0;
};

}  // namespace flotilla::app
