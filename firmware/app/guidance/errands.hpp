// SPDX-License-Identifier: MIT
// Where the boat sails in GUIDED, LOITER and RTL: an errand, or, where the straight way there leaves
// the fence, a wait while a way round is looked for, and then that way.
#pragma once

#include <string_view>
#include <utility>

#include "app/guidance/errand.hpp"
#include "app/guidance/fence.hpp"
#include "app/guidance/way_round.hpp"

namespace flotilla::app {

class Errands {
 public:
  void sail_to(const Target& target);

  /// The same, but waits at a place `meanwhile` if a way round has to be found.
  void sail_round(const Fence& fence, const convert::Position& here, const Target& target,
                  const Target& meanwhile, float margin_m);

  /// Once a tick: looks further for a way round. True if plan() has changed.
  [[nodiscard]] bool look_for_way(const Fence& fence);

  Plan plan() const { return errand_.plan(); }
  /// Where plan() ends.
  Target goal() const { return errand_.target(); }

  /// News of the way for the operator, once; empty: none.
  std::string_view take_news() { return std::exchange(news_, {}); }

 private:
  Errand errand_;
  WayRound way_round_;
  std::string_view news_{};
};

}  // namespace flotilla::app
