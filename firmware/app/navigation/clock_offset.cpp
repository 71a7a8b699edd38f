// SPDX-License-Identifier: MIT
#include "app/navigation/clock_offset.hpp"

#include <algorithm>
#include <utility>

namespace flotilla::app {
namespace {

// The clocks of two ordinary crystals drift apart by less.
constexpr std::int64_t kDrift_ppm = 100;
// No useful answer takes longer. A wider interval shows that TIMESYNC and stamps use different
// clocks.
constexpr std::int64_t kWidest_us = 40'000'000;
// Tolerance: senders round their stamps, some take them while they send, and a busy computer stamps
// received data too early.
constexpr std::int64_t kRounded_us = 100'000;

}  // namespace

std::uint16_t ClockOffset::units(std::int64_t us) {
  constexpr std::int64_t kMost = std::numeric_limits<std::uint16_t>::max();
  return static_cast<std::uint16_t>(std::min(us >> kShift, kMost));
}

void ClockOffset::widen(std::int64_t now_us) {
  // Whole microseconds only; the remainder waits for the next call.
  constexpr std::uint32_t kPerMicrosecond_us = 1'000'000 / kDrift_ppm;
  const std::int64_t since_us = now_us - widened_us_;
  if (since_us < kPerMicrosecond_us) return;
  // An hour at most: a 64-bit division is a long function on a small processor.
  const std::uint32_t by_us =
      static_cast<std::uint32_t>(std::min<std::int64_t>(since_us, kFarthest_us)) /
      kPerMicrosecond_us;
  widened_us_ = now_us;
  if (is_heard()) upper_us_ += by_us;
  const std::uint32_t more_us = std::min(by_us, std::uint32_t{kMinute_us} - drifted_us_);
  drifted_us_ = static_cast<std::uint16_t>(drifted_us_ + more_us);
  if (nearness_ != 0) nearness_ -= 2 * more_us;
  if (next_ != 0) next_ -= 2 * more_us;
}

void ClockOffset::heard(std::int64_t stamp_us, std::int64_t now_us) {
  widen(now_us);
  const std::int64_t upper = now_us - stamp_us;
  upper_us_ = std::exchange(begins_anew_, false) ? upper : std::min(upper_us_, upper);
  late_ = units(upper - upper_us_);
  latest_ = std::max(latest_, late_);
  const auto fell = static_cast<std::uint16_t>(latest_ - late_);
  if (fell <= std::max<unsigned>(fell_, kLate_us >> kShift)) return;
  fell_ = fell;
  fell_at_ = static_cast<std::uint32_t>(now_us >> kShift);
}

void ClockOffset::answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us) {
  constexpr unsigned kAnswers = 16;  // twice as many last half a minute
  widen(now_us);
  if (!is_answered()) nearness_ = next_ = 0;
  drifted_us_ = 0;
  if (!is_heard()) return;
  const std::int64_t width_us = upper_us_ - (sent_us - read_us);
  begins_anew_ = width_us < -kRounded_us;
  disputed_ = begins_anew_ || width_us > kWidest_us;
  if (disputed_) {
    nearness_ = next_ = 0;
    return;
  }
  const auto near = kFarthest_us - static_cast<std::uint32_t>(std::max<std::int64_t>(width_us, 0));
  const std::uint32_t since_fall = static_cast<std::uint32_t>(sent_us >> kShift) - fell_at_;
  if (fell_ == 0 || static_cast<std::int32_t>(since_fall) > 0) {
    // An answer that proves almost as much as the best one before ends the doubt.
    const std::uint32_t less_us = near < nearness_ ? nearness_ - near : 0;
    fell_ = less_us < kRounded_us ? std::uint16_t{0} : std::min(fell_, units(less_us));
    latest_ = late_;
  }
  next_ = std::max(next_, near);
  nearness_ = std::max(nearness_, next_);
  if (++answers_ % kAnswers == 0) nearness_ = std::exchange(next_, 0);
}

bool ClockOffset::is_later_than(const ClockOffset& other) const {
  if (!is_heard() || !other.is_heard()) return false;
  const std::int64_t later_us = upper_us_ - other.upper_us_;
  return kLate_us < later_us && later_us < 15'000'000;
}

std::optional<std::int64_t> ClockOffset::least_us() const {
  auto least = below_upper(1);
  if (least && was_answered()) *least -= std::int64_t{fell_} << kShift;
  return least;
}

/// The upper bound less the width between the bounds / share.
std::optional<std::int64_t> ClockOffset::below_upper(std::uint32_t share) const {
  if (!is_heard()) return std::nullopt;
  if (!was_answered()) return upper_us_;
  return upper_us_ - (kFarthest_us - nearness_) / share;
}

}  // namespace flotilla::app
