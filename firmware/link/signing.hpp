// SPDX-License-Identifier: MIT
// MAVLink 2 message signing, one for all links of a component.
//
// signature = first 48 bits of SHA-256(key ‖ frame ‖ link id ‖ timestamp). A timestamp counts 10 µs
// since 2015-01-01 in 48 bits. Source: mavlink.io, "Message Signing". Not in it: the limit on
// timestamps from the future, without which one of them drags ours along and shuts out everybody
// whose clock is right.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/messages.hpp"

namespace flotilla::link {

using SigningKey = std::array<std::uint8_t, 32>;

constexpr std::size_t kSignatureBlockBytes = 13;  ///< link id, timestamp, signature

/// The timestamp of a time in µs since 1970; the nearest there is.
std::uint64_t signing_time(std::int64_t unix_us);

enum class SignatureVerdict : std::uint8_t {
  kGood,
  kForged,    ///< another key, or a bit was changed
  kReplayed,  ///< not newer than what this stream has brought already
  kStale,     ///< a new stream, more than a minute behind our timestamp
  kFuture,    ///< more than a minute ahead of our clock
  kNoRoom,    ///< a new stream, and there are kStreams already
};

class Signing {
 public:
  /// A stream is what one (system, component, link id) sends.
  static constexpr std::size_t kStreams = 255;

  /// timestamp: the later one of clock and stored timestamp(). Forgets all streams.
  void start(const SigningKey& key, std::uint64_t timestamp);

  bool has_key() const { return has_key_; }

  /// The clock as a timestamp; one that goes back stands still.
  void advance(std::uint64_t now);

  /// To be stored for the next start, at least once a minute.
  std::uint64_t timestamp() const { return timestamp_; }

  /// Judges a whole signed frame of MAVLink 2. Only a good one leaves a trace in here.
  SignatureVerdict check(std::span<const std::uint8_t> frame);

  /// The block behind a frame that says it is signed and ends with its checksum. No two blocks have
  /// the same timestamp, whatever their links.
  void sign(std::span<const std::uint8_t> frame, std::uint8_t link_id,
            std::span<std::uint8_t, kSignatureBlockBytes> block);

 private:
  struct Stream {
    Address from;
    std::uint8_t link_id;
    std::uint64_t timestamp;
  };
  Stream* find(Address from, std::uint8_t link_id);

  SigningKey key_{};
  bool has_key_ = false;
  std::uint64_t clock_ = 0;  // the host's alone: no message moves the limit on the future
  std::uint64_t timestamp_ =
      0;  // the latest of the clock, of what was accepted and of what was sent
  std::array<Stream, kStreams> streams_{};
  std::size_t stream_count_ = 0;
};

}  // namespace flotilla::link
