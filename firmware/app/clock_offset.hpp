// SPDX-License-Identifier: MIT
// How far another vessel's clock is from ours, from stamps and TIMESYNC answers alone.
//
// offset = our time − their time. A message of theirs cannot arrive before it was stamped, so
// arrival − stamp ≥ offset; a request of ours cannot be read before it was sent, so
// sent − read ≤ offset. The truth lies between the least upper and the greatest lower bound of the
// last seconds; their middle is exact where the way there is as quick as the way back. Bounds older
// than two windows are forgotten, which lets the estimate follow a drift.
#pragma once

#include <cstdint>
#include <optional>

namespace flotilla::app {

class ClockOffset {
 public:
  /// A message stamped by their clock has arrived.
  void heard(std::int64_t stamp_us, std::int64_t now_us);

  /// They answered our request sent at `sent_us` (our clock), read at `read_us` (theirs).
  void answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us);

  /// µs to add to their time to get ours; nothing before the first message.
  std::optional<std::int64_t> offset_us() const;

  void reset() { *this = ClockOffset{}; }

 private:
  static constexpr std::int64_t kWindow_us = 5'000'000;
  struct Bounds {
    std::optional<std::int64_t> upper;
    std::optional<std::int64_t> lower;
  };

  Bounds& window(std::int64_t now_us);

  std::int64_t window_began_us_ = 0;
  Bounds now_{};
  Bounds before_{};
};

}  // namespace flotilla::app
