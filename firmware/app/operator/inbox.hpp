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
    auto given_up = last_not(stops);
    if (given_up == pending_.size()) given_up = last_not(ends);
    if (given_up == pending_.size()) {
      if (!ends(pending)) return;
      --given_up;
    }
    const auto gap = pending_.begin() + static_cast<std::ptrdiff_t>(given_up);
    std::move(gap + 1, pending_.end(), gap);
    pending_.back() = pending;
  }

  bool is_empty() const { return count_ == 0; }

  /// Removes the requests for which a predicate is true; returns how many.
  template <class Predicate>
  std::uint32_t drop(Predicate predicate) {
    const std::size_t were = count_;
    count_ = remove(were, predicate);
    return static_cast<std::uint32_t>(were - count_);
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
      if (taken == Taken::kStop) kept = remove(kept, undoes_stop);
      last = taken == Taken::kLast || taken == Taken::kStop;
    }
    while (i < count_) pending_[kept++] = pending_[i++];
    count_ = kept;
    return last;
  }

 private:
  /// The last one for which the predicate is false; their number if there is none.
  template <class Predicate>
  std::size_t last_not(Predicate predicate) const {
    std::size_t i = pending_.size();
    while (i > 0 && predicate(pending_[i - 1])) --i;
    return i > 0 ? i - 1 : pending_.size();
  }

  /// Closes the gaps of those among the first `count` for which the predicate is true; returns how
  /// many are left.
  template <class Predicate>
  std::size_t remove(std::size_t count, Predicate predicate) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      if (!predicate(pending_[i])) pending_[kept++] = pending_[i];
    }
    return kept;
  }

  std::array<PendingRequest, 24> pending_{};
  std::size_t count_ = 0;
};

}  // namespace flotilla::app
