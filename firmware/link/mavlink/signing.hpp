// SPDX-License-Identifier: MIT
// MAVLink 2 message signing, one for all links of a component.
//
// signature = first 48 bits of SHA-256(key ‖ frame ‖ link id ‖ timestamp). A timestamp counts 10 µs
// since 2015-01-01 in 48 bits. Source: mavlink.io, "Message Signing". Unlike there, once our clock
// is known, it alone judges timestamps, with a tolerance of a minute either way. In the source, a
// received timestamp advances the receiver's own, so one from the future shuts out every sender
// with a correct clock; and a message of a known stream may have any age, so messages recorded
// from a jammed radio are obeyed hours later.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/mavlink/address.hpp"
#include "link/mavlink/frame.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::link {

using SigningKey = std::array<std::uint8_t, 32>;

/// The timestamp of a time in µs since 1970; saturates.
std::uint64_t signing_time(std::int64_t unix_us);

enum class SignatureVerdict : std::uint8_t {
  kGood,
  kForged,    ///< another key, or altered data
  kReplayed,  ///< not newer than this stream's latest timestamp
  kStale,     ///< over a minute old, and not of a sender that counts its messages (see drags());
              ///< or a stream's first message, not newer than the stored time
  kFuture,    ///< more than a minute ahead of our clock
  kNoRoom,    ///< a new stream, but no room for it
};

class Signing {
 public:
  /// The messages of one (system, component, link id).
  struct Stream {
    Address from;
    std::uint8_t link_id;
    std::uint32_t heard_s;        ///< our clock at that message; 0: none yet
    std::uint64_t timestamp;      ///< of the last timely message
    std::uint64_t exempt_before;  ///< of the last exempt message
  };

  /// Selects messages that are accepted at any age, once, if newer than the last of their stream.
  using Exemption = bool (*)(const Message&);

  /// room: storage for received streams, must outlive this object; sending needs none.
  explicit Signing(std::span<Stream> room = {}, Exemption exemption = nullptr)
      : room_(room), exemption_(exemption) {}

  /// Forgets all streams. clock: known, as for set_clock(). stored: an earlier run's timestamp(),
  /// or 0; the first message of each stream must be newer.
  void start(const SigningKey& key, std::uint64_t clock, std::uint64_t stored);

  bool has_key() const { return has_key_; }

  /// Sets our clock. A known clock judges received timestamps; with a guessed one, sent timestamps
  /// follow the newest received. Sent timestamps never go back.
  void set_clock(std::uint64_t now, bool known = true);
  bool knows_clock() const { return known_; }

  /// Our last sent timestamp. Store it every few seconds for the next start: messages received
  /// since then can be replayed after a restart.
  std::uint64_t timestamp() const { return timestamp_; }

  /// Verifies a whole signed MAVLink 2 frame. Only a good one changes the state.
  SignatureVerdict check(std::span<const std::uint8_t> frame);

  /// Accepts a frame although check() returned kStale or kFuture; true once for each such frame.
  bool take_exemption(std::span<const std::uint8_t> frame, const Message& message);

  /// Writes the signature block of a frame, which has its signed flag set and ends with its
  /// checksum. Timestamps are unique across all links.
  void sign(std::span<const std::uint8_t> frame, std::uint8_t link_id,
            std::span<std::uint8_t, kSignatureBlockBytes> block);

 private:
  Stream* find(Address from, std::uint8_t link_id);
  Stream* find_or_add(Address from, std::uint8_t link_id);
  bool may_be_old(std::uint64_t timestamp) const;
  bool drags(const Stream& stream, std::uint64_t timestamp) const;
  std::uint32_t clock_s() const;

  SigningKey key_{};
  bool has_key_ = false;
  bool known_ = false;
  std::uint64_t clock_ = 0;
  std::uint64_t timestamp_ = 0;  // last sent
  std::uint64_t stored_ = 0;     // of an earlier run
  std::size_t used_ = 0;
  std::span<Stream> room_;
  Exemption exemption_;
};

}  // namespace flotilla::link
