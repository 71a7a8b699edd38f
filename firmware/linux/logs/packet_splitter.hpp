// SPDX-License-Identifier: MIT
// Splits MAVLink bytes in any chunks into packets, known or unknown, unchecked: for the log only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "link/mavlink/frame.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::target {

/// Whether a SETUP_SIGNING begins anywhere in these bytes, also inside a packet: noise may look
/// like the start of a packet that contains it.
inline bool holds_key(std::span<const std::uint8_t> bytes) {
  for (; !bytes.empty(); bytes = bytes.subspan(1)) {
    const auto header = link::read_header(bytes);
    if (header && header->id == link::mav::kSetupSigningId) return true;
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
      const auto header = link::read_header(rest);
      const bool begins = link::is_start(rest[0]) && (!header || header->is_known());
      if (begins && (!header || rest.size() < header->frame_bytes())) break;
      if (begins) each(rest.first(header->frame_bytes()));
      rest = rest.subspan(begins ? header->frame_bytes() : 1);
    }
    pending_.erase(pending_.begin(), pending_.end() - static_cast<std::ptrdiff_t>(rest.size()));
  }

 private:
  std::vector<std::uint8_t> pending_;
};

}  // namespace flotilla::target
