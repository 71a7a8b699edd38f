// SPDX-License-Identifier: MIT
// The boat's MAVLink links: a decoder, an encoder and this tick's outgoing bytes for each.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "link/mavlink_decode.hpp"
#include "link/mavlink_encode.hpp"

namespace flotilla::app {

constexpr std::size_t kMaxLinks = 4;

class MavlinkLinks {
 public:
  /// count: 1 … kMaxLinks
  MavlinkLinks(std::size_t count, link::Sender self) : count_(count) {
    for (Link& link : links_) link.encoder = link::MavlinkEncoder(self);
  }

  std::size_t count() const { return count_; }

  link::MavlinkDecoder& decoder(std::size_t link) { return links_[link].decoder; }

  /// A message that finds no room waits for nobody: it is dropped whole and counted.
  void send(std::size_t link, const link::Message& message, link::Counters& counters) {
    Link& l = links_[link];
    const std::size_t size = l.encoder.encode(message, std::span(l.bytes).subspan(l.size));
    l.size += size;
    if (size == 0) ++counters.mavlink_not_sent;
  }

  void broadcast(const link::Message& message, link::Counters& counters) {
    for (std::size_t link = 0; link < count_; ++link) send(link, message, counters);
  }

  std::span<const std::uint8_t> bytes(std::size_t link) const {
    return {links_[link].bytes.data(), links_[link].size};
  }

  void clear() {
    for (Link& link : links_) link.size = 0;
  }

 private:
  struct Link {
    link::MavlinkDecoder decoder;
    link::MavlinkEncoder encoder;
    std::array<std::uint8_t, 1024> bytes{};
    std::size_t size = 0;
  };

  std::size_t count_;
  std::array<Link, kMaxLinks> links_{};
};

}  // namespace flotilla::app
