// SPDX-License-Identifier: MIT
// The boat's ticks: the time between them, and whether its clock goes on.
#pragma once

#include <cstdint>
#include <optional>

namespace flotilla::app {

class Ticks {
 public:
  explicit Ticks(float rate_Hz) : rate_Hz_(rate_Hz) {}

  /// Limits the time for which the clock may stand still, counted in ticks at the nominal rate.
  void limit_idle(float most_s) { most_idle_ = static_cast<int>(most_s * rate_Hz_); }

  /// Call begin() at the beginning of a tick, and end() at its end.
  void begin(std::int64_t now_us) { idle_ = last_us_ == now_us ? idle_ + 1 : 0; }
  void end(std::int64_t now_us) { last_us_ = now_us; }

  /// The last tick that has ended, and the time since then; 0 before the first one.
  std::optional<std::int64_t> last_us() const { return last_us_; }
  std::int64_t since_us(std::int64_t now_us) const { return last_us_ ? now_us - *last_us_ : 0; }

  bool clock_stands() const { return idle_ > most_idle_; }

 private:
  float rate_Hz_;
  int most_idle_ = 0;
  int idle_ = 0;  // successive ticks without progress of time
  std::optional<std::int64_t> last_us_;
};

}  // namespace flotilla::app
