// SPDX-License-Identifier: MIT
#include "app/operator/telemetry/streams.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

#include "app/convert/convert.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kMinNews_us = 100'000;  // often enough for the fastest turns of a root
constexpr std::int64_t kSecond_us = 1'000'000;

}  // namespace

Streams::Streams(const Configuration& configuration, std::span<Link> links)
    : companion_(configuration.start.companion),
      tick_us_(configuration.start.tick_us),
      links_(links) {
  std::ranges::fill(links_, Link{});
  configure(configuration.operators);
}

void Streams::configure(const Configuration::Operators& operators) {
  const auto& [state_us, slow_us] = std::tie(operators.state_us, operators.slow_us);
  if (configured_ && state_us == state_us_ && slow_us == slow_us_) return;
  configured_ = true;
  state_us_ = state_us;
  slow_us_ = slow_us;
  for (std::size_t stream = 0; stream < kStreams.size(); ++stream) {
    for (std::size_t link = 0; link < links_.size(); ++link) restart(stream, link);
  }
}

bool Streams::set(std::size_t link, std::uint16_t id, std::int64_t interval_us,
                  std::uint32_t bytes_per_s) {
  const std::size_t stream = find(id);
  if (stream == kNone) return false;
  if (interval_us > 0) {
    std::int64_t least_us = tick_us_;
    if (bytes_per_s > 0) {
      least_us = std::max(least_us, kStreams[stream].bytes * std::int64_t{1'000'000} / bytes_per_s);
    }
    interval_us = std::max(interval_us, least_us);
  }
  links_[link].turns[stream].desired_us = interval_us;
  restart(stream, link);
  return true;
}

void Streams::limit(std::size_t link, std::uint32_t bytes_per_s) {
  constexpr std::uint32_t kNarrow_Bps = 5'760;
  links_[link].narrow = bytes_per_s != 0 && bytes_per_s <= kNarrow_Bps;
  for (std::size_t stream = 0; stream < kStreams.size(); ++stream) restart(stream, link);
}

/// The interval of slow telemetry; 0: none.
std::int64_t Streams::slow_interval_us(std::size_t link) const {
  if (slow_us_ == 0 || !links_[link].narrow) return slow_us_;
  return std::max(slow_us_, 4 * kSecond_us);
}

std::int64_t Streams::slowed_us(std::size_t link, std::int64_t fixed_us) const {
  const std::int64_t slow_us = slow_interval_us(link);
  return slow_us > kSecond_us ? std::max(fixed_us, slow_us) : fixed_us;
}

std::int32_t Streams::interval_us(std::size_t link, std::uint16_t id) const {
  if (id == link::Heartbeat::kId) return 1'000'000;
  const std::size_t stream = find(id);
  if (stream == kNone) return 0;
  const std::int64_t interval_us = plain_interval_us(stream, link);
  return interval_us > 0 ? static_cast<std::int32_t>(std::min<std::int64_t>(interval_us, INT32_MAX))
                         : -1;
}

bool Streams::any_rest_due(std::size_t link, std::int64_t now_us) {
  std::int64_t& quiet_until_us = links_[link].quiet_until_us;
  if (now_us < quiet_until_us) return false;
  quiet_until_us = std::numeric_limits<std::int64_t>::max();
  for (std::size_t stream = 0; stream < kStreams.size(); ++stream) {
    if (!is_rest(kStreams[stream].pace)) continue;
    quiet_until_us = std::min(quiet_until_us, links_[link].turns[stream].schedule.from_us());
  }
  return now_us >= quiet_until_us;
}

void Streams::make_due(std::uint16_t id) {
  const std::size_t stream = find(id);
  if (stream == kNone) return;
  for (std::size_t link = 0; link < links_.size(); ++link) {
    links_[link].turns[stream].schedule.make_due();
    look_anew(link);
  }
}

void Streams::radio_has_room(std::size_t link, std::uint8_t percent, std::int64_t now_us) {
  constexpr std::uint8_t kCritical = 25, kLow = 35, kHalf = 50;  // PX4's thresholds
  if (percent > 100) return;
  links_[link].radio_us = now_us;
  const double factor = percent < kCritical ? 0.8 : percent < kLow ? 0.975 : 1;
  set_share(link, links_[link].share * (percent > kHalf ? 1.025 : factor));
}

void Streams::forget_silent_radios(std::int64_t now_us) {
  constexpr std::int64_t kSilent_us = 5'000'000;
  for (std::size_t link = 0; link < links_.size(); ++link) {
    if (links_[link].share < 1 && now_us - links_[link].radio_us > kSilent_us) set_share(link, 1);
  }
}

void Streams::set_share(std::size_t link, double share) {
  links_[link].share = std::clamp(share, 0.05, 1.0);
  for (std::size_t stream = 0; stream < kStreams.size(); ++stream) {
    links_[link].turns[stream].schedule.stretch(stretched_us(stream, link));
  }
  look_anew(link);
}

std::size_t Streams::find(std::uint16_t id) const {
  const auto* const found = std::ranges::find_if(
      kStreams.begin(), kStreams.end(),
      [&](const StreamInfo& info) { return info.id == id && (info.companion || !companion_); });
  return static_cast<std::size_t>(found - kStreams.begin());
}

std::int64_t Streams::plain_interval_us(std::size_t stream, std::size_t link) const {
  const std::int64_t desired_us = links_[link].turns[stream].desired_us;
  const StreamInfo& info = kStreams[stream];
  if (desired_us != 0) return std::max<std::int64_t>(desired_us, 0);
  if (companion_ && !info.companion) return 0;
  switch (info.pace) {
    case Pace::kNews:
      return state_us_ > 0 ? std::max({state_us_ / 2, kMinNews_us, tick_us_}) : 0;
    case Pace::kState:
      return state_us_ > 0 ? std::max(state_us_, tick_us_) : 0;
    case Pace::kSlow:
      return slow_us_ > 0 ? std::max(slow_interval_us(link), tick_us_) : 0;
    case Pace::kFixed:
      if (stream == kPositionStream && links_[link].narrow) return std::max(kSecond_us, slow_us_);
      return slowed_us(link, info.fixed_us);
    case Pace::kOnRequest:
      return 0;
  }
  return 0;
}

std::int64_t Streams::stretched_us(std::size_t stream, std::size_t link) const {
  constexpr std::int64_t kSlowestState_us = 500'000;
  const std::int64_t plain_us = plain_interval_us(stream, link);
  const auto us = static_cast<std::int64_t>(static_cast<double>(plain_us) / links_[link].share);
  if (kStreams[stream].pace != Pace::kState) return us;
  return std::min(us, std::max(plain_us, kSlowestState_us));
}

void Streams::restart(std::size_t stream, std::size_t link) {
  links_[link].turns[stream].schedule = Schedule(stretched_us(stream, link), tick_us_ / 2);
  look_anew(link);
}

}  // namespace flotilla::app
