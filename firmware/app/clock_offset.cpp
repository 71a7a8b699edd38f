// SPDX-License-Identifier: MIT
#include "app/clock_offset.hpp"

#include <algorithm>

namespace flotilla::app {
namespace {

using Bound = std::optional<std::int64_t>;

Bound least(Bound a, Bound b) { return a && b ? std::min(*a, *b) : (a ? a : b); }
Bound greatest(Bound a, Bound b) { return a && b ? std::max(*a, *b) : (a ? a : b); }

}  // namespace

ClockOffset::Bounds& ClockOffset::window(std::int64_t now_us) {
  if (now_us - window_began_us_ > kWindow_us) {
    before_ = now_us - window_began_us_ > 2 * kWindow_us ? Bounds{} : now_;
    now_ = {};
    window_began_us_ = now_us;
  }
  return now_;
}

void ClockOffset::heard(std::int64_t stamp_us, std::int64_t now_us) {
  Bounds& bounds = window(now_us);
  bounds.upper = least(bounds.upper, now_us - stamp_us);
}

void ClockOffset::answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us) {
  Bounds& bounds = window(now_us);
  bounds.lower = greatest(bounds.lower, sent_us - read_us);
}

std::optional<std::int64_t> ClockOffset::offset_us() const {
  const Bound upper = least(now_.upper, before_.upper);
  const Bound lower = greatest(now_.lower, before_.lower);
  if (!upper) return std::nullopt;
  if (!lower || *lower > *upper) return upper;  // no answer yet, or their clock was set
  return *lower + (*upper - *lower) / 2;
}

}  // namespace flotilla::app
