// SPDX-License-Identifier: MIT
// Messages to MAVLink 2 bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "link/mavlink/messages.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::link {

/// One link's sender, which numbers its frames in sequence.
class MavlinkEncoder {
 public:
  MavlinkEncoder() = default;
  explicit MavlinkEncoder(Address self) : self_(self) {}

  /// Writes one frame, signed as `link_id` if `signing` is given. Returns its length, or 0 (and
  /// uses no sequence number) if `out` is too short or the message is std::monostate.
  std::size_t encode(const Message& message, std::span<std::uint8_t> out,
                     Signing* signing = nullptr, std::uint8_t link_id = 0);

  /// Changes the ids of later frames.
  void rename(Address self) { self_ = self; }

  /// The sequence number of the last frame.
  std::uint8_t last_sequence() const { return static_cast<std::uint8_t>(sequence_ - 1U); }

 private:
  Address self_{};
  std::uint8_t sequence_ = 0;
};

}  // namespace flotilla::link
