// SPDX-License-Identifier: MIT
// The clocks of the vessels that send references.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/navigation/clock_offset.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// When full, keeps the senders nearest to the root, whose references are the newest.
class SenderClocks {
 public:
  /// Latency of senders that answer no TIMESYNC; nothing: unknown.
  void set_lag(std::optional<std::int64_t> lag_us) { lag_us_ = lag_us; }

  /// A stamp in our time, no later than now.
  struct Stamp {
    std::int64_t us;
    std::int64_t least_us;  ///< the stamp at the clock's worst possible error
    bool timed;             ///< false: the latency is unknown, and taken as 0
    bool overtaken;         ///< a later message of the sender came first, on a faster link
  };

  /// Call when a message of that sender arrives; returns nothing if there is no room for its clock.
  /// rank: depth in the tree, from 1; 0 is the leader, whose clock always finds room.
  std::optional<Stamp> heard(link::Address from, std::uint8_t rank, std::uint32_t time_boot_ms,
                             std::int64_t now_us);

  /// A sender answered the TIMESYNC request that we sent at `sent_us`.
  void answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                std::int64_t now_us);

 private:
  struct Sender {
    link::Address from{};  ///< system 0: a free entry
    std::uint8_t rank = 0;
    std::int64_t stamp_us = 0, arrived_us = 0;
    ClockOffset clock;
  };

  Sender* find(link::Address from);
  Sender* place_for(std::uint8_t rank, std::int64_t now_us);

  std::array<Sender, 4> senders_{};
  std::optional<std::int64_t> lag_us_;
};

}  // namespace flotilla::app
