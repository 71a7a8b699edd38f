// SPDX-License-Identifier: MIT
// CRC-32, reflected polynomial 0xEDB88320. Initial and final values differ: MAVLink starts with 0
// and uses the result unchanged; IEEE 802.3 (zlib, files) starts with ~0 and inverts the result.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace flotilla::link {

inline constexpr std::array<std::uint32_t, 256> kCrc32Table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < table.size(); ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    table[byte] = crc;
  }
  return table;
}();

constexpr std::uint32_t kMavlinkCrc32Start = 0;

/// Continues `crc` over further bytes.
constexpr std::uint32_t crc32(std::uint32_t crc, std::string_view bytes) {
  for (const char c : bytes) {
    crc = (crc >> 8U) ^ kCrc32Table[(crc ^ static_cast<std::uint8_t>(c)) & 0xFFU];
  }
  return crc;
}

/// As zlib computes it.
constexpr std::uint32_t ieee_crc32(std::string_view bytes) { return ~crc32(0xFFFFFFFFU, bytes); }

}  // namespace flotilla::link
