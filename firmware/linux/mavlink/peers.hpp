// SPDX-License-Identifier: MIT
// The peers of a listening UDP link: the senders of accepted messages.
//
// Nothing is sent to a sender before the boat has accepted one of its messages. A silent peer is
// forgotten. If the table is full, a new peer replaces the longest silent one that has not signed:
// at once if the new peer has signed, else after three missed heartbeats. A peer that has signed is
// replaced only by a new one that has signed, after three missed heartbeats.
#pragma once

#include <netinet/in.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace flotilla::target {

/// Never allocates after construction.
class Peers {
 public:
  static constexpr std::size_t kMax = 8;
  static constexpr std::int64_t kSilent_us = 3'000'000, kForgotten_us = 30'000'000;

  Peers() { peers_.reserve(kMax); }

  /// Notes an accepted message of this sender. Only signed ones keep the place of a peer that
  /// signed.
  void accepted(const sockaddr_in& from, bool is_signed, std::int64_t now_us);

  void forget_silent(std::int64_t now_us);

  struct Peer {
    sockaddr_in address;
    bool is_signed;
    std::int64_t heard_us;
  };
  std::span<const Peer> all() const { return peers_; }

 private:
  std::vector<Peer> peers_;
};

}  // namespace flotilla::target
