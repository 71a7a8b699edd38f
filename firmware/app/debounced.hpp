// SPDX-License-Identifier: MIT
// Debounces a boolean sampled every tick.
#pragma once

#include <cstdint>
#include <optional>

namespace flotilla::app {

/// Takes a new value once it has lasted 2 s; initially false.
class Debounced {
 public:
  void update(bool now, std::int64_t now_us) {
    if (now == value_) {
      differs_since_us_.reset();
    } else if (!differs_since_us_) {
      differs_since_us_ = now_us;
    } else if (now_us - *differs_since_us_ >= kWait_us) {
      value_ = now;
      differs_since_us_.reset();
    }
  }
  bool value() const { return value_; }

 private:
  static constexpr std::int64_t kWait_us = 2'000'000;
  bool value_ = false;
  std::optional<std::int64_t> differs_since_us_;
};

}  // namespace flotilla::app
