// SPDX-License-Identifier: MIT
// The time of day as the navigation unit reports it, for hosts without a clock of their own.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace flotilla::app {

class LearntTime {
 public:
  /// Takes a report. zero_us: Unix time at which the boat's clock was 0, according to that report.
  void hear(std::int64_t zero_us, std::int64_t now_us) {
    constexpr std::int64_t kClose_us = 500'000, kApart_us = 900'000;
    // Reports count only 0.9 s apart: those of a stopped clock then disagree, and copies of one
    // report do not count as several.
    if (agreeing_ > 0 && now_us - at_us_ < kApart_us) return;
    const std::int64_t apart_us = zero_us - heard_us_;
    const bool agrees = -kClose_us < apart_us && apart_us < kClose_us;
    agreeing_ = agrees ? std::min(agreeing_ + 1, kEnough) : 1;
    at_us_ = now_us;
    heard_us_ = zero_us;
    if (agreeing_ < kEnough) return;
    zero_us_ = zero_us;
    is_known_ = true;
  }

  /// The Unix time at which the boat's clock was 0, by the last report that agreed with the two
  /// before.
  std::optional<std::int64_t> zero_us() const {
    return is_known_ ? std::optional(zero_us_) : std::nullopt;
  }

 private:
  static constexpr int kEnough = 3;

  std::int64_t at_us_ = 0, heard_us_ = 0, zero_us_ = 0;
  int agreeing_ = 0;
  bool is_known_ = false;
};

}  // namespace flotilla::app
