// SPDX-License-Identifier: MIT
#include "link/mavlink/frame.hpp"

#include <algorithm>
#include <array>

#include "link/mavlink/crc.hpp"

namespace flotilla::link {

std::size_t write_frame(FrameType type, const std::uint8_t* payload, FrameSender sender,
                        std::span<std::uint8_t> out) {
  std::size_t size = type.payload_bytes;
  while (size > 1 && payload[size - 1] == 0) --size;
  const std::size_t covered = kHeaderBytes2 + size;
  const std::size_t length = covered + kChecksumBytes;
  if (length + (sender.is_signed ? kSignatureBlockBytes : 0) > out.size()) return 0;
  const auto byte = [](std::size_t number) { return static_cast<std::uint8_t>(number); };
  const std::array<std::uint8_t, kHeaderBytes2> header{kStart2,
                                                       byte(size),
                                                       sender.is_signed ? kSignedFlag : byte(0),
                                                       0,
                                                       sender.sequence,
                                                       sender.self.system,
                                                       sender.self.component,
                                                       byte(type.id),
                                                       byte(type.id >> 8U),
                                                       0};
  std::copy(header.begin(), header.end(), out.begin());
  std::copy_n(payload, size, out.begin() + kHeaderBytes2);
  const std::uint16_t crc = mavlink_crc(out.first(covered).subspan(1), type.crc_extra);
  out[covered] = byte(crc & 0xFFU);
  out[covered + 1] = byte(crc >> 8U);
  return length;
}

}  // namespace flotilla::link
