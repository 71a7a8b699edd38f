// SPDX-License-Identifier: MIT
#include "link/mavlink/encode.hpp"

#include <array>
#include <bit>
#include <cstring>

#include "link/mavlink/layout.hpp"

namespace flotilla::link {
namespace {

static_assert(std::endian::native == std::endian::little);

/// By the message's place in the variant.
template <class... M>
constexpr auto layouts_of(const std::variant<M...>*) {
  return std::array{kLayout<M>...};
}
constexpr auto kLayouts = layouts_of(static_cast<const Message*>(nullptr));

/// Writes a message's full payload, without truncating its zeros.
void write_payload(const Message& message, const Layout& layout, std::byte* out) {
  const auto* in =
      std::visit([](const auto& m) { return reinterpret_cast<const std::byte*>(&m); }, message);
  std::memset(out, 0, layout.type.payload_bytes);
  for (const auto& [in_struct, in_payload, bytes] : layout.places()) {
    copy_bytes(out + in_payload, in + in_struct, bytes);
  }
  if (!layout.has_constants) return;
  for (const auto& [id, in_payload, byte] : kConstants) {
    if (id == layout.type.id) out[in_payload] = std::byte{byte};
  }
}

}  // namespace

std::size_t MavlinkEncoder::encode(const Message& message, std::span<std::uint8_t> out,
                                   Signing* signing, std::uint8_t link_id) {
  std::array<std::uint8_t, kMaxPayloadBytes> payload;
  const Layout& layout = kLayouts[message.index()];
  if (layout.places().empty()) return 0;
  write_payload(message, layout, reinterpret_cast<std::byte*>(payload.data()));
  const std::size_t length =
      write_frame(layout.type, payload.data(), {self_, sequence_, signing != nullptr}, out);
  if (length == 0) return 0;
  ++sequence_;
  if (signing == nullptr) return length;
  signing->sign(out.first(length), link_id, out.subspan(length).first<kSignatureBlockBytes>());
  return length + kSignatureBlockBytes;
}

}  // namespace flotilla::link
