// SPDX-License-Identifier: MIT
// What was asked since the last tick, kept until the tick that answers it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "app/operator/commands.hpp"
#include "link/counters.hpp"

namespace flotilla::app {

/// Kept small: a request for a file is kept as what it asks, not as it came.
struct PendingRequest {
  std::int64_t read_us = 0;
  RequestMessage message{};
  link::Address from{};
  link::Address target{};
  std::uint8_t link = 0;
};

/// Disarms or terminates: never to be lost or put off.
inline bool stops(const PendingRequest& pending) {
  const auto command = command_of(pending.message);
  return command && is_stop(*command);
}

/// First come first served; one too many is counted, its sender repeats it. What stops the boat is
/// never one too many, and of two such the later one has the last word.
class Inbox {
 public:
  void push(const PendingRequest& pending, link::Counters& counters) {
    if (count_ < pending_.size()) {
      pending_[count_++] = pending;
      return;
    }
    ++counters.requests_dropped;
    if (!stops(pending)) return;
    const auto first = std::find_if_not(pending_.rbegin(), pending_.rend(), stops);
    const auto given_up = first == pending_.rend() ? pending_.end() - 1 : first.base() - 1;
    std::move(given_up + 1, pending_.end(), given_up);
    pending_.back() = pending;
  }

  bool is_empty() const { return count_ == 0; }

  enum class Taken : std::uint8_t {
    kAnswered,
    kKept,  ///< for the next time
    kLast,  ///< answered, and those behind it are kept
    kStop,  ///< the same, and what it would be undone by is void
  };

  /// Calls answer(letter) for each in order; whether that ended before the last of them.
  /// undoes_stop(letter) tells of a kept one what a stop makes void.
  template <class Answer, class UndoesStop>
  bool take_each(Answer answer, UndoesStop undoes_stop) {
    std::size_t kept = 0, i = 0;
    bool last = false;
    for (; i < count_ && !last; ++i) {
      const Taken taken = answer(pending_[i]);
      if (taken == Taken::kKept) pending_[kept++] = pending_[i];
      if (taken == Taken::kStop) {
        const auto begin = pending_.begin(), end = begin + static_cast<std::ptrdiff_t>(kept);
        kept = static_cast<std::size_t>(std::remove_if(begin, end, undoes_stop) - begin);
      }
      last = taken == Taken::kLast || taken == Taken::kStop;
    }
    while (i < count_) pending_[kept++] = pending_[i++];
    count_ = kept;
    return last;
  }

 private:
  std::array<PendingRequest, 24> pending_{};
  std::size_t count_ = 0;
};

}  // namespace flotilla::app
