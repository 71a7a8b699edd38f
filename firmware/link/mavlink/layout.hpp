// SPDX-License-Identifier: MIT
// Where each message has its bytes in its struct and in its payload, as tables: one loop reads, and
// one writes, all messages.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>
#include <variant>

#include "link/mavlink/frame.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::link {

/// The places of M's members; neighbours in struct and payload are one.
template <class M>
inline constexpr auto kPlaces = [] {
  constexpr auto joined = [] {
    auto places = M::places();
    std::size_t last = 0;
    for (std::size_t i = 1; i < places.size(); ++i) {
      Place& before = places[last];
      const Place& next = places[i];
      if (before.in_struct + before.bytes == next.in_struct &&
          before.in_payload + before.bytes == next.in_payload) {
        before.bytes = static_cast<std::uint8_t>(before.bytes + next.bytes);
      } else {
        places[++last] = next;
      }
    }
    return std::pair(places, last + 1);
  }();
  std::array<Place, joined.second> places;
  std::copy_n(joined.first.begin(), places.size(), places.begin());
  return places;
}();

class Layout {
 public:
  FrameType type{};
  bool has_constants = false;

  constexpr Layout() = default;
  constexpr Layout(FrameType of, std::span<const Place> places)
      : type(of),
        has_constants(std::ranges::any_of(kConstants, [of](auto c) { return c.id == of.id; })),
        count_(static_cast<std::uint8_t>(places.size())),
        first_(places.data()) {}

  constexpr std::span<const Place> places() const { return {first_, count_}; }

 private:
  std::uint8_t count_ = 0;
  const Place* first_ = nullptr;
};

template <class M>
inline constexpr Layout kLayout{{M::kId, M::kCrcExtra, M::kBytes}, kPlaces<M>};
template <>
inline constexpr Layout kLayout<std::monostate>{};

/// Copies a few bytes between any addresses, four at a time: the library's copies single bytes then.
inline void copy_bytes(std::byte* to, const std::byte* from, std::size_t count) {
  constexpr std::size_t kWord = 4;
  const std::byte* const end = from + count;
  for (const auto* words = end - count % kWord; from != words; from += kWord, to += kWord) {
    std::memcpy(to, from, kWord);
  }
  while (from != end) *to++ = *from++;
}

}  // namespace flotilla::link
