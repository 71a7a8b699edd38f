// SPDX-License-Identifier: MIT
// CRC-16-CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, most significant bit first.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace flotilla::link {

constexpr std::uint16_t kCrc16Start = 0xFFFF;

/// Of each half byte; a table of whole bytes would need 480 bytes more.
inline constexpr std::array<std::uint16_t, 16> kCrc16Table = [] {
  std::array<std::uint16_t, 16> table{};
  for (unsigned half = 0; half < table.size(); ++half) {
    unsigned crc = half << 12U;
    for (int bit = 0; bit < 4; ++bit) crc = (crc << 1U) ^ ((crc & 0x8000U) != 0 ? 0x1021U : 0U);
    table[half] = static_cast<std::uint16_t>(crc);
  }
  return table;
}();

/// Continues `crc` over further bytes.
constexpr std::uint16_t crc16(std::uint16_t crc, std::span<const std::uint8_t> bytes) {
  const auto add = [&crc](unsigned half) {
    crc = static_cast<std::uint16_t>((crc << 4U) ^ kCrc16Table[(crc >> 12U) ^ half]);
  };
  for (const std::uint8_t byte : bytes) {
    add(byte >> 4U);
    add(byte & 0x0FU);
  }
  return crc;
}

}  // namespace flotilla::link
