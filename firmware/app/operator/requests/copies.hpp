// SPDX-License-Identifier: MIT
// Recognises requests that arrive a second time, on another link. If several vessels hear a ground
// station, they forward its messages, and a late copy could undo a newer request.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// Accepts a sender's stream (sticks, setpoints) on one link, and on another link only after 5 s of
/// silence: otherwise late copies would alternate with newer messages, and these are too frequent
/// to note each one. Remembers the last two senders: one operator often takes over from another.
class StreamLink {
 public:
  [[gnu::noinline]] bool takes(link::Address from, std::size_t link, std::int64_t now_us) {
    constexpr std::uint32_t kSilent_ms = 5000;
    const auto ms = static_cast<std::uint32_t>(now_us / 1000);
    if (from != senders_[0].from) std::swap(senders_[0], senders_[1]);
    Sender& last = senders_[0];
    if (from == last.from && link != last.link && ms - last.ms < kSilent_ms) return false;
    last = {ms, from, static_cast<std::uint8_t>(link)};
    return true;
  }

 private:
  struct Sender {
    std::uint32_t ms = 0;
    link::Address from{};
    std::uint8_t link = 0;
  };
  std::array<Sender, 2> senders_{};
};

class Copies {
 public:
  enum class Verdict : std::uint8_t {
    kNew,
    kCopy,     ///< the same one, with the same checksum, came on another link in the last 5 s
    kPerhaps,  ///< too many came in that time to remember each; this one is on an unusual link
  };

  /// Judges the message, and notes it if it is new.
  Verdict judge(const link::Received& received, std::span<const std::uint8_t> frame,
                std::size_t link, std::int64_t now_us) {
    constexpr std::uint32_t kLate_ms = 5000;
    const Seen now{
        static_cast<std::uint32_t>(now_us / 1000), received.id,    received.from, received.sequence,
        static_cast<std::uint8_t>(link),           checksum(frame)};
    const auto recent = [&](const Seen& then) {
      return then.from != link::Address{} && now.ms - then.ms < kLate_ms;
    };
    for (const Seen& then : seen_) {
      if (then.link != now.link && then.sequence == now.sequence && then.id == now.id &&
          then.from == now.from && then.checksum == now.checksum && recent(then)) {
        return Verdict::kCopy;
      }
    }
    const bool usual = usual_.takes(received.from, link, now_us);
    if (recent(seen_[next_]) && !usual) return Verdict::kPerhaps;
    seen_[next_] = now;
    next_ = (next_ + 1) % seen_.size();
    return Verdict::kNew;
  }

 private:
  struct Seen {
    std::uint32_t ms = 0, id = 0;
    link::Address from{};  // 0, 0: a free entry
    std::uint8_t sequence = 0, link = 0;
    std::uint16_t checksum = 0;
  };

  /// The checksum after the payload, before a signature. A sender may number the messages of each
  /// link separately, so the sequence number alone does not identify a copy.
  static std::uint16_t checksum(std::span<const std::uint8_t> frame) {
    constexpr std::uint8_t kMavlink2 = 0xFD;
    const std::size_t at = (frame[0] == kMavlink2 ? 10U : 6U) + frame[1];
    return static_cast<std::uint16_t>(frame[at] | frame[at + 1] << 8);
  }

  std::array<Seen, 30> seen_{};
  std::size_t next_ = 0;
  StreamLink usual_;
};

}  // namespace flotilla::app
