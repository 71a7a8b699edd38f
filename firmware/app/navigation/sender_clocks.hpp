// SPDX-License-Identifier: MIT
// The clocks of the vessels that a reference is heard from.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/navigation/clock_offset.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// Of more senders than there is room for, those nearest to the root are kept: news comes from there.
class SenderClocks {
 public:
  /// A message of that sender has arrived: our time of its stamp, no later than now; nothing where
  /// there is no room for its clock. Rank: depth in the tree; 0: there is always room.
  std::optional<std::int64_t> heard(link::Address from, std::uint8_t rank,
                                    std::uint32_t time_boot_ms, std::int64_t now_us);

  /// A sender answered the TIMESYNC request that we sent at `sent_us`.
  void answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                std::int64_t now_us);

 private:
  struct Sender {
    link::Address from{};  ///< system 0: this place is free
    std::uint8_t rank = 0;
    std::int64_t stamp_us = 0, arrived_us = 0;
    ClockOffset clock;
  };

  Sender* find(link::Address from);
  Sender* place_for(std::uint8_t rank, std::int64_t now_us);

  std::array<Sender, 4> senders_{};
};

}  // namespace flotilla::app
