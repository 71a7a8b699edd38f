// SPDX-License-Identifier: MIT
// Requests since the last tick, kept until the tick that answers them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "app/operator/commands.hpp"
#include "link/counters.hpp"

namespace flotilla::app {

/// Kept small: a file request is stored decoded, not as received.
struct PendingRequest {
  std::int64_t read_us = 0;
  RequestMessage message{};
  link::Address from{};
  link::Address target{};
  std::uint8_t link = 0;
  bool may_command = true;
};

/// Disarms or terminates.
inline bool ends(const PendingRequest& pending) {
  const auto command = command_of(pending.message);
  return command && is_stop(*command);
}

/// Disarms, terminates, or is a HOLD that is obeyed: must never be lost or postponed.
inline bool stops(const PendingRequest& pending) {
  const auto command = command_of(pending.message);
  return command && (pending.may_command ? stops_boat(*command) : is_stop(*command));
}

/// First in, first out. A request that does not fit is counted; its sender repeats it. A stop
/// always fits, in place of another request, and the latest stop wins; but HOLD never takes the
/// place of disarming or termination.
class Inbox {
 public:
  void push(const PendingRequest& pending, link::Counters& counters) {
    if (count_ < pending_.size()) {
      pending_[count_++] = pending;
      return;
    }
    ++counters.requests_dropped;
    if (!stops(pending)) return;
    auto last = std::find_if_not(pending_.rbegin(), pending_.rend(), stops);
    if (last == pending_.rend()) last = std::find_if_not(pending_.rbegin(), last, ends);
    if (last == pending_.rend()) {
      if (!ends(pending)) return;
      last = pending_.rbegin();
    }
    const auto given_up = last.base() - 1;
    std::move(given_up + 1, pending_.end(), given_up);
    pending_.back() = pending;
  }

  bool is_empty() const { return count_ == 0; }

  /// Removes the requests for which a predicate is true; returns how many.
  template <class Predicate>
  std::uint32_t drop(Predicate predicate) {
    const auto end = pending_.begin() + static_cast<std::ptrdiff_t>(count_);
    const auto dropped = end - std::remove_if(pending_.begin(), end, predicate);
    count_ -= static_cast<std::size_t>(dropped);
    return static_cast<std::uint32_t>(dropped);
  }

  enum class Taken : std::uint8_t {
    kAnswered,
    kKept,  ///< until the next call
    kLast,  ///< answered; all requests behind it are kept
    kStop,  ///< as kLast, but kept requests that would undo the stop are dropped
  };

  /// Calls answer(request) for each in order, up to kLast or kStop; returns whether one of these
  /// came. undoes_stop(request): whether a stop drops this kept request.
  template <class Answer, class UndoesStop>
  [[nodiscard]] bool take_each(Answer answer, UndoesStop undoes_stop) {
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
