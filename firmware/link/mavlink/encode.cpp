// SPDX-License-Identifier: MIT
#include "link/mavlink/encode.hpp"

#include "link/mavlink/crc.hpp"
#include "link/mavlink/write.hpp"

namespace flotilla::link {
namespace {

constexpr std::size_t kHeaderBytes = MAVLINK_NUM_HEADER_BYTES, kChecksumBytes = 2;

/// Trailing zeros are not sent; the first byte always is.
std::size_t trimmed_size(std::span<const std::uint8_t> payload) {
  std::size_t size = payload.size();
  while (size > 1 && payload[size - 1] == 0) --size;
  return size;
}

}  // namespace

std::size_t MavlinkWriter::frame(std::uint32_t id, std::uint8_t crc_extra,
                                 std::span<const std::uint8_t> payload) const {
  const std::size_t size = trimmed_size(payload);
  const std::size_t covered = kHeaderBytes + size;
  const std::size_t length = covered + kChecksumBytes;
  if (length + (is_signed ? kSignatureBlockBytes : 0) > out.size()) return 0;
  const auto byte = [](std::size_t number) { return static_cast<std::uint8_t>(number); };
  const std::array<std::uint8_t, kHeaderBytes> header{MAVLINK_STX,
                                                      byte(size),
                                                      byte(is_signed ? MAVLINK_IFLAG_SIGNED : 0),
                                                      0,
                                                      sequence,
                                                      self.system,
                                                      self.component,
                                                      byte(id),
                                                      byte(id >> 8U),
                                                      byte(id >> 16U)};
  std::copy(header.begin(), header.end(), out.begin());
  std::copy_n(payload.begin(), size, out.begin() + kHeaderBytes);
  const std::uint16_t crc = mavlink_crc(out.first(covered).subspan(1), crc_extra);
  out[covered] = byte(crc & 0xFFU);
  out[covered + 1] = byte(crc >> 8U);
  return length;
}

std::size_t MavlinkEncoder::encode(const Message& message, std::span<std::uint8_t> out,
                                   Signing* signing, std::uint8_t link_id) {
  const std::size_t length =
      std::visit(MavlinkWriter{self_, sequence_, signing != nullptr, out}, message);
  if (length == 0) return 0;
  ++sequence_;
  if (signing == nullptr) return length;
  signing->sign(out.first(length), link_id, out.subspan(length).first<kSignatureBlockBytes>());
  return length + kSignatureBlockBytes;
}

}  // namespace flotilla::link
