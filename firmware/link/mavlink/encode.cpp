// SPDX-License-Identifier: MIT
#include "link/mavlink/encode.hpp"

#include <array>
#include <bit>
#include <cstring>

#include "link/mavlink/frame.hpp"

namespace flotilla::link {
namespace {

static_assert(std::endian::native == std::endian::little);

/// Writes a message's full payload, including trailing zeros; returns the data its frame needs.
struct PayloadWriter {
  std::uint8_t* out;

  FrameType operator()(std::monostate) const { return {}; }

  template <class M>
  FrameType operator()(const M& x) const {
    std::memset(out, 0, M::kBytes);
    const auto put = [to = out](std::size_t at, const auto& field) {
      std::memcpy(to + at, &field, sizeof field);
    };
    M::fields(x, put);
    if constexpr (requires { M::constants(put); }) M::constants(put);
    return {M::kId, M::kCrcExtra, M::kBytes};
  }
};

}  // namespace

std::size_t MavlinkEncoder::encode(const Message& message, std::span<std::uint8_t> out,
                                   Signing* signing, std::uint8_t link_id) {
  std::array<std::uint8_t, kMaxPayloadBytes> payload;
  const FrameType type = std::visit(PayloadWriter{payload.data()}, message);
  if (type.payload_bytes == 0) return 0;
  const std::size_t length =
      write_frame(type, payload.data(), {self_, sequence_, signing != nullptr}, out);
  if (length == 0) return 0;
  ++sequence_;
  if (signing == nullptr) return length;
  signing->sign(out.first(length), link_id, out.subspan(length).first<kSignatureBlockBytes>());
  return length + kSignatureBlockBytes;
}

}  // namespace flotilla::link
