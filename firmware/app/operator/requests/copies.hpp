// SPDX-License-Identifier: MIT
// Recognises requests that arrive a second time. If several vessels hear a ground station, they
// forward its messages, and a late copy could undo a newer request.
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
  /// Whether the message is to be used; if so, its link becomes the sender's.
  [[gnu::noinline]] [[nodiscard]] bool accept(link::Address from, std::size_t link,
                                              std::int64_t now_us) {
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
    kCopy,       ///< the same one, with the same checksum, came on another link in the last 5 s
    kOvertaken,  ///< the same one came on this link in the last 5 s, and a newer request since; or
                 ///< its sender has started again, and sends what it sent before
    kPerhaps,    ///< too many came in that time to remember each; this one is on an unusual link
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
      if (!same(then, now) || !recent(then)) continue;
      if (then.link != now.link) return Verdict::kCopy;
      const bool judged = FLOTILLA_KEEPS_FLEET != 0 && !received.is_signed;  // signed: never twice
      if (judged && is_overtaken(then, now.ms)) return Verdict::kOvertaken;
    }
    const bool usual = usual_.accept(received.from, link, now_us);
    if (recent(seen_[next_]) && !usual) return Verdict::kPerhaps;
    seen_[next_] = now;
    next_ = (next_ + 1) % seen_.size();
    return Verdict::kNew;
  }

  /// Notes a request that stops the boat.
  void note_stop(std::int64_t now_us) {
    stop_ms_ = static_cast<std::uint32_t>(now_us / 1000);
    stopped_ = true;
  }

 private:
  struct Seen {
    std::uint32_t ms = 0, id = 0;
    link::Address from{};  // 0, 0: a free entry
    std::uint8_t sequence = 0, link = 0;
    std::uint16_t checksum = 0;
  };

  static bool same(const Seen& a, const Seen& b) {
    return a.sequence == b.sequence && a.id == b.id && a.from == b.from && a.checksum == b.checksum;
  }

  /// Whether a stop, or another request of its sender, came later.
  bool is_overtaken(const Seen& then, std::uint32_t now_ms) const {
    const auto later = [&](std::uint32_t ms) { return now_ms - ms < now_ms - then.ms; };
    return (stopped_ && later(stop_ms_)) || std::ranges::any_of(seen_, [&](const Seen& other) {
             return other.from == then.from && !same(other, then) && later(other.ms);
           });
  }

  /// The checksum after the payload, before a signature. A sender may number the messages of each
  /// link separately, so the sequence number alone does not identify a copy.
  static std::uint16_t checksum(std::span<const std::uint8_t> frame) {
    constexpr std::uint8_t kMavlink2 = 0xFD;
    const std::size_t at = (frame[0] == kMavlink2 ? 10U : 6U) + frame[1];
    return static_cast<std::uint16_t>(frame[at] | frame[at + 1] << 8);
  }

  std::array<Seen, 30> seen_{};
  std::uint32_t stop_ms_ = 0;
  bool stopped_ = false;
  std::size_t next_ = 0;
  StreamLink usual_;
};

}  // namespace flotilla::app
