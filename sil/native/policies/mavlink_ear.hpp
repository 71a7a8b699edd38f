// SPDX-License-Identifier: MIT
// Listens on a boat's MAVLink links, to received and sent messages. Reads headers and the fields
// that rules need; checksums are left to the decoder, whose counters report bad ones.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <span>

#include "link/mavlink/messages.hpp"
#include "policies/moment.hpp"

namespace flotilla::policies {

/// A message within bytes; the payload's truncated end reads as zeros.
struct Frame {
  std::size_t size = 0;  ///< with checksum and signature; 0: none
  link::Address from;
  std::uint8_t sequence = 0;
  std::uint32_t id = 0;
  std::span<const std::uint8_t> payload;
};
class MavlinkEar {
 public:
  explicit MavlinkEar(const app::Parameters& p);

  /// Bytes that the boat receives; returns whether they are complete frames.
  bool hear(std::span<const std::uint8_t> bytes, const app::Parameters& p, Moment& n);

  /// All bytes that the boat sends on one link in a tick.
  void read(std::span<const std::uint8_t> bytes, std::size_t link, Moment& n);

  /// After read() of all links: notes the oldest times among them.
  void note_times(std::size_t links, Moment& n) const;

 private:
  struct Link {
    bool counts = false;
    std::uint8_t sequence = 0;
    bool beats = false;  ///< in this tick
    std::int64_t beat_us = 0, timesync_us = 0;
  };

  struct Order {
    std::uint16_t command;
    float first;
  };

  void hear_command(Order order, link::Address from, link::Address target, const app::Parameters& p,
                    Moment& n) const;
  void hear_mode(double mode, Moment& n) const;
  void hear_request(std::uint32_t id, link::Address from, std::span<const std::uint8_t> m,
                    const app::Parameters& p, Moment& n) const;
  void read_own(const Frame& frame, Link& link, Moment& n);

  link::Address self_;
  bool companion_;
  std::bitset<256> heard_;  ///< system ids
  std::array<Link, app::kMaxLinks> links_{};
};

}  // namespace flotilla::policies
