// SPDX-License-Identifier: MIT
// Which of the messages that tell one vessel's state are made use of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "app/navigation/clock_offset.hpp"

namespace flotilla::app {

/// The most precise first.
enum class Source : std::uint8_t { kOdometry, kLocalPosition, kFollowTarget, kGlobalPosition };

/// The most precise source that comes wins; a local one whose origin is unknown comes last. One that
/// is in use gives way when it was silent for `patience_us`; a better one must have come five times
/// in a row before it takes its place. Each has a clock of its own: stamps of two sources need not
/// count from the same instant.
class StateSources {
 public:
  explicit StateSources(std::int64_t patience_us) : patience_us_(patience_us) {}

  Source in_use() const { return in_use_; }
  ClockOffset& clock() { return heard(in_use_).clock; }
  const ClockOffset& clock() const { return heard(in_use_).clock; }

  /// A message has come; `accepted`: the source in use has given a state, which sets its clock.
  void hear(Source source, std::int64_t stamp_us, std::int64_t now_us, bool accepted);

  /// It shall take the place of the one in use.
  bool better(Source source, std::int64_t now_us, bool origin_known) const;

  /// Uses another one: whether its stamps went back since it was last in use. The vessel rebooted,
  /// and its local frame may have another origin.
  bool change_to(Source source);

  /// The vessel's clock, as the source in use has it, begins anew.
  void restart() { clock().reset(); }
  void rebooted(std::int64_t stamp_us);

  /// The vessel answered a TIMESYNC request that we sent at `sent_us`.
  void answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us);

  /// It is later than all that this source has said.
  bool is_news(Source source, std::int64_t stamp_us) const {
    const Heard& in = heard(source);
    return in.in_a_row == 0 || stamp_us > in.stamp_us;
  }

  /// Another component speaks from now on.
  void forget() { heard_ = {}; }

 private:
  static constexpr std::size_t kSources = 4;

  struct Heard {
    std::int64_t arrived_us = 0, stamp_us = 0;
    std::int64_t newest_us = 0;  ///< the latest stamp
    bool went_back = false;      ///< the last one was earlier
    int in_a_row = 0;            ///< messages without a gap; 0: there was none
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
