// SPDX-License-Identifier: MIT
// Chooses which of the messages that report one vessel's state are used.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "app/navigation/clock_offset.hpp"

namespace flotilla::app {

/// The most precise first.
enum class Source : std::uint8_t { kOdometry, kLocalPosition, kFollowTarget, kGlobalPosition };

/// The most precise source that is received wins; a local one without a known origin ranks last.
/// The one in use is replaced after `patience_us` of silence, or by a better one received five
/// times in a row. Each has its own clock: the stamps of two need not count from the same instant.
class StateSources {
 public:
  explicit StateSources(std::int64_t patience_us) : patience_us_(patience_us) {}

  Source in_use() const { return in_use_; }
  ClockOffset& clock() { return heard(in_use_).clock; }
  const ClockOffset& clock() const { return heard(in_use_).clock; }

  /// A message was received; `accepted`: the source in use has given a state, which sets its clock.
  void hear(Source source, std::int64_t stamp_us, std::int64_t now_us, bool accepted);

  /// Whether `source` should replace the one in use.
  bool better(Source source, std::int64_t now_us, bool origin_known) const;

  /// Changes the source. Returns whether its stamps went back since it was last in use: then the
  /// vessel rebooted, and its local frame may have another origin.
  bool change_to(Source source);

  /// Resets the clock of the source in use.
  void restart() { clock().reset(); }
  void rebooted(std::int64_t stamp_us);

  /// The vessel answered a TIMESYNC request that we sent at `sent_us`.
  void answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us);

  /// The stamp is later than this source's last one.
  bool is_news(Source source, std::int64_t stamp_us) const {
    const Heard& in = heard(source);
    return in.in_a_row == 0 || stamp_us > in.stamp_us;
  }

  /// Another component is used from now on.
  void forget() { heard_ = {}; }

 private:
  static constexpr std::size_t kSources = 4;

  struct Heard {
    std::int64_t arrived_us = 0, stamp_us = 0;
    std::int64_t newest_us = 0;  ///< the latest stamp
    bool went_back = false;      ///< the last one was earlier
    int in_a_row = 0;            ///< messages without a gap; 0: none yet
    ClockOffset clock;
  };

  bool comes(Source source, std::int64_t now_us) const;
  Heard& heard(Source source) { return heard_[static_cast<std::size_t>(source)]; }
  const Heard& heard(Source source) const { return heard_[static_cast<std::size_t>(source)]; }

  std::int64_t patience_us_;
  Source in_use_ = Source::kGlobalPosition;
  std::array<Heard, kSources> heard_{};
};

}  // namespace flotilla::app
