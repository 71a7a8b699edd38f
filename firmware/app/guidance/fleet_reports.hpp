// SPDX-License-Identifier: MIT
// Reports of the tree's other boats: whether a follower has fallen out of its slot, and whether the
// own leader returns.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "link/mavlink/messages.hpp"

namespace flotilla::app {

class FleetReports {
 public:
  /// wait_us: the longest wait for one boat, and for several that are late in turn. Time that the
  /// boat then spends in its slot, or the fleet without late boats, permits a further wait of the
  /// same length, so that boats that repeatedly leave their slots cannot stop the fleet endlessly.
  void configure(std::uint8_t own_system, std::uint8_t leader, std::int64_t wait_us);

  void hear(const link::Received& received, std::int64_t now_us);

  /// Call when a plan begins, and in every tick in which the plan waits for nobody: afterwards no
  /// wait is used up.
  void forget_waits(std::int64_t now_us);

  /// Call in each tick in which the plan may wait: counts the time. Returns the system id of a
  /// follower that was in its slot, reports that it is out of it, and has not used up its wait;
  /// nothing once the whole wait is used up.
  std::optional<std::uint8_t> late(std::int64_t now_us);

  /// The leader reports that it is armed and in RTL, three times in a row: one report may be late.
  bool leader_returns(std::int64_t now_us) const;

 private:
  struct Member {
    std::uint8_t system = 0;  ///< 0: a free entry
    std::uint8_t root = 0;    ///< of the formation that it follows
    bool was_in = false;      ///< has been in its slot behind that root, or behind its successor
    bool out = false;         ///< follows us, and is out of its slot now
    std::uint32_t waited_us = 0;  ///< wait used up at since_us
    std::int64_t heard_us = 0;
    std::int64_t since_us = 0;  ///< of `out`

    std::int64_t waited(std::int64_t now_us) const;
    void note(bool is_out, std::int64_t now_us, std::int64_t most_us);
  };

  Member* find(std::uint8_t system);
  void take_member(std::uint8_t system, const link::FormationReference& told, std::int64_t now_us);

  std::uint8_t own_ = 0, leader_ = 0;
  std::uint8_t root_ = 0;     // of the formation that this boat followed last
  std::uint8_t returns_ = 0;  // the leader's reports of RTL in a row, at most kReturns
  std::int64_t wait_us_ = 0;
  std::int64_t return_us_ = 0;  // the last one
  std::array<Member, 24> members_{};
  std::size_t used_ = 0;  // entries from here on are free
  Member fleet_;          // all together: out while any of them is late
};

}  // namespace flotilla::app
