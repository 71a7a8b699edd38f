// SPDX-License-Identifier: MIT
// Whose place the own slot is besides: the leader's own, where that is a vessel, or that of another
// boat of the same formation.
#pragma once

#include <cstdint>
#include <optional>

#include "app/guidance/tree_place.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

class SlotClaims {
 public:
  /// Slots nearer than beam_m are one. What was heard of another leader counts for nothing.
  void configure(std::uint8_t own_system, std::uint8_t leader, float beam_m);

  /// Any message. A vessel's HEARTBEAT names its kind; GENERIC is a virtual leader's, which takes no
  /// room, so that a slot of zero is sound. Boats tell their slots by FORMATION_REFERENCE.
  void hear(const link::Received& received, const TreePlace& place, std::int64_t now_us);

  /// The slot is where the leader is.
  bool leaders(const TreePlace& place) const;

  /// A boat that has the same slot of the same root: its system id. Who sails in it already, makes
  /// way for one that sails too, not for one that only might.
  std::optional<std::uint8_t> rival(std::int64_t now_us, bool sails) const;

 private:
  bool is_one(const RootOffset& a, const RootOffset& b) const;

  std::uint8_t own_ = 0, leader_ = 0;
  std::int64_t beam_ = 0;  // 1/1024 m
  bool leader_is_vessel_ = false;
  std::uint8_t rival_ = 0;
  bool rival_sails_ = false;
  std::int64_t rival_us_ = 0;
};

}  // namespace flotilla::app
