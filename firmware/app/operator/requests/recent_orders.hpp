// SPDX-License-Identifier: MIT
// The last stop and the last order to drive, which late requests must not undo.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <string_view>
#include <utility>

#include "app/operator/requests/inbox.hpp"

namespace flotilla::app {

/// A command to disarm wins over a request that comes after it in the same tick: whoever sent the
/// request had not yet seen the boat disarmed. A late retransmission undoes no newer stop: for 5 s
/// after a stop, a request to drive is refused on links that did not carry the stop (or the stops of
/// two operators), and a repeated one from another operator. Nor does it undo a newer order: for 5 s
/// after one, another operator's repeated order is refused, and the same operator's with a lower
/// sequence number on another link. An order is a request to drive, a target, a setpoint, an item of
/// the plan, a pause or its end. The microcontroller's image has no room for these 5 s.
class RecentOrders {
 public:
  /// Records a stop by the pilot's switch. It counts as received on all links; within 5 s of an
  /// operator's stop, only on that stop's links. It has no sender.
  void note_pilots_stop(std::int64_t now_us) {
    stop_ = {now_us, {}, is_recent(stop_.us, now_us) ? stop_.links : std::uint8_t{0xFF}, false};
  }

  /// Records that a pilot took over. He has no sender.
  void note_pilots_order(std::int64_t now_us) { note({now_us, {}, kAnyLink, 0}); }

  /// Records an order that was accepted.
  void note_order(const PendingRequest& order, std::int64_t now_us) {
    note({now_us, order.from, order.link, order.sequence});
  }

  /// The same for a setpoint. They come often: so it leaves its sender's other links open.
  void note_setpoint(const PendingRequest& setpoint, std::int64_t now_us) {
    note({now_us, setpoint.from, kAnyLink, 0});
  }

  /// Judges a request that asks for a state, and records it if it is a stop. Why it must be refused;
  /// empty if it need not. repeated: it is a retransmission.
  std::string_view judge(const PendingRequest& pending, core::Request request, bool repeated,
                         std::int64_t now_us) {
    using core::RequestKind;
    const auto link = static_cast<std::uint8_t>(1U << pending.link);
    const bool others = pending.from != stop_.by;
    const bool recent = is_recent(stop_.us, now_us);
    const bool after_disarm = stop_.disarms && pending.read_us <= stop_.us;
    const RequestKind kind = core::kind_of(request);
    if (kind == RequestKind::kStops) {
      const unsigned links = !recent ? link : others ? stop_.links & link : stop_.links | link;
      stop_ = {now_us, pending.from, static_cast<std::uint8_t>(links),
               after_disarm || request != core::Request::kHold};
      return {};
    }
    if (after_disarm || (recent && ((stop_.links & link) == 0 || (others && repeated)))) {
      return "boat was just stopped: ask again in 5 s";
    }
    return core::turns_propellers(kind) ? judge_order(pending, repeated, now_us) : "";
  }

  /// The same for an order, whether or not it asks for a state.
  std::string_view judge_order(const PendingRequest& pending, bool repeated,
                               std::int64_t now_us) const {
    const bool late = std::ranges::any_of(orders_, [&](const Order& order) {
      const bool other = order.link != kAnyLink && pending.link != order.link;
      const bool older = static_cast<std::int8_t>(pending.sequence - order.sequence) < 0;
      return is_recent(order.us, now_us) && (pending.from != order.by ? repeated : other && older);
    });
    return late ? "a newer order came: ask again in 5 s" : "";
  }

 private:
  static constexpr std::uint8_t kAnyLink = 0xFF;
  static constexpr std::int64_t kNever_us = std::numeric_limits<std::int64_t>::min() / 2;

  static bool is_recent(std::int64_t us, std::int64_t now_us) {
    return FLOTILLA_KEEPS_FLEET != 0 && now_us - us < 5'000'000;
  }

  struct Stop {
    std::int64_t us = kNever_us;
    link::Address by{};
    std::uint8_t links = 0;  ///< on which it came, a bit mask
    bool disarms = false;    ///< not only HOLD
  };
  struct Order {
    std::int64_t us = kNever_us;
    link::Address by{};
    std::uint8_t link = 0, sequence = 0;
  };
  void note(const Order& order) {
    if (FLOTILLA_KEEPS_FLEET == 0) return;
    if (order.by != orders_.front().by) std::swap(orders_.front(), orders_.back());
    orders_.front() = order;
  }

  Stop stop_;
  // Of the last two operators, the newer one first.
  std::array<Order, FLOTILLA_KEEPS_FLEET != 0 ? 2 : 1> orders_{};
};

}  // namespace flotilla::app
