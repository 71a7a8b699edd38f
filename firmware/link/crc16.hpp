// SPDX-License-Identifier: MIT
// CRC-16-CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, most significant bit first.
#pragma once

#include <cstdint>
#include <span>

namespace flotilla::link {

constexpr std::uint16_t kCrc16Start = 0xFFFF;

/// The CRC of what `crc` covers and the bytes after it.
constexpr std::uint16_t crc16(std::uint16_t crc, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ (unsigned{byte} << 8U));
    for (int bit = 0; bit < 8; ++bit) {
      const unsigned polynomial = (crc & 0x8000U) != 0 ? 0x1021U : 0U;
      crc = static_cast<std::uint16_t>((unsigned{crc} << 1U) ^ polynomial);
    }
  }
  return crc;
}

}  // namespace flotilla::link
