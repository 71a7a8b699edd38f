// SPDX-License-Identifier: MIT
// The boat's clock, derived from its host's, which may be set back. The boat's clock never goes
// back. If the host's clock stays behind for 1 s, the boat's continues with it from there.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "link/counters.hpp"

namespace flotilla::app {

class MonotonicClock {
 public:
  /// 285 years: fits 64 bits even in ns, and lies beyond any real clock.
  static constexpr std::int64_t kLatest_us = 9'000'000'000'000'000;

  std::int64_t now_us() const { return now_us_; }

  /// Takes the host's time; returns the boat's.
  std::int64_t take(std::int64_t now, link::Counters& counters) {
    const std::int64_t now_us = std::clamp<std::int64_t>(now, 0, kLatest_us) + shift_us_;
    if (now_us >= now_us_) {
      behind_since_us_.reset();
      now_us_ = std::min(now_us, kLatest_us);
      return now_us_;
    }
    ++counters.clock_went_back;
    if (!behind_since_us_) behind_since_us_ = now_us;
    if (now_us - *behind_since_us_ > kWait_us) shift_us_ += now_us_ - now_us;
    return now_us_;
  }

 private:
  static constexpr std::int64_t kWait_us = 1'000'000;

  std::int64_t now_us_ = 0;
  std::int64_t shift_us_ = 0;
  std::optional<std::int64_t> behind_since_us_;
};

}  // namespace flotilla::app
