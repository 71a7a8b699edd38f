// SPDX-License-Identifier: MIT
#include "link/mavlink_encode.hpp"

#include "link/mavlink_write.hpp"

namespace flotilla::link {

std::size_t MavlinkEncoder::encode(const Message& message, std::span<std::uint8_t> out) {
  if (std::holds_alternative<std::monostate>(message)) return 0;
  mavlink_status_t status{};
  status.current_tx_seq = sequence_;
  mavlink_message_t m;
  std::visit(MavlinkWriter{self_, status, m}, message);
  const std::size_t length = MAVLINK_NUM_NON_PAYLOAD_BYTES + std::size_t{m.len};
  if (length > out.size()) return 0;
  sequence_ = status.current_tx_seq;
  return mavlink_msg_to_send_buffer(out.data(), &m);
}

}  // namespace flotilla::link
