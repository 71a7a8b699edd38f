// SPDX-License-Identifier: MIT
// The layout of MAVLink 1 and 2 frames. Source: mavlink.io, packet serialization.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "link/mavlink/address.hpp"

namespace flotilla::link {

constexpr std::uint8_t kStart1 = 0xFE, kStart2 = 0xFD;
constexpr std::size_t kHeaderBytes1 = 6, kHeaderBytes2 = 10, kChecksumBytes = 2;
constexpr std::uint8_t kSignedFlag = 1;           ///< the only incompatibility flag
constexpr std::size_t kSignatureBlockBytes = 13;  ///< link id, timestamp, signature

constexpr bool is_start(std::uint8_t byte) { return byte == kStart1 || byte == kStart2; }

struct FrameHeader {
  std::size_t header_bytes, payload_bytes;
  std::uint32_t id;
  Address from;
  std::uint8_t sequence;
  std::uint8_t flags;  ///< of incompatibility

  bool is_signed() const { return (flags & kSignedFlag) != 0; }
  bool is_known() const { return (flags & ~kSignedFlag) == 0; }
  /// Header and payload; the checksum covers them except for the first byte.
  std::size_t covered() const { return header_bytes + payload_bytes; }
  std::size_t frame_bytes() const {
    return covered() + kChecksumBytes + (is_signed() ? kSignatureBlockBytes : 0);
  }
};

/// Nothing while it is incomplete, or where no frame begins.
std::optional<FrameHeader> read_header(std::span<const std::uint8_t> bytes);

/// Whether the whole frame in `bytes` has a good checksum.
bool checksum_is_good(std::span<const std::uint8_t> bytes, const FrameHeader& header,
                      std::uint8_t crc_extra);

/// How to write a frame.
struct FrameType {
  std::uint32_t id;
  std::uint8_t crc_extra;
  Address self;
  std::uint8_t sequence;
  bool is_signed;
};

/// Writes a MAVLink 2 frame without the zeros at the payload's end and without the signature block.
/// Returns its length, or 0 where `out` is too short for frame and block.
std::size_t write_frame(const FrameType& type, std::span<const std::uint8_t> payload,
                        std::span<std::uint8_t> out);

}  // namespace flotilla::link
