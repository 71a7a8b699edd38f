// SPDX-License-Identifier: MIT
// A one-way link that carries chunks, with delay, jitter, loss and bandwidth. Counterpart of
// sil/wire/link.py in the live SIL.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace flotilla::fleet {

/// Uniform numbers in [0, 1). Source: Steele, Lea, Flood, Fast splittable pseudorandom number
/// generators, OOPSLA 2014.
class SplitMix64 {
 public:
  explicit SplitMix64(std::uint64_t seed) : state_(seed) {}
  double uniform();

 private:
  std::uint64_t state_;
};

/// Delay, uniform jitter in [0, jitter_s), share of lost chunks, bytes per second (0: unlimited).
struct LinkQuality {
  double delay_s = 0, jitter_s = 0, loss = 0, rate_Bps = 0;
  bool operator==(const LinkQuality&) const = default;
};

/// State of an imperfect link; times are the world's, µs.
class Channel {
 public:
  explicit Channel(std::uint64_t seed) : random_(seed) {}

  void set(const LinkQuality& quality) { quality_ = quality; }
  void delay_more(double by_s) { late_s_ += by_s; }
  void corrupt(std::size_t bit) { bit_ = bit; }

  /// The chunk if it arrives at once; empty if it is delayed or lost.
  std::span<const std::uint8_t> send(std::span<const std::uint8_t> data, std::int64_t now_us);

  /// Whether a chunk has arrived; take() returns the first one, valid until the next call.
  bool has_arrived(std::int64_t now_us) const {
    return !in_flight_.empty() && in_flight_.front().arrival_us <= now_us;
  }
  std::span<const std::uint8_t> take();

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Flight {
    std::int64_t arrival_us;
    std::uint64_t number;
    Bytes data;
    bool operator>(const Flight& other) const {
      return arrival_us != other.arrival_us ? arrival_us > other.arrival_us : number > other.number;
    }
  };

  void launch(std::span<const std::uint8_t> data, std::int64_t now_us);

  LinkQuality quality_;
  double late_s_ = 0;  // beyond its quality's delay
  SplitMix64 random_;
  std::int64_t free_us_ = 0;
  std::uint64_t sent_ = 0;
  std::optional<std::size_t> bit_;
  std::vector<Flight> in_flight_;  // a heap, the first to arrive in front
  Bytes damaged_, taken_;
};

class RadioLink {
 public:
  explicit RadioLink(std::uint64_t seed) : seed_(seed) {}

  /// Applies from now on; chunks in flight arrive as they would have.
  void set(const LinkQuality& quality);

  /// Delays every later chunk by that much beyond its quality's delay; calls add up.
  void delay_more(double by_s) { channel().delay_more(by_s); }

  /// Flips one bit of the next chunk sent, counted modulo its length.
  void corrupt(std::size_t bit) { channel().corrupt(bit); }

  /// Sends a chunk; its memory must stay valid until it is received.
  void send(std::span<const std::uint8_t> data, std::int64_t now_us) {
    waiting_ = channel_ ? channel_->send(data, now_us) : data;
  }

  /// Forgets undelayed chunks not yet received; chunks in flight stay.
  void forget() { waiting_ = {}; }

  /// Passes arrived chunks to `take`, in order of arrival.
  template <class Take>
  void receive(std::int64_t now_us, Take take) {
    if (!waiting_.empty()) {
      const auto data = waiting_;
      waiting_ = {};
      take(data);
    }
    if (!channel_) return;
    while (channel_->has_arrived(now_us)) take(channel_->take());
  }

 private:
  Channel& channel();

  std::span<const std::uint8_t> waiting_;
  std::unique_ptr<Channel> channel_;
  std::uint64_t seed_;
};

}  // namespace flotilla::fleet
