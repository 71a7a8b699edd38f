// SPDX-License-Identifier: MIT
// Offset of another vessel's clock from ours, from stamps and TIMESYNC answers alone.
//
// offset = our time − their time. A message cannot arrive before it was stamped, so arrival − stamp
// ≥ offset; a request cannot be read before it was sent, so sent − read ≤ offset. The bounds widen
// as the clocks may drift; their middle is exact if both directions have the same latency. An answer
// that contradicts the stamps leaves the offset without a lower bound, as if there had been none.
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

  /// The least possible offset; it gives the greatest possible age.
  std::optional<std::int64_t> least_us() const { return lower_ ? lower_ : upper_; }

  /// TIMESYNC bounds the offset from below.
  bool was_answered() const { return lower_.has_value(); }

  /// The last answer contradicts the stamps, or took too long to be useful.
  bool disputed() const { return disputed_; }

  void reset() { *this = ClockOffset{}; }

 private:
  void widen(std::int64_t now_us);

  std::int64_t widened_us_ = 0;
  std::optional<std::int64_t> upper_;
  std::optional<std::int64_t> lower_;
  bool disputed_ = false;
  bool begins_anew_ = false;  ///< with the next stamp: their clock was set
};

}  // namespace flotilla::app
