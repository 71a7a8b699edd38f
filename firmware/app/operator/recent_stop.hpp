// SPDX-License-Identifier: MIT
// The last stop, and the requests to drive that it still bars.
#pragma once

#include <cstdint>
#include <limits>

#include "app/operator/inbox.hpp"

namespace flotilla::app {

/// A command to disarm wins over a request that comes after it in the same tick: whoever sent the
/// request had not yet seen the boat disarmed. And a late retransmission must not undo a newer stop.
/// So for 5 s after a stop, a request to drive is refused on links that did not carry the stop (or
/// the stops of two operators), and a repeated one from another operator. The microcontroller's
/// image has no room for these 5 s.
class RecentStop {
 public:
  /// Records a stop by the pilot's switch. It counts as received on all links; within 5 s of an
  /// operator's stop, only on that stop's links. It has no sender.
  void note_pilots(std::int64_t now_us) {
    *this = RecentStop(now_us, {}, is_recent(now_us) ? links_ : std::uint8_t{0xFF}, false);
  }

  /// Judges a request that asks for a state, and records it if it is a stop. False if it must be
  /// refused. repeated: it is a retransmission.
  [[nodiscard]] bool admits(const PendingRequest& pending, core::Request request, bool repeated,
                            std::int64_t now_us) {
    const auto link = static_cast<std::uint8_t>(1U << pending.link);
    const bool others = pending.from != by_;
    const bool recent = is_recent(now_us);
    const bool after_disarm = disarms_ && pending.read_us <= us_;
    if (core::kind_of(request) == core::RequestKind::kStops) {
      const unsigned links = !recent ? link : others ? links_ & link : links_ | link;
      *this = RecentStop(now_us, pending.from, static_cast<std::uint8_t>(links),
                         after_disarm || request != core::Request::kHold);
      return true;
    }
    return !after_disarm && !(recent && ((links_ & link) == 0 || (others && repeated)));
  }

  RecentStop() = default;

 private:
  RecentStop(std::int64_t us, link::Address by, std::uint8_t links, bool disarms)
      : us_(us), by_(by), links_(links), disarms_(disarms) {}

  bool is_recent(std::int64_t now_us) const {
    return FLOTILLA_KEEPS_FLEET != 0 && now_us - us_ < 5'000'000;
  }

  std::int64_t us_ = std::numeric_limits<std::int64_t>::min() / 2;
  link::Address by_{};
  std::uint8_t links_ = 0;  // on which it came, a bit mask
  bool disarms_ = false;    // not only HOLD
};

}  // namespace flotilla::app
