// SPDX-License-Identifier: MIT
#include "app/plan/way_round.hpp"

#include <algorithm>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

using core::Q16;

constexpr int kPerTick = 2;    // bends or legs that are judged
constexpr float kCut = 0.25F;  // share of the margin by which the vessel may cut a bend

Q16 distance(const Fence::Place& a, const Fence::Place& b) {
  return core::hypot(a.x - b.x, a.y - b.y);
}

}  // namespace

void WayRound::begin(const Fence& fence, const convert::Position& here, const Target& goal,
                     float margin_m) {
  lose();
  drawn_ = fence.drawn();
  const auto to = fence.on_map(goal.place), from = fence.on_map(here);
  if (!to || !from) return;
  margin_m_ = margin_m;
  keep_ = fence.kept(*to, *from, margin_m);
  if (!(Q16(0) < keep_)) return;
  goal_ = goal;
  nodes_[kGoal] = {*to, Q16(0), kGoal, true, false};
  nodes_[kBoat] = {.place = *from};
  count_ = kEnds;
  at_ = 0;
  phase_ = Phase::kCollect;
}

bool WayRound::straight_is_free(const Fence& fence) const {
  return fence.drawn() == drawn_ &&
         Q16(0) < fence.clearance(nodes_[kBoat].place, nodes_[kGoal].place);
}

/// Distance of a bend from the fence, so that the rounded bend keeps the margin.
WayRound::Length WayRound::off() const {
  return convert::scalar<Q16>((1 + kCut) * margin_m_) + kFenceRounding;
}

void WayRound::forward(const Fence& fence) {
  if (is_outdated(fence)) lose();
  for (int n = 0; n < kPerTick && is_searching(); ++n) {
    if (phase_ == Phase::kCollect) {
      collect(fence);
    } else {
      search(fence);
    }
  }
}

void WayRound::collect(const Fence& fence) {
  std::optional<Place> bend;
  while (!bend && at_ < fence.bends()) bend = fence.bend(at_++, off());
  if (!bend) {
    phase_ = Phase::kSearch;
    if (!close_next()) lose();
    return;
  }
  if (fence.clearance(*bend) + kFenceRounding < keep_) return;
  if (!(distance(*bend, nodes_[kBoat].place) < Q16(static_cast<int>(kErrandReach_m)))) return;
  if (count_ == nodes_.size()) return lose();
  nodes_[count_++] = {.place = *bend};
}

/// Closes the open node on the shortest way; false if none is open.
bool WayRound::close_next() {
  std::optional<std::size_t> best;
  Length least{};
  for (std::size_t i = 0; i < count_; ++i) {
    const Node& node = nodes_[i];
    if (!node.seen || node.closed) continue;
    const Length way = node.left + distance(node.place, nodes_[kBoat].place);
    if (best && !(way < least)) continue;
    best = i;
    least = way;
  }
  if (!best) return false;
  nodes_[*best].closed = true;
  from_ = static_cast<std::uint16_t>(*best);
  at_ = 0;
  return true;
}

bool WayRound::sees(const Fence& fence, const Node& a, const Node& b) const {
  const Length way = fence.clearance(a.place, b.place);
  return Q16(0) < way && !(way + kFenceRounding < keep_);
}

void WayRound::search(const Fence& fence) {
  if (from_ == kBoat) {
    std::size_t bends = 0;
    for (std::size_t i = nodes_[kBoat].next; i != kGoal; i = nodes_[i].next) ++bends;
    phase_ = bends > Errand::kBends ? Phase::kLost : Phase::kFound;
    return;
  }
  const Node& from = nodes_[from_];
  while (at_ < count_) {
    Node& node = nodes_[at_++];
    if (node.closed) continue;
    const Length left = from.left + distance(from.place, node.place);
    if (node.seen && !(left < node.left)) continue;
    if (!sees(fence, node, from)) return;
    node.left = left;
    node.next = static_cast<std::uint8_t>(from_);
    node.seen = true;
    return;
  }
  if (!close_next()) lose();
}

Errand WayRound::errand(const Fence& fence) const {
  std::array<convert::GlobalPoint, Errand::kBends> bends{};
  std::size_t count = 0;
  for (std::size_t i = nodes_[kBoat].next; i != kGoal; i = nodes_[i].next) {
    bends[count++] = fence.on_globe(nodes_[i].place);
  }
  Errand out;
  const float radius_m = std::max(kCut * margin_m_, 0.1F);
  out.sail_by(std::span(bends).first(count), radius_m, goal_);
  return out;
}

}  // namespace flotilla::app
