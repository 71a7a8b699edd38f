// SPDX-License-Identifier: MIT
// The errand of GUIDED, LOITER or RTL. If the straight path leaves the fence or comes too near to
// it, the boat waits while it searches for a path round the fence, and then sails this path.
#pragma once

#include <string_view>
#include <utility>

#include "app/plan/errand.hpp"
#include "app/plan/fence.hpp"
#include "app/plan/way_round.hpp"

namespace flotilla::app {

class Errands {
 public:
  void sail_to(const Target& target);

  /// The same, but waits at `meanwhile` while it searches for a path round the fence.
  void sail_round(const Fence& fence, const convert::Position& here, const Target& target,
                  const Target& meanwhile, float margin_m);

  /// If the straight path is permitted, sails to the target and returns true; otherwise leaves
  /// plan() as it is and searches for a path round the fence.
  bool look_again(const Fence& fence, const convert::Position& here, const Target& target,
                  float margin_m);
  /// No path was found, and the boat waits.
  bool is_lost() const { return way_round_.is_lost(); }
  /// The fence has changed since the boat began to wait for a path.
  bool is_outdated(const Fence& fence) const { return way_round_.is_outdated(fence); }

  /// Call once a tick: continues the search for a path. True if plan() has changed.
  [[nodiscard]] bool look_for_way(const Fence& fence);

  Plan plan() const { return errand_.plan(); }
  /// The end of plan().
  Target goal() const { return errand_.target(); }
  /// False while the boat waits for a path to that place.
  bool leads_to(const convert::GlobalPoint& place) const;
  void set_speed(float mps) { errand_.set_speed(mps); }

  /// A sentence about the search for the operator, once; empty: none.
  std::string_view take_news() { return std::exchange(news_, {}); }

 private:
  Errand errand_;
  WayRound way_round_;
  std::string_view news_{};
};

}  // namespace flotilla::app
