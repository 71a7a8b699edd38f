// SPDX-License-Identifier: MIT
// Chooses the fleet's leader, and the boat to follow, by the rule of the table: nobody votes.
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
  bool fit = false;         ///< follows in its slot, or could take over; as it said last
  bool leads = false;       ///< as it said last
  std::uint16_t epoch = 0;  ///< 0: it has said nothing yet, and may be fit
};

/// This boat.
struct FleetSelf {
  std::size_t rank = 0;
  std::uint16_t epoch = 0;  ///< of the newest table that it holds, as its beacons name it
  bool fit = false;         ///< FORMATION or COAST, and could begin LOITER
  bool drives = false;      ///< any mode with thrust
  bool alone = false;       ///< a mode without a leader
  bool ordered = false;     ///< AUTO or GUIDED, which only an operator or this class begins
  bool by_hand = false;     ///< an operator has set its leader or slot since the table came
  bool begun = false;       ///< it is alone, in another mode than in the last step
};

/// The rule's request to the boat's supervisor; repeated in each step until it is done.
enum class FleetOrder : std::uint8_t {
  kNone,
  kLead,    ///< AUTO with the fleet's plan, else LOITER
  kFollow,  ///< FORMATION
  kStop,    ///< HOLD
};

/// Of those that say they lead, the one with the higher epoch, then rank, is the leader; the other
/// ones yield. If none is left, the first fit member that can lead takes over. The fleet is under
/// way, and members are replaced, only after somebody has led it; for a boat that has stopped since,
/// or was told to follow instead of leading, only after somebody leads it again. A mode that an
/// operator sets is left to nobody. Who has failed stays out of the tree, its followers hang on
/// its own leader, until the next table; but it may follow.
class Succession {
 public:
  static constexpr std::size_t kNobody = FleetTable::kMost;

  /// A table comes into force.
  void begin(const FleetTable& table);

  /// Decides anew. `peers`: by rank, this boat's own is not read.
  FleetOrder step(const FleetTable& table, const FleetSelf& self, std::span<const FleetPeer> peers);

  /// The boat has obeyed kStop.
  void stopped() { stopping_ = false; }

  bool leads() const { return leads_; }

  /// Rank of the fleet's leader, maybe this boat's own; kNobody: none is known.
  std::size_t leader() const { return leader_; }

  /// Rank of the member that this boat follows; nothing: none is known, or the boat leads.
  std::optional<std::size_t> followed() const { return followed_; }

  /// Its whole memory, for a search through all states.
  std::uint64_t code() const;

 private:
  void judge(std::span<const FleetPeer> peers, std::size_t own);
  void choose(const FleetTable& table, const FleetSelf& self, std::span<const FleetPeer> peers);
  void hang(const FleetTable& table, std::size_t own);
  FleetOrder order(const FleetSelf& self);
  static bool first_fit(const FleetTable& table, std::size_t own, std::span<const FleetPeer> peers);

  bool leads_ = false;
  bool taking_ = false;    // over: not yet in the mode
  bool yielding_ = false;  // not yet in FORMATION
  bool under_way_ = false;
  bool stopping_ = false;
  std::size_t leader_ = kNobody;
  std::optional<std::size_t> followed_;
  std::uint32_t was_fit_ = 0, out_ = 0;  // by rank, a bit each
};

}  // namespace flotilla::app
