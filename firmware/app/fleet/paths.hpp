// SPDX-License-Identifier: MIT
// The members' paths: from their places in one shape to those in the next.
//
//   p(t) = a + s(t) (b − a) − ½ v φ f²     b: the new place; s: move.hpp
//   f = max(0, 1 − t / φ)                  v: the speed on the old path, which fades out in φ
//                                          a: where the old path then comes to rest
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "app/fleet/move.hpp"
#include "app/fleet/table.hpp"

namespace flotilla::app {

/// Members are named by their ranks in the table in force.
class FleetPaths {
 public:
  /// A member's place in the shape, and how it moves.
  struct Place {
    std::array<double, 2> cm{}, cmps{}, cmps2{};
  };

  /// Call when a table comes into force in place of `before`. The move counts from the table's own
  /// time, begun_us, so a boat that gets the table late joins the move at once.
  void begin(const FleetTable& table, const FleetTable& before, std::int64_t begun_us);

  Place place(std::size_t rank, std::int64_t now_us) const;

  /// Where the place comes to rest if its speed fades out from at_us on.
  FleetSlot rest(std::size_t rank, std::int64_t at_us) const;

  /// Motion of the place relative to the root's.
  SlotMotion motion(std::size_t rank, std::size_t root, std::int64_t now_us) const;

  /// Places move, or boats still settle in them.
  bool moves(std::int64_t now_us) const;

 private:
  double since_s(std::int64_t now_us) const;
  double fades_s(std::int64_t now_us, double most_s) const;
  static FleetSlot rest_of(const Place& place, double fades_s);

  // By rank: a, b and v.
  std::array<FleetSlot, FleetTable::kMax> from_cm_{}, to_cm_{}, carried_cmps_{};
  double fades_s_ = 0;
  FleetPace pace_;
  std::int64_t begun_us_ = 0;
};

}  // namespace flotilla::app
