// SPDX-License-Identifier: MIT
// The layout of MAVLink 1 and 2 frames. Source: mavlink.io, packet serialization.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "link/mavlink/address.hpp"
#include "link/mavlink/crc.hpp"

namespace flotilla::link {

constexpr std::uint8_t kStart1 = 0xFE, kStart2 = 0xFD;
constexpr std::size_t kHeaderBytes1 = 6, kHeaderBytes2 = 10, kMaxPayloadBytes = 255,
                      kChecksumBytes = 2;
constexpr std::uint8_t kSignedFlag = 1;           ///< the only incompatibility flag
constexpr std::size_t kSignatureBlockBytes = 13;  ///< link id, timestamp, signature

constexpr bool is_start(std::uint8_t byte) { return byte == kStart1 || byte == kStart2; }

struct FrameHeader {
  std::size_t header_bytes, payload_bytes;
  std::uint32_t id;
  Address from;
  std::uint8_t sequence;
  std::uint8_t flags;  ///< incompatibility flags

  bool is_signed() const { return (flags & kSignedFlag) != 0; }
  bool is_known() const { return (flags & ~kSignedFlag) == 0; }
  /// Header and payload; the checksum covers them except for the first byte.
  std::size_t covered() const { return header_bytes + payload_bytes; }
  std::size_t frame_bytes() const {
    return covered() + kChecksumBytes + (is_signed() ? kSignatureBlockBytes : 0);
  }
};

/// nullopt if the header is incomplete, or no frame begins here.
inline std::optional<FrameHeader> read_header(std::span<const std::uint8_t> b) {
  if (b.size() >= kHeaderBytes2 && b[0] == kStart2) {
    const std::uint32_t id = b[7] | std::uint32_t{b[8]} << 8U | std::uint32_t{b[9]} << 16U;
    return FrameHeader{kHeaderBytes2, b[1], id, {b[5], b[6]}, b[4], b[2]};
  }
  if (b.size() >= kHeaderBytes1 && b[0] == kStart1) {
    return FrameHeader{kHeaderBytes1, b[1], b[5], {b[3], b[4]}, b[2], 0};
  }
  return std::nullopt;
}

/// Whether the whole frame in `b` has a good checksum.
inline bool checksum_is_good(std::span<const std::uint8_t> b, const FrameHeader& h,
                             std::uint8_t crc_extra) {
  const std::uint16_t crc = mavlink_crc(b.first(h.covered()).subspan(1), crc_extra);
  return b[h.covered()] == (crc & 0xFFU) && b[h.covered() + 1] == crc >> 8U;
}

/// A message's id, its checksum's seed and its longest payload.
struct FrameType {
  std::uint16_t id;
  std::uint8_t crc_extra;
  std::uint8_t payload_bytes;
};

struct FrameSender {
  Address self;
  std::uint8_t sequence;
  bool is_signed;
};

/// Writes a MAVLink 2 frame without the zeros at the payload's end and without the signature block.
/// Returns its length, or 0 if `out` is too short for frame and block.
[[nodiscard]] std::size_t write_frame(FrameType type, const std::uint8_t* payload,
                                      FrameSender sender, std::span<std::uint8_t> out);

}  // namespace flotilla::link
