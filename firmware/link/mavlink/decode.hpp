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

/// One link's receiver. Takes bytes in any chunks and finds its way back after any damage: a frame
/// that turns out false costs its first byte only, so it takes no good one down with it (the
/// generated parser swallows what follows a stray start byte); but for one that looks like a whole
/// message which our dialect lacks: that cannot be checked.
///
///   while (!bytes.empty()) {
///     bytes = bytes.subspan(decoder.fill(bytes));
///     while (auto received = decoder.next(counters)) …
///   }
class MavlinkDecoder {
 public:
  /// Takes as many bytes as there is room for, at least one after next() has returned nothing.
  std::size_t fill(std::span<const std::uint8_t> bytes);

  /// The next whole message with a good checksum, and, with `signing`, no bad signature. Without,
  /// signatures are not looked at, and no message counts as signed.
  std::optional<Received> next(Counters& counters, Signing* signing = nullptr);

  /// The same into `out`, which is as large as the largest message; false where there is none.
  bool next(Received& out, Counters& counters, Signing* signing = nullptr);

  /// The bytes of the message that next() returned last, to be passed on unchanged; empty where it
  /// returned nothing. Valid until the next call of next() or fill().
  std::span<const std::uint8_t> frame() const {
    return std::span(buffer_).subspan(begin_ - frame_size_, frame_size_);
  }

  /// Bytes are kept that may be the beginning of a message.
  bool waits() const { return begin_ < end_; }

  /// How many whole messages there have been, those included that were not returned.
  std::uint32_t whole() const { return whole_; }

  /// What is waited for will not come: the next call of next() looks behind that beginning.
  void give_up(Counters& counters);

 private:
  static constexpr std::size_t kLongestFrame = 10 + 255 + 2 + 13;
  std::array<std::uint8_t, 2 * kLongestFrame> buffer_{};
  std::uint32_t whole_ = 0;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t frame_size_ = 0;  ///< of the message that ends at begin_
};

}  // namespace flotilla::link
