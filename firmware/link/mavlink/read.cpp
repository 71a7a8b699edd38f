// SPDX-License-Identifier: MIT
#include "link/mavlink/read.hpp"

#include <array>
#include <bit>
#include <cstring>

namespace flotilla::link {

static_assert(std::endian::native == std::endian::little);

void read_payload(std::span<const std::uint8_t> payload, std::uint32_t id, Message& out) {
  with_struct(id, [&]<class M>() {
    M& message = out.emplace<M>();
    if constexpr (!std::is_same_v<M, std::monostate>) {
      std::array<std::uint8_t, M::kBytes> padded;
      const std::uint8_t* from = payload.data();
      if (payload.size() < M::kBytes) {
        std::memcpy(padded.data(), from, payload.size());
        std::memset(padded.data() + payload.size(), 0, M::kBytes - payload.size());
        from = padded.data();
      }
      M::fields(message, [from](std::size_t at, auto& field) {
        std::memcpy(&field, from + at, sizeof field);
      });
    }
  });
}

}  // namespace flotilla::link
