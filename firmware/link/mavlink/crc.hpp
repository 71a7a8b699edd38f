// SPDX-License-Identifier: MIT
// MAVLink's checksum, CRC-16/MCRF4XX: reflected polynomial 0x8408, initial value 0xFFFF. Uses tables,
// eight bytes at a time (one on a microcontroller, to save flash): the generated crc_calculate()
// works bit by bit and took half of the decoding time. Source: M. E. Kounavis, F. L. Berry, A
// Systematic Approach to Building High Performance Software-based CRC Generators ("slicing by 8").
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace flotilla::link {

constexpr std::size_t kCrcRows = sizeof(void*) == 8 ? 8 : 1;

/// Row k: the CRC of a byte followed by k zeros, from initial value 0.
inline constexpr std::array<std::array<std::uint16_t, 256>, kCrcRows> kMavlinkCrcTables = [] {
  std::array<std::array<std::uint16_t, 256>, kCrcRows> tables{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0x8408U : 0U);
    tables[0][byte] = static_cast<std::uint16_t>(crc);
  }
  for (std::size_t k = 1; k < tables.size(); ++k) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const unsigned crc = tables[k - 1][byte];
      tables[k][byte] = static_cast<std::uint16_t>((crc >> 8U) ^ tables[0][crc & 0xFFU]);
    }
  }
  return tables;
}();

/// The checksum of a frame's bytes after the start byte, followed by the message's seed crc_extra.
constexpr std::uint16_t mavlink_crc(std::span<const std::uint8_t> bytes, std::uint8_t crc_extra) {
  const auto& t = kMavlinkCrcTables;
  unsigned crc = 0xFFFF;
  const std::uint8_t* b = bytes.data();
  std::size_t left = bytes.size();
  if constexpr (kCrcRows == 8) {
    for (; left >= 8; left -= 8, b += 8) {
      crc = t[7][(crc ^ b[0]) & 0xFFU] ^ t[6][(crc >> 8U) ^ b[1]] ^ t[5][b[2]] ^ t[4][b[3]] ^
            t[3][b[4]] ^ t[2][b[5]] ^ t[1][b[6]] ^ t[0][b[7]];
    }
    for (; left >= 2; left -= 2, b += 2) {
      crc = t[1][(crc ^ b[0]) & 0xFFU] ^ t[0][(crc >> 8U) ^ b[1]];
    }
  }
  for (; left > 0; --left, ++b) crc = (crc >> 8U) ^ t[0][(crc ^ *b) & 0xFFU];
  return static_cast<std::uint16_t>((crc >> 8U) ^ t[0][(crc ^ crc_extra) & 0xFFU]);
}

}  // namespace flotilla::link
