// SPDX-License-Identifier: MIT
// What was asked since the last tick, kept until the tick that answers it.
#pragma once

#include <array>
#include <cstddef>

#include "app/commands.hpp"
#include "link/counters.hpp"

namespace flotilla::app {

struct Letter {
  std::size_t link = 0;
  link::Received received{};
  std::int64_t read_us = 0;
};

/// First come first served; one too many is counted, its sender repeats it. What stops the boat is
/// never one too many.
class Inbox {
 public:
  void push(const Letter& letter, link::Counters& counters) {
    if (count_ < letters_.size()) {
      letters_[count_++] = letter;
      return;
    }
    ++counters.requests_dropped;
    const auto command = command_of(letter.received.message);
    if (command && is_stop(*command)) letters_.back() = letter;
  }

  /// Calls answer(letter) for each in order; those that it returns false for stay for next time.
  template <class F>
  void take_each(F answer) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (!answer(letters_[i])) letters_[kept++] = letters_[i];
    }
    count_ = kept;
  }

 private:
  std::array<Letter, 24> letters_{};
  std::size_t count_ = 0;
};

}  // namespace flotilla::app
