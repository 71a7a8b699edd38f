// SPDX-License-Identifier: MIT
// CRC-32, reflected polynomial 0xEDB88320. Initial and final values differ: MAVLink starts with 0
// and uses the result unchanged; IEEE 802.3 (zlib, files) starts with ~0 and inverts the result.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace flotilla::link {

/// Indexed by half bytes: files and plans are short, and a table for whole bytes takes a kilobyte.
inline constexpr std::array<std::uint32_t, 16> kCrc32Table = [] {
  std::array<std::uint32_t, 16> table{};
  for (std::uint32_t half = 0; half < table.size(); ++half) {
    std::uint32_t crc = half;
    for (int bit = 0; bit < 4; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    table[half] = crc;
  }
  return table;
}();

constexpr std::uint32_t kMavlinkCrc32Start = 0;

/// Continues `crc` over further bytes.
constexpr std::uint32_t crc32(std::uint32_t crc, std::string_view bytes) {
  for (const char c : bytes) {
    crc ^= static_cast<std::uint8_t>(c);
    crc = (crc >> 4U) ^ kCrc32Table[crc & 0xFU];
    crc = (crc >> 4U) ^ kCrc32Table[crc & 0xFU];
  }
  return crc;
}

/// As zlib computes it.
constexpr std::uint32_t ieee_crc32(std::string_view bytes) { return ~crc32(0xFFFFFFFFU, bytes); }

}  // namespace flotilla::link
