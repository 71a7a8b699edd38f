// SPDX-License-Identifier: MIT
// Chooses, for one component of a vessel, the kind of message whose states are used.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "app/navigation/clock_offset.hpp"

namespace flotilla::app {

/// The most precise first.
enum class Source : std::uint8_t { kOdometry, kLocalPosition, kFollowTarget, kGlobalPosition };

/// Of the component's sources it uses the most precise one received; a local source without a known
/// origin ranks last. The source in use is replaced after `patience_us` of silence, or by a better
/// one received five times in a row; a prompt source is better than a late one. Each source has its
/// own clock, because the stamps of two sources need not count from the same instant; but if they
/// differ by 0.3 s to 15 s, the source that seems late counts as late.
class StateSources {
 public:
  explicit StateSources(std::int64_t patience_us) : patience_us_(patience_us) {}

  std::uint8_t component() const { return component_; }  ///< 0: none yet
  Source in_use() const { return in_use_; }
  ClockOffset& clock() { return heard(in_use_).clock; }
  const ClockOffset& clock() const { return heard(in_use_).clock; }

  void change_to(std::uint8_t component);

  /// A message of the component in use was received; `accepted`: the source in use has given a
  /// state, which sets its clock.
  void hear(Source source, std::int64_t stamp_us, std::int64_t now_us, bool accepted);

  /// Whether `source` should replace the one in use.
  bool better(Source source, std::int64_t now_us, bool origin_known) const;

  /// The source's stamps went back since it was last in use: the vessel rebooted, and its local
  /// frame may have another origin.
  bool went_back(Source source) const { return heard(source).went_back; }
  void change_to(Source source);

  /// The estimator behind ODOMETRY was reset. Only an increment by one counts; another number may
  /// be another vessel's.
  bool is_reset(std::uint8_t resets, std::int64_t stamp_us) const;
  void note_resets(std::uint8_t resets) { odometry_resets_ = resets; }

  /// The vessel restarted; this stamp is the first after that.
  void reboot(std::int64_t stamp_us);

  /// The clock of the source in use was set.
  void reset_clock() {
    clock().reset();
    heard(in_use_).late = false;
    ++clock_resets_;
  }
  /// How often the clock of the source in use, or its component, has changed; wraps.
  std::uint8_t clock_resets() const { return clock_resets_; }

  /// The vessel answered a TIMESYNC request that we sent at `sent_us`.
  void answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us);

 private:
  static constexpr std::size_t kSources = 4;

  struct Heard {
    std::int64_t arrived_us = 0, stamp_us = 0;
    std::int64_t newest_us = 0;  ///< the latest stamp
    bool went_back = false;      ///< the last one was earlier
    bool late = false;           ///< shares the clock of a source that it is later than
    int in_a_row = 0;            ///< messages without a gap; 0: none yet
    ClockOffset clock;
  };

  bool comes(Source source, std::int64_t now_us) const;
  bool steady(Source source) const;
  bool is_behind(Source source, Source other) const;
  Heard& heard(Source source) { return heard_[static_cast<std::size_t>(source)]; }
  const Heard& heard(Source source) const { return heard_[static_cast<std::size_t>(source)]; }

  std::int64_t patience_us_;
  std::uint8_t component_ = 0;
  std::uint8_t clock_resets_ = 0;
  Source in_use_ = Source::kGlobalPosition;
  std::array<Heard, kSources> heard_{};
  std::optional<std::uint8_t> odometry_resets_;  ///< of the last state accepted
};

}  // namespace flotilla::app
