// SPDX-License-Identifier: MIT
#include "app/fleet/table.hpp"

#include <algorithm>

namespace flotilla::app {
namespace {

constexpr std::size_t kBytes = 8;  // of a member
constexpr std::uint8_t kTurns = 1, kStop = 2, kAssigns = 4, kInForce = 8;
constexpr std::uint8_t kCanLead = 1, kOnlyLeads = 2;
constexpr std::int64_t kSince_ms = 100;  // unit of in_ms with kInForce

static_assert(sizeof(link::FleetTable::members) == kBytes * FleetTable::kMax);

/// FNV-1a, folded to 15 bits (draft-eastlake-fnv). The highest bit is set for a table that stops
/// the boats, so that it wins over others with the same epoch.
std::uint16_t digest_of(const link::FleetTable& message) {
  std::uint32_t hash = 2166136261U;
  const auto add = [&hash](std::uint8_t byte) { hash = (hash ^ byte) * 16777619U; };
  add(message.flags);
  for (const std::uint16_t ds : {message.move_ds, message.first_ds}) {
    add(static_cast<std::uint8_t>(ds & 0xFFU));
    add(static_cast<std::uint8_t>(ds >> 8U));
  }
  add(message.first_share);
  for (const std::uint8_t byte : message.members) add(byte);
  const std::uint32_t folded = (hash ^ hash >> 16U) & 0x7FFFU;
  return static_cast<std::uint16_t>(folded | ((message.flags & kStop) != 0 ? 0x8000U : 0U));
}

std::int16_t int16_of(const std::uint8_t* bytes) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(bytes[0] | bytes[1] << 8U));
}

bool too_close(const FleetMember& a, const FleetMember& b) {
  const std::int64_t x = a.slot_cm[0] - b.slot_cm[0], y = a.slot_cm[1] - b.slot_cm[1];
  const std::int64_t least_cm = std::int64_t{5} * (a.length_dm + b.length_dm);
  return x * x + y * y < std::max<std::int64_t>(least_cm * least_cm, 1);
}

}  // namespace

std::optional<std::size_t> FleetTable::rank_of(std::uint8_t system) const {
  const auto found = std::ranges::find(all(), system, &FleetMember::system);
  if (found == all().end()) return std::nullopt;
  return static_cast<std::size_t>(found - all().begin());
}

TableVerdict verdict_of(const FleetTable& table) {
  if (table.count == 0 || table.epoch == 0) return {TableFault::kEmpty};
  for (std::size_t i = 0; i < table.count; ++i) {
    const FleetMember& member = table.members[i];
    bool led = false;
    for (const FleetMember& before : table.all().first(i)) {
      if (before.system == member.system) return {TableFault::kTwice, member.system};
      if (!table.stop && too_close(before, member))
        return {TableFault::kTooClose, before.system, member.system};
      led = led || before.system == member.leader;
    }
    if (member.leader == 0 && !member.can_lead) return {TableFault::kNoLeader, member.system};
    if (member.leader != 0 && (!led || member.only_leads)) {
      return {TableFault::kTree, member.system, member.leader};
    }
  }
  return {};
}

Sentence sentence_of(const TableVerdict& refused) {
  constexpr std::array<std::string_view, 6> kWhy{"",
                                                 "empty",
                                                 "duplicate boat ",
                                                 "cannot follow its leader: boats ",
                                                 "cannot lead: boat ",
                                                 "slots overlap: boats "};
  Sentence text;
  text << "Fleet table refused: " << kWhy[static_cast<std::size_t>(refused.fault)];
  if (refused.system != 0) text << static_cast<float>(refused.system);
  if (refused.other != 0) text << ", " << static_cast<float>(refused.other);
  return text;
}

FleetTable table_of(const link::FleetTable& message) {
  FleetTable table{.epoch = message.epoch,
                   .turns = (message.flags & kTurns) != 0,
                   .stop = (message.flags & kStop) != 0,
                   .assigns = (message.flags & kAssigns) != 0,
                   .move_ds = message.move_ds,
                   .first_ds = message.first_ds,
                   .first_share = message.first_share};
  while (table.count < FleetTable::kMax && message.members[kBytes * table.count] != 0) {
    const std::uint8_t* bytes = message.members.data() + kBytes * table.count;
    table.members[table.count++] = {.system = bytes[0],
                                    .leader = bytes[1],
                                    .can_lead = (bytes[2] & (kCanLead | kOnlyLeads)) != 0,
                                    .only_leads = (bytes[2] & kOnlyLeads) != 0,
                                    .length_dm = bytes[3],
                                    .slot_cm = {int16_of(bytes + 4), int16_of(bytes + 6)}};
  }
  table.digest = digest_of(message_of(table, 0));  // of the message as a boat relays it
  return table;
}

std::int64_t in_ms_of(const link::FleetTable& message) {
  const bool in_force = (message.flags & kInForce) != 0;
  return std::int64_t{message.in_ms} * (in_force ? -kSince_ms : 1);
}

link::FleetTable message_of(const FleetTable& table, std::int64_t in_ms) {
  link::FleetTable message{};
  const std::int64_t told = in_ms < 0 ? (kSince_ms / 2 - in_ms) / kSince_ms : in_ms;
  message.in_ms = static_cast<std::uint16_t>(std::min<std::int64_t>(told, 65'535));
  message.epoch = table.epoch;
  message.move_ds = table.move_ds;
  message.first_ds = table.first_ds;
  message.first_share = table.first_share;
  message.flags =
      static_cast<std::uint8_t>((table.turns ? kTurns : 0U) | (table.stop ? kStop : 0U) |
                                (table.assigns ? kAssigns : 0U) | (in_ms < 0 ? kInForce : 0U));
  std::uint8_t* byte = message.members.data();
  for (const FleetMember& member : table.all()) {
    *byte++ = member.system;
    *byte++ = member.leader;
    *byte++ = member.only_leads ? kOnlyLeads : member.can_lead ? kCanLead : std::uint8_t{0};
    *byte++ = member.length_dm;
    for (const std::int16_t cm : member.slot_cm) {
      *byte++ = static_cast<std::uint8_t>(static_cast<std::uint16_t>(cm) & 0xFFU);
      *byte++ = static_cast<std::uint8_t>(static_cast<std::uint16_t>(cm) >> 8U);
    }
  }
  return message;
}

}  // namespace flotilla::app
