// SPDX-License-Identifier: MIT
#include "app/navigation/state_sources.hpp"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "app/convert/convert.hpp"

namespace flotilla::app {
namespace {

/// Messages in a row that a better source needs before it is chosen again.
constexpr int kSteady = 5;

}  // namespace

/// A duplicate, or a message overtaken on another link, neither lengthens nor ends the row.
void StateSources::hear(Source source, std::int64_t stamp_us, std::int64_t now_us, bool accepted) {
  Heard& in = heard(source);
  if (in.in_a_row > 0 && stamp_us == in.stamp_us) return;
  const bool goes_on = in.in_a_row > 0 && now_us - in.arrived_us <= patience_us_;
  if (goes_on && stamp_us < in.stamp_us) return;
  // Keeps the clocks of unused sources ready; accepted states set the clock of the one in use.
  if (source != in_use_ || !accepted) {
    if (stamp_us < in.stamp_us) in.clock.reset();
    in.clock.heard(stamp_us, now_us);
  }
  if (in.late) {
    const auto offset_us = in.clock.offset_us();
    in.late = offset_us && now_us - stamp_us - *offset_us > ClockOffset::kLate_us;
  }
  // Either the vessel rebooted or only this message is late: VesselTrack decides.
  in.went_back = in.in_a_row > 0 && stamp_us < in.newest_us;
  in.newest_us = in.in_a_row > 0 ? std::max(in.newest_us, stamp_us) : stamp_us;
  in.in_a_row = goes_on ? std::min(in.in_a_row + 1, kSteady) : 1;
  in.arrived_us = now_us;
  in.stamp_us = stamp_us;
}

bool StateSources::comes(Source source, std::int64_t now_us) const {
  const Heard& in = heard(source);
  return in.in_a_row > 0 && now_us - in.arrived_us <= patience_us_;
}

bool StateSources::better(Source source, std::int64_t now_us, bool origin_known) const {
  const auto rank = [&](Source of) {
    const bool nowhere = of < Source::kFollowTarget && !origin_known;
    return static_cast<int>(of) + (nowhere ? int{kSources} : 0);
  };
  if (comes(in_use_, now_us)) {
    if (!steady(source) || is_behind(source, in_use_)) return false;
    return rank(source) < rank(in_use_) || is_behind(in_use_, source);
  }
  for (const Source other : {Source::kOdometry, Source::kLocalPosition, Source::kFollowTarget,
                             Source::kGlobalPosition}) {
    const bool first = rank(other) < rank(source) && !is_behind(other, source);
    if (first && comes(other, now_us) && steady(other)) return false;
  }
  return true;
}

bool StateSources::steady(Source source) const { return heard(source).in_a_row >= kSteady; }

bool StateSources::is_behind(Source source, Source other) const {
  const Heard &one = heard(source), &two = heard(other);
  return one.late != two.late ? one.late : one.clock.is_later_than(two.clock);
}

void StateSources::change_to(std::uint8_t component) {
  component_ = component;
  heard_ = {};
  ++clock_resets_;
  odometry_resets_.reset();
}

void StateSources::change_to(Source source) {
  Heard& in = heard(source);
  // A source that came in parallel counts from the same instant as the old one.
  if (steady(source) && !in.went_back && in.clock.is_later_than(clock())) {
    in.clock.share(clock());
    in.late = true;
  }
  in_use_ = source;
  if (std::exchange(in.went_back, false)) in.newest_us = in.stamp_us;
}

bool StateSources::is_reset(std::uint8_t resets, std::int64_t stamp_us) const {
  const Heard& in = heard(Source::kOdometry);
  const bool is_news = in.in_a_row == 0 || stamp_us > in.stamp_us;
  const auto next = static_cast<std::uint8_t>(odometry_resets_.value_or(resets) + 1);
  return is_news && in_use_ == Source::kOdometry && resets == next;
}

void StateSources::reboot(std::int64_t stamp_us) {
  reset_clock();
  heard(in_use_).newest_us = stamp_us;
  heard(in_use_).went_back = false;
}

void StateSources::answered(std::int64_t sent_us, std::int64_t read_us, std::int64_t now_us) {
  for (Heard& in : heard_) {
    if (in.in_a_row == 0) continue;
    // ODOMETRY's stamps do not wrap: an offset of a multiple of 49 days means another clock.
    const bool wraps = &in != &heard(Source::kOdometry);
    in.clock.answered(sent_us, wraps ? convert::unwrapped_us(read_us, in.stamp_us) : read_us,
                      now_us);
  }
}

}  // namespace flotilla::app
