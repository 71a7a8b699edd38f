// SPDX-License-Identifier: MIT
#include "fleet/radio_link.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

namespace flotilla::fleet {
namespace {

std::int64_t rounded_us(double us) { return static_cast<std::int64_t>(std::nearbyint(us)); }

}  // namespace

double SplitMix64::uniform() {
  state_ += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state_;
  z = (z ^ z >> 30U) * 0xBF58476D1CE4E5B9U;
  z = (z ^ z >> 27U) * 0x94D049BB133111EBU;
  return static_cast<double>((z ^ z >> 31U) >> 11U) * 0x1p-53;
}

std::span<const std::uint8_t> Channel::send(std::span<const std::uint8_t> data,
                                            std::int64_t now_us) {
  if (bit_) {
    const std::size_t at = *std::exchange(bit_, std::nullopt) % (8 * data.size());
    damaged_.assign(data.begin(), data.end());
    damaged_[at / 8] = static_cast<std::uint8_t>(damaged_[at / 8] ^ 1U << at % 8);
    data = damaged_;
  }
  if (in_flight_.empty() && quality_ == LinkQuality{} && late_s_ == 0) return data;
  launch(data, now_us);
  return {};
}

void Channel::launch(std::span<const std::uint8_t> data, std::int64_t now_us) {
  std::int64_t arrival_us = now_us;
  if (quality_.rate_Bps > 0) {
    const double time_us = 1e6 * static_cast<double>(data.size()) / quality_.rate_Bps;
    free_us_ = std::max(free_us_, now_us) + rounded_us(time_us);
    arrival_us = free_us_;
  }
  if (quality_.loss > 0 && random_.uniform() < quality_.loss) return;
  double latency_s = quality_.delay_s + late_s_;
  if (quality_.jitter_s > 0) latency_s += quality_.jitter_s * random_.uniform();
  in_flight_.push_back(
      {arrival_us + rounded_us(1e6 * latency_s), ++sent_, Bytes(data.begin(), data.end())});
  std::push_heap(in_flight_.begin(), in_flight_.end(), std::greater<>{});
}

std::span<const std::uint8_t> Channel::take() {
  std::pop_heap(in_flight_.begin(), in_flight_.end(), std::greater<>{});
  taken_ = std::move(in_flight_.back().data);
  in_flight_.pop_back();
  return taken_;
}

void RadioLink::set(const LinkQuality& quality) {
  if (channel_ || quality != LinkQuality{}) channel().set(quality);
}

Channel& RadioLink::channel() {
  if (!channel_) channel_ = std::make_unique<Channel>(seed_);
  return *channel_;
}

}  // namespace flotilla::fleet
