// SPDX-License-Identifier: MIT
#include "app/navigation/clock_offset.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace flotilla::app {
namespace {

// Two ordinary crystals differ by less.
constexpr std::int64_t kDrift_ppm = 100;
// No useful answer takes longer. A wider interval shows that TIMESYNC and stamps use different
// clocks.
constexpr std::int64_t kWidest_us = 40'000'000;
// Tolerance: senders round their stamps, some take them while they send, and a busy computer stamps
// received data too early.
constexpr std::int64_t kRounded_us = 100'000;

}  // namespace

void ClockOffset::widen(std::int64_t now_us) {
  // Whole microseconds only; the remainder waits for the next call.
  constexpr std::uint32_t kPerMicrosecond_us = 1'000'000 / kDrift_ppm;
  const std::int64_t since_us = now_us - widened_us_;
  if (since_us < kPerMicrosecond_us) return;
  // 32 bits suffice for an hour; a 64-bit division is a long function on a small processor.
  const bool is_short = since_us <= std::numeric_limits<std::uint32_t>::max();
  const std::int64_t by_us = is_short ? static_cast<std::uint32_t>(since_us) / kPerMicrosecond_us
                                      : since_us / kPerMicrosecond_us;
  widened_us_ = now_us;
  if (upper_) *upper_ += by_us;
  if (lower_) *lower_ -= by_us;
}

void ClockOffset::heard(std::int64_t stamp_us, std::int64_t now_us) {
  widen(now_us);
  const std::int64_t upper = now_us - stamp_us;
  upper_ = upper_ && !std::exchange(begins_anew_, false) ? std::min(*upper_, upper) : upper;
  // The sender's clock was set. The newer bound is right.
  if (lower_ && *lower_ > *upper_ + kRounded_us) lower_.reset();
  if (lower_) lower_ = std::min(*lower_, *upper_);
}

void ClockOffset::answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us) {
  widen(now_us);
  const std::int64_t lower = sent_us - read_us;
  if (!upper_) return;
  const bool contradicts = lower > *upper_ + kRounded_us;
  disputed_ = contradicts || *upper_ - lower > kWidest_us;
  if (disputed_) {
    begins_anew_ = contradicts;
    lower_.reset();
    return;
  }
  lower_ = std::min(lower_ ? std::max(*lower_, lower) : lower, *upper_);
}

std::optional<std::int64_t> ClockOffset::offset_us() const {
  if (!upper_ || !lower_) return upper_;
  return *lower_ + (*upper_ - *lower_) / 2;
}

}  // namespace flotilla::app
