// SPDX-License-Identifier: MIT
// CRC-16-CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, most significant bit first.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace flotilla::link {

constexpr std::uint16_t kCrc16Start = 0xFFFF;

inline constexpr std::array<std::uint16_t, 256> kCrc16Table = [] {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < table.size(); ++byte) {
    unsigned crc = byte << 8U;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1U) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U);
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}();

/// Continues `crc` over further bytes.
constexpr std::uint16_t crc16(std::uint16_t crc, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>((crc << 8U) ^ kCrc16Table[(crc >> 8U) ^ byte]);
  }
  return crc;
}

}  // namespace flotilla::link
