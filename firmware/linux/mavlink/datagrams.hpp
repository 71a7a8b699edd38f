// SPDX-License-Identifier: MIT
// Cuts a tick's messages into datagrams that every client can read: gomavlib reads 512 bytes.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/mavlink/frame.hpp"

namespace flotilla::target {

constexpr std::size_t kMaxDatagramBytes = 500;

/// Calls send(datagram), each with as many whole messages as fit into kMaxDatagramBytes; bytes that
/// are no messages are sent in one piece.
template <class Send>
void each_datagram(std::span<const std::uint8_t> messages, Send send) {
  std::size_t size = 0;  // of the datagram at the front of `messages`
  while (size < messages.size()) {
    const auto header = link::read_header(messages.subspan(size));
    const std::size_t next = header ? header->frame_bytes() : messages.size() - size;
    if (size > 0 && size + next > kMaxDatagramBytes) {
      send(messages.first(size));
      messages = messages.subspan(size);
      size = 0;
    }
    size = std::min(size + next, messages.size());
  }
  if (size > 0) send(messages.first(size));
}

}  // namespace flotilla::target
