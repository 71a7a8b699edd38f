// SPDX-License-Identifier: MIT
// Profiles a tick by stage.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>

namespace flotilla::fleet {

enum class Stage : std::size_t { kUnits, kDecode, kTick, kCan, kLinks };
constexpr std::size_t kStages = 5;
using Seconds = std::array<double, kStages>;

/// Adds the time since the last lap to a stage; reads no clock if off.
template <bool kOn>
class Stopwatch {
 public:
  explicit Stopwatch(Seconds& stages) : stages_(stages) {
    if constexpr (kOn) last_ = Clock::now();
  }

  void lap(Stage stage) {
    if constexpr (kOn) {
      const auto now = Clock::now();
      stages_[static_cast<std::size_t>(stage)] +=
          std::chrono::duration<double>(now - last_).count();
      last_ = now;
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  Seconds& stages_;
  Clock::time_point last_{};
};

}  // namespace flotilla::fleet
