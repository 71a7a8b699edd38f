// SPDX-License-Identifier: MIT
// Requests since the last tick, kept until the tick that answers them.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "app/operator/requests/commands.hpp"
#include "link/counters.hpp"

namespace flotilla::app {

/// Kept small: a file request is stored decoded, not as received.
struct PendingRequest {
  PendingRequest() = default;
  PendingRequest(std::int64_t time_us, const RequestMessage& request, link::Address sender,
                 link::Address receiver, std::size_t on_link, bool obeyed = true)
      : read_us(time_us),
        message(request),
        from(sender),
        target(receiver),
        link(static_cast<std::uint8_t>(on_link)),
        may_command(obeyed),
        effects(effects_of(request, obeyed)) {}

  std::int64_t read_us = 0;
  RequestMessage message{};
  link::Address from{};
  link::Address target{};
  std::uint8_t link = 0;
  std::uint8_t sequence = 0;  ///< of its frame
  bool may_command = true;
  Effects effects{};
};

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
    if (!pending.effects.stops) return;
    auto given_up = last_without([](Effects effects) { return effects.stops; });
    if (given_up == pending_.size()) {
      given_up = last_without([](Effects effects) { return effects.ends; });
    }
    if (given_up == pending_.size()) {
      if (!pending.effects.ends) return;
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
  /// Index of the last request without this effect; pending_.size() if all have it.
  template <class Effect>
  std::size_t last_without(Effect effect) const {
    std::size_t i = pending_.size();
    while (i > 0 && effect(pending_[i - 1].effects)) --i;
    return i > 0 ? i - 1 : pending_.size();
  }

  /// Removes the requests among the first `count` for which the predicate is true; returns how many
  /// remain.
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
