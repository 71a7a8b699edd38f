// SPDX-License-Identifier: MIT
// MAVLink 1 and 2 bytes to messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "link/counters.hpp"
#include "link/mavlink/messages.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::link {

/// One link's receiver. Takes bytes in any chunks and resynchronizes after any damage: a false
/// frame costs only its first byte, so no good frame is lost with it (the generated parser discards
/// the bytes after a stray start byte). Exception: a false frame that looks like a whole message
/// outside our dialect is skipped whole, because its checksum cannot be verified.
///
///   while (!bytes.empty()) {
///     bytes = bytes.subspan(decoder.fill(bytes));
///     while (auto received = decoder.next(counters)) …
///   }
class MavlinkDecoder {
 public:
  /// Takes the bytes that fit, at least one once next() has returned nothing; returns how many.
  std::size_t fill(std::span<const std::uint8_t> bytes);

  /// The next whole message with a good checksum and, with `signing`, no bad signature. Without
  /// `signing`, signatures are ignored, and no message counts as signed.
  [[nodiscard]] std::optional<Received> next(Counters& counters, Signing* signing = nullptr);

  /// The same into `out`, which has the size of the largest message; false if there is none.
  [[nodiscard]] bool next(Received& out, Counters& counters, Signing* signing = nullptr);

  /// The bytes of the message that next() returned last, for forwarding unchanged; empty if it
  /// returned nothing. Valid until the next call of next() or fill().
  std::span<const std::uint8_t> frame() const {
    return std::span(buffer_).subspan(begin_ - frame_size_, frame_size_);
  }

  /// Whether the buffer holds a possible beginning of a message.
  bool has_bytes() const { return begin_ < end_; }

  /// Number of whole messages, including those that were not returned.
  std::uint32_t whole() const { return whole_; }

  /// Drops the first byte of an incomplete message, so that next() searches the bytes after it.
  void give_up(Counters& counters);

 private:
  static constexpr std::size_t kLongestFrame = 10 + 255 + 2 + 13;
  std::array<std::uint8_t, 2 * kLongestFrame> buffer_{};
  std::uint32_t whole_ = 0;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t frame_size_ = 0;  ///< size of the message that ends at begin_
};

}  // namespace flotilla::link
