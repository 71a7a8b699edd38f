// SPDX-License-Identifier: MIT
// A vessel's own clock, and schedules of periodic messages by it.
#pragma once

#include <cmath>
#include <cstdint>

namespace flotilla::fleet {

/// Runs `offset_us` ahead of the world's time, with a drift of `drift_ppm`.
struct Clock {
  std::int64_t offset_us = 0;
  double drift_ppm = 0;

  /// Its reading at the world's time, µs; the drift is rounded to whole µs, halves to even.
  std::int64_t at(std::int64_t t_us) const {
    if (drift_ppm == 0) return t_us + offset_us;
    const double gained = std::nearbyint(static_cast<double>(t_us) * drift_ppm * 1e-6);
    return t_us + offset_us + static_cast<std::int64_t>(gained);
  }
};

/// Schedule of a message that is due `hz` times a second from the first call on. A late call counts
/// once and keeps the schedule; a call two periods late, or more than one early, restarts it.
class Rate {
 public:
  explicit Rate(double hz)
      : hz_(hz), period_us_(static_cast<std::int64_t>(std::nearbyint(1e6 / hz))) {}

  bool due(std::int64_t now_us) {
    const std::int64_t late_us = now_us - next_us_;
    if (-period_us_ <= late_us && late_us < 0) return false;
    if (late_us < 0 || late_us >= 2 * period_us_) {
      anchor_us_ = now_us;
      count_ = 0;
    }
    ++count_;
    next_us_ = anchor_us_ + static_cast<std::int64_t>(static_cast<double>(count_) * 1e6 / hz_);
    return true;
  }

 private:
  double hz_;
  std::int64_t period_us_;
  std::int64_t anchor_us_ = 0;
  std::int64_t count_ = 0;
  std::int64_t next_us_ = -(std::int64_t{1} << 62);
};

}  // namespace flotilla::fleet
