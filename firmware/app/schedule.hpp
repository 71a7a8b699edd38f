// SPDX-License-Identifier: MIT
// Schedules sending at a fixed rate, from ticks at another rate.
#pragma once

#include <cstdint>
#include <limits>

namespace flotilla::app {

/// Due on a time grid that starts at the first call. After a gap it is due once, and the grid
/// restarts.
class Schedule {
 public:
  Schedule() = default;

  /// Interval 0: never. `early_us`: half a tick, so that jitter of the loop does not skip a turn.
  explicit Schedule(std::int64_t interval_us, std::int64_t early_us = 0)
      : interval_us_(interval_us), early_us_(early_us) {}

  /// Whether a turn is due; unlike take_if_due(), does not take it.
  bool is_due(std::int64_t now_us) const {
    return interval_us_ > 0 && now_us + early_us_ >= next_us_;
  }

  /// Like is_due(), but up to half an interval early: for news that should not wait.
  bool is_due_early(std::int64_t now_us) const { return is_due(now_us + interval_us_ / 2); }

  /// Time from which is_due() is true.
  std::int64_t from_us() const {
    if (interval_us_ <= 0) return std::numeric_limits<std::int64_t>::max();
    return next_us_ - early_us_;
  }

  bool take_if_due(std::int64_t now_us) {
    if (!is_due(now_us)) return false;
    take(now_us);
    return true;
  }

  /// Takes the turn, whether due or early.
  void take(std::int64_t now_us) {
    const bool on_grid = now_us - next_us_ < interval_us_;
    next_us_ = (on_grid ? next_us_ : now_us) + interval_us_;
  }

  /// Due at once; the grid restarts.
  void make_due() { next_us_ = kAtOnce; }

  /// Sets the interval from the next turn on.
  void stretch(std::int64_t interval_us) { interval_us_ = interval_us; }

 private:
  static constexpr std::int64_t kAtOnce = std::numeric_limits<std::int64_t>::min() / 2;

  std::int64_t interval_us_ = 0;
  std::int64_t early_us_ = 0;
  std::int64_t next_us_ = kAtOnce;
};

}  // namespace flotilla::app
