// SPDX-License-Identifier: MIT
// Constant text compressed by byte pair encoding (P. Gage, 1994), to save flash: a byte value that
// the text does not use stands for two others, which may themselves stand for pairs. Pages of equal
// length are packed separately, so that reading from the middle is quick.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "link/mavlink/crc32.hpp"

namespace flotilla::link {

class PackedText {
 public:
  static constexpr std::size_t kPage = 512;  ///< of the text, in bytes
  static constexpr std::size_t kDepth = 32;  ///< pairs within pairs, at most
  /// Entry b: the two bytes that b stands for; if the second is 0, b stands for itself.
  using Pairs = std::array<std::array<std::uint8_t, 2>, 256>;

  struct Packed {
    std::span<const std::uint8_t> bytes;
    std::span<const std::uint16_t> pages;  ///< where each page begins in `bytes`
    const Pairs* pairs;
    std::uint32_t size;  ///< of the text
    std::uint32_t crc;
  };

  constexpr explicit PackedText(const Packed& packed) : packed_(packed) {}

  /// Uncompressed text, which must outlive this.
  template <std::convertible_to<std::string_view> Text>
  constexpr PackedText(const Text& text)  // NOLINT(google-explicit-constructor)
      : plain_(text),
        packed_{.bytes = {},
                .pages = {},
                .pairs = nullptr,
                .size = static_cast<std::uint32_t>(plain_.size()),
                .crc = crc32(kMavlinkCrc32Start, plain_)} {}

  constexpr std::uint32_t size() const { return packed_.size; }
  constexpr std::uint32_t crc() const { return packed_.crc; }  ///< as MAVLink computes it

  /// Copies the text from `offset` on, as much as there is and fits; returns how much.
  std::size_t read(std::size_t offset, std::span<std::uint8_t> out) const;

 private:
  void unpack(std::size_t offset, std::span<std::uint8_t> out) const;

  std::string_view plain_;
  Packed packed_;
};

}  // namespace flotilla::link
