// SPDX-License-Identifier: MIT
// TIMESYNC, both ways: our requests and the answers we owe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "link/messages.hpp"

namespace flotilla::app {

class TimeRequests {
 public:
  /// A request carries a number that nobody else sends: our time in ns, its low digits our system
  /// id.
  link::Timesync ask(std::int64_t now_us, std::uint8_t system) {
    const std::int64_t ts1 = now_us * 1000 + system;
    asked_[next_++ % asked_.size()] = ts1;
    return {0, ts1};
  }

  /// When we sent the request that this answers, µs; nothing where it is not one of our last.
  std::optional<std::int64_t> sent_us(const link::Timesync& answer) const {
    for (const std::int64_t ts1 : asked_) {
      if (ts1 != 0 && ts1 == answer.ts1) return ts1 / 1000;
    }
    return std::nullopt;
  }

  struct Owed {
    std::size_t link;
    link::Timesync answer;
  };

  /// Someone asked: the answer tells when the request was read; it leaves with the next tick.
  void asked(std::size_t link, const link::Timesync& request, std::int64_t now_us) {
    if (owed_count_ < owed_.size()) owed_[owed_count_++] = {link, {now_us * 1000, request.ts1}};
  }
  std::span<const Owed> owed() const { return {owed_.data(), owed_count_}; }
  void clear_owed() { owed_count_ = 0; }

 private:
  std::array<std::int64_t, 4> asked_{};
  std::size_t next_ = 0;
  std::array<Owed, 8> owed_{};
  std::size_t owed_count_ = 0;
};

}  // namespace flotilla::app
