// SPDX-License-Identifier: MIT
// Detects two vessels that use the same address, by the start times of their clocks.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <limits>
#include <utility>

namespace flotilla::app {

/// A vessel's clock has one start time until the vessel reboots, or until its stamps wrap after 49
/// days. The stamps of two vessels alternate between two start times. Start times less than 5 s
/// apart count as one, because the delay of one vessel's messages may vary by that much.
class Namesake {
 public:
  void hear(std::uint32_t time_boot_ms, std::int64_t now_us) {
    const std::int64_t began_us = now_us - std::int64_t{time_boot_ms} * 1000;
    if (!clock_.is(began_us)) {
      std::swap(clock_, other_);
      const bool returns = clock_.is(began_us) && now_us - clock_.heard_us < kSilent_us;
      returns_ = returns ? returns_ + 1 : 0;
      if (returns_ >= kSure) seen_us_ = now_us;
    }
    clock_ = {began_us, now_us};
  }

  /// Two vessels were detected within the last ten seconds.
  bool seen(std::int64_t now_us) const { return now_us - seen_us_ < kGone_us; }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::int64_t kSilent_us = 3'000'000, kGone_us = 10'000'000;
  static constexpr std::int64_t kApart_us = 5'000'000;
  static constexpr int kSure = 4;  ///< two late messages cause three returns

  struct Clock {
    std::int64_t began_us = 0;  ///< by our clock
    std::int64_t heard_us = kNever;
    bool is(std::int64_t at_us) const { return std::abs(at_us - began_us) < kApart_us; }
  };

  Clock clock_, other_;  ///< the one heard last, and the one before it
  int returns_ = 0;      ///< consecutive alternations between the two clocks
  std::int64_t seen_us_ = kNever;
};

}  // namespace flotilla::app
