// SPDX-License-Identifier: MIT
// Detects other claims to the boat's slot: by the leader, if that is a vessel, or by another boat
// of the same formation.
#pragma once

#include <cstdint>
#include <optional>

#include "app/guidance/tree_place.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

class SlotClaims {
 public:
  /// Slots closer than beam_m count as one. `slot`: relative to the leader, also while the boat
  /// sails alone. A change of leader discards the old one's messages.
  void configure(std::uint8_t own_system, std::uint8_t leader, const convert::WireOffset& slot,
                 float beam_m);

  /// Takes any message. HEARTBEAT gives a vessel's type: GENERIC is a virtual leader, which takes
  /// no room, so a slot of zero is valid behind it. FORMATION_REFERENCE gives a boat's slot, and
  /// counts if the sender `may_claim` a slot of our fleet.
  void hear(const link::Received& received, bool may_claim, const TreePlace& place,
            std::int64_t now_us);

  /// The slot coincides with the leader, which is a vessel.
  bool leaders() const { return leader_is_vessel_ && on_leader_; }

  /// System id of a rival: a boat with the same slot behind the same root. While we sail, a rival
  /// counts only if it sails too and has claimed the slot for 2 s, because two boats that exchange
  /// slots do not do so at the same instant; for 4 s if our system id is the lower one, so that one
  /// of the two sails on.
  std::optional<std::uint8_t> rival(std::int64_t now_us, bool sails) const;

  /// Neither the leader nor another boat claims the slot.
  bool is_free(std::int64_t now_us, bool sails) const {
    return !leaders() && !rival(now_us, sails);
  }

 private:
  bool is_one(const RootOffset& a, const RootOffset& b) const;

  std::uint8_t own_ = 0, leader_ = 0;
  std::int64_t beam_ = 0;  // 1/1024 m
  bool on_leader_ = false, leader_is_vessel_ = false;
  std::uint8_t rival_ = 0;
  bool rival_sails_ = false;
  std::int64_t rival_us_ = 0, rival_since_us_ = 0;
};

}  // namespace flotilla::app
