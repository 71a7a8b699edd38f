// SPDX-License-Identifier: MIT
// Writes one sender's MAVLink 2 frames from their messages' fields. The firmware's own encoder
// marks every ODOMETRY as an autopilot's estimate, so it does not serve here.
// Source: mavlink.io, packet serialization.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "link/mavlink/crc.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::fleet {

/// A message's number and the seed of its checksum.
struct MessageType {
  std::uint32_t id;
  std::uint8_t crc_extra;
};

class FrameWriter {
 public:
  explicit FrameWriter(link::Address self) : self_(self) {}

  /// Appends a frame to `out`; `fields` in wire order. Trailing zeros are cut off.
  template <class... Fields>
  void write(std::vector<std::uint8_t>& out, MessageType type, const Fields&... fields) {
    static_assert(std::endian::native == std::endian::little);
    constexpr std::size_t kPayload = (sizeof(Fields) + ...);
    static_assert(kPayload <= 255);
    std::array<std::uint8_t, kHeader + kPayload + kChecksum> frame;
    std::uint8_t* at = frame.data() + kHeader;
    ((std::memcpy(at, &fields, sizeof fields), at += sizeof fields), ...);
    std::size_t length = kPayload;
    while (length > 1 && frame[kHeader + length - 1] == 0) --length;
    const std::array<std::uint8_t, kHeader> header{0xFD,
                                                   static_cast<std::uint8_t>(length),
                                                   0,
                                                   0,
                                                   sequence_++,
                                                   self_.system,
                                                   self_.component,
                                                   static_cast<std::uint8_t>(type.id),
                                                   static_cast<std::uint8_t>(type.id >> 8U),
                                                   static_cast<std::uint8_t>(type.id >> 16U)};
    std::memcpy(frame.data(), header.data(), kHeader);
    const std::span covered(frame.data() + 1, kHeader - 1 + length);
    const std::uint16_t crc = link::mavlink_crc(covered, type.crc_extra);
    std::memcpy(frame.data() + kHeader + length, &crc, kChecksum);
    out.insert(out.end(), frame.data(), frame.data() + kHeader + length + kChecksum);
  }

 private:
  static constexpr std::size_t kHeader = 10, kChecksum = 2;
  link::Address self_;
  std::uint8_t sequence_ = 0;
};

}  // namespace flotilla::fleet
