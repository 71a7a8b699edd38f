// SPDX-License-Identifier: MIT
#include "linux/mavlink/peers.hpp"

#include <algorithm>
#include <utility>

namespace flotilla::target {

void Peers::accepted(const sockaddr_in& from, bool is_signed, std::int64_t now_us) {
  const auto known = std::ranges::find_if(peers_, [&](const Peer& p) {
    return p.address.sin_addr.s_addr == from.sin_addr.s_addr && p.address.sin_port == from.sin_port;
  });
  if (known != peers_.end()) {
    if (is_signed || !known->is_signed) known->heard_us = now_us;
    known->is_signed = known->is_signed || is_signed;
    return;
  }
  const Peer newcomer{from, is_signed, now_us};
  if (peers_.size() < kMax) {
    peers_.push_back(newcomer);
    return;
  }
  Peer& least = *std::ranges::min_element(
      peers_, {}, [](const Peer& p) { return std::pair(p.is_signed, p.heard_us); });
  const bool silent = now_us - least.heard_us >= kSilent_us;
  if (least.is_signed == is_signed ? silent : is_signed) least = newcomer;
}

void Peers::forget_silent(std::int64_t now_us) {
  std::erase_if(peers_, [&](const Peer& p) { return now_us - p.heard_us >= kForgotten_us; });
}

}  // namespace flotilla::target
