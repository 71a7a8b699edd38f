// SPDX-License-Identifier: MIT
// Finds the shortest path to a place that respects the fence, with bends near the fence's corners.
// Searches a few legs per tick, from the place back to the boat.
//
//   g(goal) = 0      g(a) = min over b seen from a of g(b) + |a − b|
//   closed next: the bend with the least g(a) + |a − boat|
//
//  symbol  meaning                                               unit
//  g       length of the shortest way to the goal found so far   m
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "app/plan/errand.hpp"
#include "app/plan/fence.hpp"

namespace flotilla::app {

class WayRound {
 public:
  static constexpr std::size_t kMax = 12;  ///< permitted bends; with more, no way is found

  /// Begins a search. The path keeps margin_m from every boundary, or the clearance of one of its
  /// ends if that is less.
  void begin(const Fence& fence, const convert::Position& here, const Target& goal, float margin_m);
  void stop() { phase_ = Phase::kOver; }

  /// Searches a few legs further.
  void forward(const Fence& fence);
  bool is_searching() const { return phase_ == Phase::kCollect || phase_ == Phase::kSearch; }
  bool found() const { return phase_ == Phase::kFound; }
  /// There is no path, or the search has failed.
  bool is_lost() const { return phase_ == Phase::kLost; }
  /// The fence has changed since the search began.
  bool is_outdated(const Fence& fence) const {
    return (is_searching() || is_lost()) && fence.drawn() != drawn_;
  }
  const Target& goal() const { return goal_; }

  /// Whether the straight path to the goal stays inside the fence, however near to a boundary.
  bool straight_is_free(const Fence& fence) const;

  /// If found: the errand that leads there.
  Errand errand(const Fence& fence) const;

 private:
  enum class Phase : std::uint8_t { kOver, kCollect, kSearch, kFound, kLost };
  using Length = Fence::Length;
  using Place = Fence::Place;

  struct Node {
    Place place{};
    Length left{};          // g
    std::uint8_t next = 0;  // on the way to the goal
    bool seen = false, closed = false;
  };
  static constexpr std::size_t kGoal = 0, kBoat = 1, kEnds = 2;

  void lose() { phase_ = Phase::kLost; }
  void collect(const Fence& fence);
  void search(const Fence& fence);
  bool close_next();
  bool sees(const Fence& fence, const Node& a, const Node& b) const;
  Length off() const;

  Phase phase_ = Phase::kOver;
  Target goal_{};
  float margin_m_ = 0;
  Length keep_{};  // from the boundaries
  std::array<Node, kEnds + kMax> nodes_{};
  std::uint16_t count_ = 0;
  std::uint16_t from_ = 0, at_ = 0;  // the node closed last; the next bend or node to look at
  std::uint32_t drawn_ = 0;          // the map that the places are on
};

}  // namespace flotilla::app
