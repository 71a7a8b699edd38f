// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "link/mavlink/crc.hpp"

namespace flotilla::link {
namespace {

/// The checksum bit by bit, as the protocol defines it.
std::uint16_t plain_crc(const std::vector<std::uint8_t>& bytes) {
  unsigned crc = 0xFFFF;
  for (const unsigned byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0x8408U : 0U);
  }
  return static_cast<std::uint16_t>(crc);
}

TEST_CASE("a checksum by tables is that of the polynomial, for frames of any length") {
  constexpr std::uint32_t kSeed = 3;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (std::size_t size = 0; size < 300; ++size) {
    std::vector<std::uint8_t> bytes(size);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    const auto extra = static_cast<std::uint8_t>(random());
    const std::uint16_t crc = mavlink_crc(bytes, extra);
    bytes.push_back(extra);
    REQUIRE(crc == plain_crc(bytes));
  }
  // CRC-16/MCRF4XX, catalogue of parametrised CRC algorithms
  const std::vector<std::uint8_t> check{'1', '2', '3', '4', '5', '6', '7', '8'};
  CHECK(mavlink_crc(check, '9') == 0x6F91);
}

}  // namespace
}  // namespace flotilla::link
