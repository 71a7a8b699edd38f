// SPDX-License-Identifier: MIT
// The data needed to check and route a frame, for all messages of the dialect, including those that
// this firmware does not read.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace flotilla::link {

struct MavlinkEntry {
  std::uint16_t id;
  std::uint8_t crc_extra;                        ///< seed of the checksum
  std::uint8_t min_bytes;                        ///< payload without MAVLink 2 extensions
  std::uint8_t target_system, target_component;  ///< offsets in the payload, 255: none
};

/// Sorted by id.
inline constexpr auto kMavlinkEntries = std::to_array<MavlinkEntry>({
#include "dialect/table.inc"
});

/// Index in the table for each id below 512, as nearly all messages have; the table's size if the
/// id is absent.
inline constexpr std::array<std::uint8_t, 512> kMavlinkPlaces = [] {
  static_assert(kMavlinkEntries.size() < 256);
  std::array<std::uint8_t, 512> places{};
  places.fill(kMavlinkEntries.size());
  for (std::size_t i = 0; i < kMavlinkEntries.size(); ++i) {
    const std::size_t id = kMavlinkEntries[i].id;
    if (id < places.size()) places[id] = static_cast<std::uint8_t>(i);
  }
  return places;
}();

/// nullptr for a message that is not in our dialect.
constexpr const MavlinkEntry* mavlink_entry(std::uint32_t id) {
  const auto* const end = kMavlinkEntries.data() + kMavlinkEntries.size();
  const auto* const found =
      id < kMavlinkPlaces.size()
          ? kMavlinkEntries.data() + kMavlinkPlaces[id]
          : std::ranges::lower_bound(kMavlinkEntries.data(), end, id, {}, &MavlinkEntry::id);
  return found != end && found->id == id ? found : nullptr;
}

}  // namespace flotilla::link
