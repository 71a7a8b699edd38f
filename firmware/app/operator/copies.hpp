// SPDX-License-Identifier: MIT
// Recognises requests that come a second time, by another link: where several vessels hear a ground
// station, they hand its messages on, and a copy may be late enough to undo a newer request.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "link/mavlink/messages.hpp"

namespace flotilla::app {

class Copies {
 public:
  /// Whether this very message came by another link within the last 5 s; remembers it.
  bool is_copy(const link::Received& received, std::size_t link, std::int64_t now_us) {
    constexpr std::int64_t kLate_us = 5'000'000;
    const Seen now{now_us, received.from, received.id, static_cast<std::uint8_t>(link),
                   received.sequence};
    const bool copy = std::ranges::any_of(seen_, [&](const Seen& then) {
      return then.link != now.link && then.sequence == now.sequence && then.id == now.id &&
             then.from == now.from && now_us - then.us < kLate_us;
    });
    seen_[next_] = now;
    next_ = (next_ + 1) % seen_.size();
    return copy;
  }

 private:
  struct Seen {
    std::int64_t us = std::numeric_limits<std::int64_t>::min() / 2;
    link::Address from{};
    std::uint32_t id = 0;
    std::uint8_t link = 0, sequence = 0;
  };

  std::array<Seen, 24> seen_{};
  std::size_t next_ = 0;
};

}  // namespace flotilla::app
