// SPDX-License-Identifier: MIT
// Splits MAVLink bytes in any chunks into packets, known or unknown, unchecked: for the log only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "link/mavlink/mav.hpp"

namespace flotilla::target {

constexpr std::uint8_t kStart1 = 0xFE, kStart2 = 0xFD;

/// Whether a SETUP_SIGNING begins anywhere in these bytes: noise that resembles the start of a
/// packet may have swallowed it.
inline bool holds_key(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kHeader = 10;
  for (; bytes.size() >= kHeader; bytes = bytes.subspan(1)) {
    const std::uint32_t id =
        bytes[7] | std::uint32_t{bytes[8]} << 8U | std::uint32_t{bytes[9]} << 16U;
    if (bytes[0] == kStart2 && id == link::mav::kSetupSigningId) return true;
  }
  return false;
}

class PacketSplitter {
 public:
  /// Calls `each` with every complete packet (version 1 or 2, signed or not). Skips bytes that
  /// cannot begin one.
  template <class Each>
  void split(std::span<const std::uint8_t> bytes, Each each) {
    pending_.insert(pending_.end(), bytes.begin(), bytes.end());
    std::span<const std::uint8_t> rest = pending_;
    while (!rest.empty()) {
      const std::size_t size = packet_size(rest);
      if (size > rest.size()) break;
      if (size > 0) each(rest.first(size));
      rest = rest.subspan(size > 0 ? size : 1);
    }
    pending_.erase(pending_.begin(), pending_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  }

 private:
  static constexpr std::uint8_t kSigned = 0x01;

  /// 0: no packet begins here. More than b.size(): not complete yet.
  static std::size_t packet_size(std::span<const std::uint8_t> b) {
    if (b[0] != kStart1 && b[0] != kStart2) return 0;
    if (b.size() < 3) return 3;
    if (b[0] == kStart1) return 6U + b[1] + 2U;
    if ((b[2] & ~kSigned) != 0) return 0;
    return 10U + b[1] + 2U + ((b[2] & kSigned) != 0 ? 13U : 0U);
  }

  std::vector<std::uint8_t> pending_;
};

}  // namespace flotilla::target
