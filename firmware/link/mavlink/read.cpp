// SPDX-License-Identifier: MIT
#include "link/mavlink/read.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

namespace flotilla::link {
namespace {

static_assert(std::endian::native == std::endian::little);

using Bytes = std::span<const std::uint8_t>;

/// A payload of `size` bytes, with the zeros that the frame left out.
const std::uint8_t* padded(Bytes payload, std::size_t size, std::uint8_t* room) {
  if (payload.size() >= size) return payload.data();
  std::memcpy(room, payload.data(), payload.size());
  std::memset(room + payload.size(), 0, size - payload.size());
  return room;
}

/// Converts to the message's struct in place, without zeroing or copying first.
struct Reader {
  Bytes payload;

  template <class M>
  operator M() const noexcept {
    std::array<std::uint8_t, M::kBytes> room;
    const std::uint8_t* const from = padded(payload, room.size(), room.data());
    M message;
    M::fields(message, [from](std::size_t at, auto& field) {
      std::memcpy(&field, from + at, sizeof field);
    });
    return message;
  }
};

}  // namespace

void read_payload(Bytes payload, std::uint32_t id, Message& out) {
  const Reader reader{payload};
  with_struct(id, [&]<class M>() {
    if constexpr (std::is_same_v<M, std::monostate>) {
      out = M{};
    } else {
      out.emplace<M>(reader);
    }
  });
}

}  // namespace flotilla::link
