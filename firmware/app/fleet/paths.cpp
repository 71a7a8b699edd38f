// SPDX-License-Identifier: MIT
#include "app/fleet/paths.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace flotilla::app {
namespace {

// Interval of slot updates during a move; between updates the law uses their velocity.
constexpr std::int64_t kMove_us = 200'000;
constexpr auto kTurnAhead_us = static_cast<std::int64_t>(1e6 * kTurnAhead_s);
static_assert(kTurnAhead_us % kMove_us == 0);  // or slots would be updated twice as often
// Time for boats to turn back to the leader's course and settle in their new slots.
constexpr double kSettle_s = 15;

FleetSlot rounded(const std::array<double, 2>& cm) {
  return {static_cast<std::int16_t>(std::lround(cm[0])),
          static_cast<std::int16_t>(std::lround(cm[1]))};
}

}  // namespace

void FleetPaths::begin(const FleetTable& table, const FleetTable& before, std::int64_t begun_us) {
  const FleetPaths old = std::exchange(*this, {});
  pace_ = {0.1 * table.move_ds, 0.1 * table.first_ds, table.first_share / kShares};
  fades_s_ = old.fades_s(begun_us, pace_.all_s / 2);
  // Starts on the old move's time grid: places change only at grid instants.
  const std::int64_t off_us = before.count > 0 ? (begun_us - old.begun_us_) % kMove_us : 0;
  begun_us_ = begun_us - off_us;
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    const FleetMember& member = table.members[rank];
    from_cm_[rank] = to_cm_[rank] = member.slot_cm;
    const auto was = before.rank_of(member.system);
    if (!was || before.turns != table.turns) continue;
    const Place place = old.place(*was, begun_us);
    from_cm_[rank] = rest_of(place, fades_s_);
    carried_cmps_[rank] = rounded(place.cmps);
  }
}

/// Since the move began, in whole intervals.
double FleetPaths::since_s(std::int64_t now_us) const {
  const std::int64_t steps = std::max<std::int64_t>(now_us - begun_us_, 0) / kMove_us;
  return 1e-6 * static_cast<double>(steps * kMove_us);
}

bool FleetPaths::moves(std::int64_t now_us) const {
  return pace_.all_s > 0 && since_s(now_us) < pace_.all_s + kSettle_s;
}

/// Time to fade out the present speed, at most `most_s`, so that no place overshoots its goal.
double FleetPaths::fades_s(std::int64_t now_us, double most_s) const {
  return std::min({kMoveRamp_s, most_s, std::max(pace_.all_s - since_s(now_us), 0.0)});
}

FleetPaths::Place FleetPaths::place(std::size_t rank, std::int64_t now_us) const {
  const FleetMove at = move_at(since_s(now_us), pace_);
  const double fades = fades_s_ > 0 ? std::max(0.0, 1 - since_s(now_us) / fades_s_) : 0;
  Place place;
  for (std::size_t axis = 0; axis < place.cm.size(); ++axis) {
    const double from = from_cm_[rank][axis], v = carried_cmps_[rank][axis];
    const double way = to_cm_[rank][axis] - from;
    place.cm[axis] = from + at.share * way - v * fades_s_ / 2 * fades * fades;
    place.cmps[axis] = at.rate * way + v * fades;
    place.cmps2[axis] = at.rate_dot * way - (fades > 0 ? v / fades_s_ : 0);
  }
  return place;
}

/// Where a place comes to rest if its speed falls linearly to 0 in fades_s.
FleetSlot FleetPaths::rest_of(const Place& place, double fades_s) {
  return rounded(
      {place.cm[0] + place.cmps[0] * fades_s / 2, place.cm[1] + place.cmps[1] * fades_s / 2});
}

FleetSlot FleetPaths::rest(std::size_t rank, std::int64_t at_us) const {
  return rest_of(place(rank, at_us), fades_s(at_us, kMoveRamp_s));
}

SlotMotion FleetPaths::motion(std::size_t rank, std::size_t root, std::int64_t now_us) const {
  const Place here = place(rank, now_us), there = place(root, now_us);
  const std::int64_t soon_us = now_us + kTurnAhead_us;
  const Place soon = place(rank, soon_us), root_soon = place(root, soon_us);
  SlotMotion out{.moves = moves(now_us)};
  for (std::size_t axis = 0; axis < out.mps.size(); ++axis) {
    out.mps[axis] = static_cast<float>(0.01 * (here.cmps[axis] - there.cmps[axis]));
    out.mps2[axis] = static_cast<float>(0.01 * (here.cmps2[axis] - there.cmps2[axis]));
    out.soon_mps[axis] = static_cast<float>(0.01 * (soon.cmps[axis] - root_soon.cmps[axis]));
  }
  return out;
}

}  // namespace flotilla::app
