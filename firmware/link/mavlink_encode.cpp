// SPDX-License-Identifier: MIT
#include "link/mavlink_encode.hpp"

#include "link/mavlink_crc.hpp"
#include "link/mavlink_write.hpp"

namespace flotilla::link {
namespace {

/// A frame says that it is signed, and its checksum covers that.
void mark_as_signed(const mavlink_message_t& m, std::span<std::uint8_t> frame) {
  const std::size_t covered = frame.size() - MAVLINK_NUM_CHECKSUM_BYTES;
  frame[2] |= MAVLINK_IFLAG_SIGNED;
  const std::uint16_t crc = mavlink_crc(frame.first(covered).subspan(1), mavlink_get_crc_extra(&m));
  frame[covered] = static_cast<std::uint8_t>(crc);
  frame[covered + 1] = static_cast<std::uint8_t>(crc >> 8U);
}

}  // namespace

std::size_t MavlinkEncoder::encode(const Message& message, std::span<std::uint8_t> out,
                                   Signing* signing, std::uint8_t link_id) {
  if (std::holds_alternative<std::monostate>(message)) return 0;
  mavlink_status_t status{};
  status.current_tx_seq = sequence_;
  mavlink_message_t m;
  std::visit(MavlinkWriter{self_, status, m}, message);
  const std::size_t length = MAVLINK_NUM_NON_PAYLOAD_BYTES + std::size_t{m.len};
  const std::size_t block = signing != nullptr ? kSignatureBlockBytes : 0;
  if (length + block > out.size()) return 0;
  sequence_ = status.current_tx_seq;
  mavlink_msg_to_send_buffer(out.data(), &m);
  if (signing != nullptr) {
    mark_as_signed(m, out.first(length));
    signing->sign(out.first(length), link_id, out.subspan(length).first<kSignatureBlockBytes>());
  }
  return length + block;
}

}  // namespace flotilla::link
