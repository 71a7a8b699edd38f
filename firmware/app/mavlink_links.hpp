// SPDX-License-Identifier: MIT
// The boat's MAVLink links: a decoder, an encoder and this tick's outgoing bytes for each.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "link/mavlink_decode.hpp"
#include "link/mavlink_encode.hpp"

namespace flotilla::app {

constexpr std::size_t kMaxLinks = 4;

class MavlinkLinks {
 public:
  /// count: 1 … kMaxLinks
  MavlinkLinks(std::size_t count, link::Address self) : count_(count) {
    for (Link& link : links_) link.encoder = link::MavlinkEncoder(self);
  }

  std::size_t count() const { return count_; }

  link::MavlinkDecoder& decoder(std::size_t link) { return links_[link].decoder; }

  /// Telemetry on this link keeps to so many bytes a second; 0: no limit.
  void limit(std::size_t link, std::uint32_t bytes_per_s) { links_[link].rate_Bps = bytes_per_s; }

  /// A message that finds no room waits for nobody: it is dropped whole and counted.
  void send(std::size_t link, const link::Message& message, link::Counters& counters) {
    Link& l = links_[link];
    const std::size_t size = l.encoder.encode(message, std::span(l.bytes).subspan(l.size));
    l.size += size;
    l.credit -= static_cast<std::int64_t>(size) * kSecond_us;
    if (size == 0) ++counters.mavlink_not_sent;
  }

  void broadcast(const link::Message& message, link::Counters& counters) {
    for (std::size_t link = 0; link < count_; ++link) send(link, message, counters);
  }

  /// Messages that belong together; a link that has no credit left passes them over.
  void broadcast_telemetry(std::initializer_list<link::Message> messages,
                           link::Counters& counters) {
    for (std::size_t link = 0; link < count_; ++link) {
      if (links_[link].rate_Bps != 0 && links_[link].credit <= 0) continue;
      for (const link::Message& message : messages) send(link, message, counters);
    }
  }

  std::span<const std::uint8_t> bytes(std::size_t link) const {
    return {links_[link].bytes.data(), links_[link].size};
  }

  /// Begins a tick, dt_us after the one before.
  void begin(std::int64_t dt_us) {
    for (Link& link : links_) {
      link.size = 0;
      // Half a second's worth may be saved up.
      const std::int64_t most = std::int64_t{link.rate_Bps} * kSecond_us / 2;
      const std::int64_t earned = std::int64_t{link.rate_Bps} * std::min(dt_us, kSecond_us);
      link.credit = std::min(link.credit + earned, most);
    }
  }

 private:
  struct Link {
    link::MavlinkDecoder decoder;
    link::MavlinkEncoder encoder;
    std::array<std::uint8_t, 1024> bytes{};
    std::size_t size = 0;
    std::uint32_t rate_Bps = 0;
    std::int64_t credit = 0;  // bytes × 10⁶
  };
  static constexpr std::int64_t kSecond_us = 1'000'000;

  std::size_t count_;
  std::array<Link, kMaxLinks> links_{};
};

}  // namespace flotilla::app
