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
#include <vector>

#include "link/mavlink/frame.hpp"

namespace flotilla::fleet {

/// A message's number and the seed of its checksum.
struct MessageType {
  std::uint16_t id;
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
    std::array<std::uint8_t, kPayload> payload;
    std::uint8_t* at = payload.data();
    ((std::memcpy(at, &fields, sizeof fields), at += sizeof fields), ...);
    std::array<std::uint8_t, link::kHeaderBytes2 + kPayload + link::kChecksumBytes> frame;
    const std::size_t length = link::write_frame(
        {type.id, type.crc_extra, kPayload}, payload.data(), {self_, sequence_++, false}, frame);
    out.insert(out.end(), frame.data(), frame.data() + length);
  }

 private:
  link::Address self_;
  std::uint8_t sequence_ = 0;
};

}  // namespace flotilla::fleet
