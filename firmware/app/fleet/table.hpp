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
  static constexpr std::size_t kMost = 24;  ///< members, as many as one message carries

  std::uint16_t epoch = 0;  ///< 0: no table
  std::uint16_t digest = 0;
  bool turns = false;            ///< the shape turns with the leader's heading
  bool stop = false;             ///< all boats stop
  bool assigns = false;          ///< a request: who hears it gives the places to the members
  std::uint16_t move_ds = 0;     ///< how long the boats take to their new places, 0.1 s; 0: at once
  std::uint16_t first_ds = 0;    ///< when the places change their speed, 0.1 s; 0: never
  std::uint8_t first_share = 0;  ///< s₁ of move.hpp, 1/255
  std::size_t count = 0;
  std::array<FleetMember, kMost> members{};  ///< by rank, the highest first

  std::span<const FleetMember> all() const { return std::span(members).first(count); }

  /// A member's place in `members`; nothing for others.
  std::optional<std::size_t> rank_of(std::uint8_t system) const;
};

/// The reason for which a table is refused.
enum class TableFault : std::uint8_t {
  kNone,
  kEmpty,     ///< no members, or epoch 0
  kTwice,     ///< a system id comes twice
  kTree,      ///< a member follows one that does not come before it, or itself only leads
  kNoLeader,  ///< a member that follows nobody cannot lead
  kTooClose,  ///< two slots are nearer than half of both hulls' lengths together
};
struct TableVerdict {
  TableFault fault = TableFault::kNone;
  std::uint8_t system = 0, other = 0;
};
TableVerdict verdict_of(const FleetTable& table);
/// For the operator: why a table is refused.
Sentence sentence_of(const TableVerdict& refused);

/// A table as the wire has it. A whole table is one message: nobody ever holds a part of one.
FleetTable table_of(const link::FleetTable& message);
/// in_ms: until it comes into force; negative: since then.
link::FleetTable message_of(const FleetTable& table, std::int64_t in_ms);
std::int64_t in_ms_of(const link::FleetTable& message);

}  // namespace flotilla::app
