// SPDX-License-Identifier: MIT
// Offset of another vessel's clock from ours, from stamps and TIMESYNC answers alone.
//
// offset = our time − their time. A message cannot arrive before it was stamped, so arrival − stamp
// ≥ offset; a request cannot be read before it was sent, so sent − read ≤ offset. The bounds widen
// as the clocks may drift; their middle is exact if both directions have the same latency. An
// answer that contradicts the stamps discards the lower bound, as if no answer had ever come.
//
// When the upper bound falls, either a message had less latency than all before it, or their clock
// was set ahead or runs fast. So the lower bound falls by the same amount until an answer confirms
// it. The lower bound also falls when late messages become prompt again, by the drop in lateness,
// until the answer to a later request rules that out. An answer counts for at most the next 32
// answers, because their clock may have been set back and ahead again. After a minute without
// answers the distance between the bounds stops growing: the greatest possible latency of the
// promptest message remains known, and the stamps are judged like those of a sender that never
// answers.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

namespace flotilla::app {

/// Whether a sender whose stamps have gone back has restarted: it was started during the silence
/// before them, or its clock was set back by more than a minute. Otherwise the stamps are late.
constexpr bool is_restart(std::int64_t stamp_us, std::int64_t last_us, std::int64_t silent_us) {
  return stamp_us <= silent_us || last_us - stamp_us > 60'000'000;
}

class ClockOffset {
 public:
  /// A message stamped by their clock has arrived.
  void heard(std::int64_t stamp_us, std::int64_t now_us);

  /// They answered our request sent at `sent_us` (our clock), read at `read_us` (theirs).
  void answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us);

  /// µs to add to their time to get ours; nothing before the first message.
  std::optional<std::int64_t> offset_us() const { return below_upper(2); }

  /// The least possible offset; it gives the greatest possible age.
  std::optional<std::int64_t> least_us() const;

  /// TIMESYNC bounds the offset from below.
  bool was_answered() const { return nearness_ != 0; }

  /// TIMESYNC has bounded it within the last minute.
  bool is_answered() const { return was_answered() && drifted_us_ < kMinute_us; }

  /// The last answer contradicts the stamps, or took too long to be useful.
  bool disputed() const { return disputed_; }

  /// Even the promptest message by this clock came kLate_us to 15 s later than that by another
  /// clock of the same vessel, if both count from the same instant.
  static constexpr std::int64_t kLate_us = 300'000;
  bool is_later_than(const ClockOffset& other) const;

  /// Takes the other clock's bound: messages by this one are as late as their stamps show. Ignored
  /// if TIMESYNC bounds this clock.
  void share(const ClockOffset& other) {
    if (!was_answered()) upper_us_ = other.upper_us_;
  }

  void reset() { *this = ClockOffset{}; }

 private:
  static constexpr std::uint32_t kFarthest_us = std::numeric_limits<std::uint32_t>::max();
  static constexpr std::uint16_t kMinute_us = 6'000;  ///< possible drift in a minute
  static constexpr unsigned kShift = 10;

  static std::uint16_t units(std::int64_t us);
  void widen(std::int64_t now_us);
  std::optional<std::int64_t> below_upper(std::uint32_t share) const;

  static constexpr std::int64_t kUnknown = std::numeric_limits<std::int64_t>::max();

  bool is_heard() const { return upper_us_ != kUnknown; }

  std::int64_t widened_us_ = 0;
  std::int64_t upper_us_ = kUnknown;
  // How near the lower bound is to the upper one, kFarthest_us minus their distance; 0: unknown.
  std::uint32_t nearness_ = 0, next_ = 0;  ///< by the last 16 to 31 answers, by the last 0 to 15
  std::uint32_t fell_at_ = 0;              ///< our time, in units of 2^kShift µs
  // By how much messages came later than the promptest, in these units: the last one; the latest
  // since an answer; by how much that fell, as when their clock was set ahead.
  std::uint16_t late_ = 0, latest_ = 0, fell_ = 0;
  std::uint16_t drifted_us_ = 0;  ///< possible drift since the last answer, at most a minute's
  std::uint8_t answers_ = 0;
  bool disputed_ = false;
  bool begins_anew_ = false;  ///< with the next stamp: their clock was set
};

}  // namespace flotilla::app
