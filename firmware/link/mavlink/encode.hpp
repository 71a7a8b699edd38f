// SPDX-License-Identifier: MIT
// Messages to MAVLink 2 bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "link/mavlink/messages.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::link {

/// One link's sender: its frames carry one running sequence number.
class MavlinkEncoder {
 public:
  MavlinkEncoder() = default;
  explicit MavlinkEncoder(Address self) : self_(self) {}

  /// Writes one frame; its length, or 0 (and nothing written, no number used) where `out` is
  /// too short or the message is std::monostate. With `signing` it is signed, as from `link_id`.
  std::size_t encode(const Message& message, std::span<std::uint8_t> out,
                     Signing* signing = nullptr, std::uint8_t link_id = 0);

  /// Under other ids from now on.
  void rename(Address self) { self_ = self; }

  /// The sequence number of the frame written last.
  std::uint8_t last_sequence() const { return static_cast<std::uint8_t>(sequence_ - 1U); }

 private:
  Address self_{};
  std::uint8_t sequence_ = 0;
};

}  // namespace flotilla::link
