// SPDX-License-Identifier: MIT
// How far another vessel's clock is from ours, from stamps and TIMESYNC answers alone.
//
// offset = our time − their time. A message of theirs cannot arrive before it was stamped, so
// arrival − stamp ≥ offset; a request of ours cannot be read before it was sent, so
// sent − read ≤ offset. The truth lies between the two bounds, which widen with time as clocks may
// drift; their middle is exact where the way there is as quick as the way back.
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

  /// The same, at the least: what is stamped so may be that old.
  std::optional<std::int64_t> least_us() const { return lower_ ? lower_ : upper_; }

  /// TIMESYNC bounds it from below.
  bool was_answered() const { return lower_.has_value(); }

  void reset() { *this = ClockOffset{}; }

 private:
  void widen(std::int64_t now_us);

  std::int64_t widened_us_ = 0;
  std::optional<std::int64_t> upper_;
  std::optional<std::int64_t> lower_;
};

}  // namespace flotilla::app
