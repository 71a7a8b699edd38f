// SPDX-License-Identifier: MIT
#include "link/mavlink/encode.hpp"

#include <array>
#include <bit>
#include <cstring>

#include "link/mavlink/frame.hpp"

namespace flotilla::link {

static_assert(std::endian::native == std::endian::little);

std::size_t MavlinkEncoder::encode(const Message& message, std::span<std::uint8_t> out,
                                   Signing* signing, std::uint8_t link_id) {
  const auto write = [&]<class M>(const M& x) -> std::size_t {
    if constexpr (std::is_same_v<M, std::monostate>) {
      return 0;
    } else {
      std::array<std::uint8_t, M::kBytes> payload{};
      const auto put = [&payload](std::size_t at, const auto& field) {
        std::memcpy(payload.data() + at, &field, sizeof field);
      };
      M::fields(x, put);
      if constexpr (requires { M::constants(put); }) M::constants(put);
      return write_frame({M::kId, M::kCrcExtra, self_, sequence_, signing != nullptr}, payload,
                         out);
    }
  };
  const std::size_t length = std::visit(write, message);
  if (length == 0) return 0;
  ++sequence_;
  if (signing == nullptr) return length;
  signing->sign(out.first(length), link_id, out.subspan(length).first<kSignatureBlockBytes>());
  return length + kSignatureBlockBytes;
}

}  // namespace flotilla::link
