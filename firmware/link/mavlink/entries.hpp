// SPDX-License-Identifier: MIT
// The generated table of messages (sizes, checksum seeds, offsets of targets) with direct lookup:
// the generated search takes eight steps a message.
#pragma once

#include <flotilla/mavlink.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace flotilla::link {

inline constexpr auto kMavlinkEntries = std::to_array<mavlink_msg_entry_t>(MAVLINK_MESSAGE_CRCS);

/// Index in the table of each low id, which nearly all messages have; the table's size if absent.
inline constexpr std::array<std::uint16_t, 512> kMavlinkPlaces = [] {
  std::array<std::uint16_t, 512> places{};
  places.fill(kMavlinkEntries.size());
  for (std::size_t i = 0; i < kMavlinkEntries.size(); ++i) {
    const std::size_t id = kMavlinkEntries[i].msgid;
    if (id < places.size()) places[id] = static_cast<std::uint16_t>(i);
  }
  return places;
}();

/// nullptr for a message that is not in our dialect.
constexpr const mavlink_msg_entry_t* mavlink_entry(std::uint32_t id) {
  const auto* const end = kMavlinkEntries.data() + kMavlinkEntries.size();
  const auto* const found = id < kMavlinkPlaces.size()
                                ? kMavlinkEntries.data() + kMavlinkPlaces[id]
                                : std::ranges::lower_bound(
                                      kMavlinkEntries.data(), end, id, {},
                                      [](const auto& entry) { return std::uint32_t{entry.msgid}; });
  return found != end && found->msgid == id ? found : nullptr;
}

/// Bytes of a full payload, which the generated struct `Wire` begins with, without inner padding.
template <std::uint32_t kId, class Wire>
constexpr std::size_t mavlink_size() {
  constexpr std::size_t size = mavlink_entry(kId)->max_msg_len;
  static_assert(sizeof(Wire) >= size &&
                sizeof(Wire) - size < std::max<std::size_t>(alignof(Wire), 2));
  static_assert(std::endian::native == std::endian::little);
  return size;
}

}  // namespace flotilla::link
