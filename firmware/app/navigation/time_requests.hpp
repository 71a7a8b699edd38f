// SPDX-License-Identifier: MIT
// TIMESYNC in both directions: our requests and our answers.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "link/mavlink/messages.hpp"

namespace flotilla::app {

class TimeRequests {
 public:
  /// A request carries a unique number: our time in ns plus our system id.
  link::Timesync ask(std::int64_t now_us, std::uint8_t system) {
    const std::int64_t ts1 = now_us * 1000 + system;
    asked_[next_++ % asked_.size()] = ts1;
    return {0, ts1};
  }

  /// Time at which we sent the request that this answers, µs; nothing if that request is not among
  /// the last 32, because an answer this late is useless.
  std::optional<std::int64_t> sent_us(const link::Timesync& answer) const {
    for (const std::int64_t ts1 : asked_) {
      if (ts1 != 0 && ts1 == answer.ts1) return ts1 / 1000;
    }
    return std::nullopt;
  }

  /// The answer gives the time at which the request was read; it is sent only with the next tick.
  static link::Timesync answer_to(const link::Timesync& request, link::Address asker,
                                  std::int64_t read_us) {
    return {std::max<std::int64_t>(read_us * 1000, 1), request.ts1,
            asker};  // 0 would mark a request
  }

 private:
  std::array<std::int64_t, 32> asked_{};
  std::size_t next_ = 0;
};

}  // namespace flotilla::app
