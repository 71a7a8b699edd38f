// SPDX-License-Identifier: MIT
// The fleet's table: its members by rank, each one's leader and place in the shape.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "app/sentence.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// A place in the shape, cm: ahead and to starboard, or north and east.
using FleetSlot = std::array<std::int16_t, 2>;

struct FleetMember {
  std::uint8_t system = 0;
  std::uint8_t leader = 0;  ///< system id of the member that it follows; 0: it leads
  bool can_lead = false;
  bool only_leads = false;  ///< an autopilot or a tablet, which sends no FLEET_BEACON
  std::uint8_t length_dm = 0;
  FleetSlot slot_cm{};
};

/// Shares go over the wire as integers from 0 to kShares.
constexpr double kShares = 255;

struct FleetTable {
  static constexpr std::size_t kMax = 24;  ///< members, as many as one message carries

  std::uint16_t epoch = 0;  ///< 0: no table
  std::uint16_t digest = 0;
  bool turns = false;            ///< the shape turns with the leader's heading
  bool stop = false;             ///< all boats stop
  bool assigns = false;          ///< a request to assign the places to the members
  std::uint16_t move_ds = 0;     ///< duration of the move to the new places, 0.1 s; 0: at once
  std::uint16_t first_ds = 0;    ///< T₁ of move.hpp, 0.1 s; 0: one speed
  std::uint8_t first_share = 0;  ///< s₁ of move.hpp, 1/255
  std::size_t count = 0;
  std::array<FleetMember, kMax> members{};  ///< by rank, the highest first

  std::span<const FleetMember> all() const { return std::span(members).first(count); }

  /// Index of a member in `members`; nullopt for other systems.
  std::optional<std::size_t> rank_of(std::uint8_t system) const;
};

/// Why a table is refused.
enum class TableFault : std::uint8_t {
  kNone,
  kEmpty,     ///< no members, or epoch 0
  kTwice,     ///< duplicate system id
  kTree,      ///< a member follows one that does not come before it, or itself only leads
  kNoLeader,  ///< a member that follows nobody cannot lead
  kTooClose,  ///< two slots are closer than half the sum of their hulls' lengths
};
struct TableVerdict {
  TableFault fault = TableFault::kNone;
  std::uint8_t system = 0, other = 0;
};
TableVerdict verdict_of(const FleetTable& table);
/// For the operator: why a table is refused.
Sentence sentence_of(const TableVerdict& refused);

/// To and from the message. A whole table is one message, so no boat ever holds a part of one.
FleetTable table_of(const link::FleetTable& message);
/// in_ms: time until it comes into force; negative: time since then.
link::FleetTable message_of(const FleetTable& table, std::int64_t in_ms);
std::int64_t in_ms_of(const link::FleetTable& message);

}  // namespace flotilla::app
