// SPDX-License-Identifier: MIT
// MAVLink 2 message signing, one for all links of a component.
//
// signature = first 48 bits of SHA-256(key ‖ frame ‖ link id ‖ timestamp). A timestamp counts 10 µs
// since 2015-01-01 in 48 bits. Source: mavlink.io, "Message Signing". Not in it: timestamps are
// judged by our clock alone, a minute either way. There a received timestamp drags the receiver's
// along, and one from the future shuts out everybody whose clock is right.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/mavlink/messages.hpp"

namespace flotilla::link {

using SigningKey = std::array<std::uint8_t, 32>;

constexpr std::size_t kSignatureBlockBytes = 13;  ///< link id, timestamp, signature

/// The timestamp of a time in µs since 1970; the nearest there is.
std::uint64_t signing_time(std::int64_t unix_us);

enum class SignatureVerdict : std::uint8_t {
  kGood,
  kForged,    ///< another key, or a bit was changed
  kReplayed,  ///< not newer than what this stream has brought already
  kStale,     ///< a new stream, more than a minute behind our clock
  kFuture,    ///< more than a minute ahead of our clock
  kNoRoom,    ///< a new stream, and there is no room for another
};

class Signing {
 public:
  /// What one (system, component, link id) sends.
  struct Stream {
    Address from;
    std::uint8_t link_id;
    std::uint64_t timestamp;
  };

  /// room: for the streams it hears, outlives it; what it sends needs none.
  explicit Signing(std::span<Stream> room = {}) : room_(room) {}

  /// clock: as for set_clock(); stored: the last timestamp() of an earlier run, or 0. Forgets all
  /// streams.
  void start(const SigningKey& key, std::uint64_t clock, std::uint64_t stored);

  bool has_key() const { return has_key_; }

  /// The host's clock, by which received timestamps are judged; what we send never goes back.
  void set_clock(std::uint64_t now);

  /// Of what we sent last. To be stored for the next start, at least once a minute.
  std::uint64_t timestamp() const { return timestamp_; }

  /// Judges a whole signed frame of MAVLink 2. Only a good one leaves a trace in here.
  SignatureVerdict check(std::span<const std::uint8_t> frame);

  /// The block behind a frame that says it is signed and ends with its checksum. No two blocks have
  /// the same timestamp, whatever their links.
  void sign(std::span<const std::uint8_t> frame, std::uint8_t link_id,
            std::span<std::uint8_t, kSignatureBlockBytes> block);

 private:
  Stream* find(Address from, std::uint8_t link_id);

  SigningKey key_{};
  bool has_key_ = false;
  std::uint64_t clock_ = 0;      // the host's
  std::uint64_t timestamp_ = 0;  // of what was sent last
  std::uint64_t floor_ = 0;      // the clock has been there before
  std::size_t used_ = 0;
  std::span<Stream> room_;
};

}  // namespace flotilla::link
