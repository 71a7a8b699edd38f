// SPDX-License-Identifier: MIT
#include "link/mavlink/read.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

#include "link/mavlink/layout.hpp"

namespace flotilla::link {
namespace {

static_assert(std::endian::native == std::endian::little);

using Bytes = std::span<const std::uint8_t>;

/// Converts to the message's struct in place, without zeroing or copying first.
struct Reader {
  Bytes payload;

  template <class M>
  operator M() const noexcept {
    M message;
    read(kLayout<M>, reinterpret_cast<std::byte*>(&message));
    return message;
  }

  /// The bytes that the frame left out are zero.
  void read(const Layout& layout, std::byte* out) const {
    std::array<std::byte, kMaxPayloadBytes> room;
    const std::byte* from = reinterpret_cast<const std::byte*>(payload.data());
    if (payload.size() < layout.type.payload_bytes) {
      std::memcpy(room.data(), from, payload.size());
      std::memset(room.data() + payload.size(), 0, layout.type.payload_bytes - payload.size());
      from = room.data();
    }
    for (const Place& place : layout.places()) {
      copy_bytes(out + place.in_struct, from + place.in_payload, place.bytes);
    }
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
