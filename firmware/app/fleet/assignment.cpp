// SPDX-License-Identifier: MIT
#include "app/fleet/assignment.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "app/fleet/move.hpp"

namespace flotilla::app {
namespace {

using Now = std::span<const std::optional<FleetSlot>>;
constexpr std::size_t kMax = FleetTable::kMax;
constexpr double kShortest_s = 10;  // time for a boat to turn round and back

struct Way {
  double x = 0, y = 0;  ///< cm
};

Way operator-(const Way& a, const Way& b) { return {a.x - b.x, a.y - b.y}; }
Way way_of(const FleetSlot& to, const FleetSlot& from = {}) {
  return {double(to[0]) - from[0], double(to[1]) - from[1]};
}
double length(const Way& d) { return std::sqrt(d.x * d.x + d.y * d.y); }

/// Assignment of `count` members to as many places with the least sum of `cost`.
class Matching {
 public:
  Matching(std::size_t count, const std::array<std::array<double, kMax>, kMax>& cost)
      : count_(count), cost_(cost) {
    row_of_.fill(count);
    for (std::size_t row = 0; row < count; ++row) add(row);
  }

  std::size_t row_of(std::size_t column) const { return row_of_[column]; }

 private:
  /// Gives `row` a column along the shortest path of exchanges.
  void add(std::size_t row) {
    std::array<double, kMax> far{};
    std::array<std::size_t, kMax> before{};
    std::array<bool, kMax> done{};
    far.fill(std::numeric_limits<double>::max());
    before.fill(count_);
    std::size_t last = count_;  // last column of the path
    double walked = 0;
    for (std::size_t at = row; at < count_; at = row_of_[last]) {
      std::size_t next = count_;
      for (std::size_t column = 0; column < count_; ++column) {
        if (done[column]) continue;
        const double more = walked + cost_[at][column] - of_row_[at] - of_column_[column];
        if (more < far[column]) far[column] = more, before[column] = last;
        if (next == count_ || far[column] < far[next]) next = column;
      }
      walked = far[next];
      done[next] = true;
      last = next;
    }
    of_row_[row] += walked;
    for (std::size_t column = 0; column < count_; ++column) {
      if (!done[column]) continue;
      of_column_[column] -= walked - far[column];
      if (row_of_[column] < count_) of_row_[row_of_[column]] += walked - far[column];
    }
    for (; last < count_; last = before[last]) {
      row_of_[last] = before[last] < count_ ? row_of_[before[last]] : row;
    }
  }

  std::size_t count_;
  const std::array<std::array<double, kMax>, kMax>& cost_;
  std::array<std::size_t, kMax> row_of_{};
  std::array<double, kMax> of_row_{}, of_column_{};  // prices
};

/// Reassigns the places of the members at `ranks` among them.
void match(FleetTable& table, Now now, std::span<const std::size_t> ranks) {
  std::array<std::array<double, kMax>, kMax> cost{};
  std::array<FleetSlot, kMax> places{};
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    places[i] = table.members[ranks[i]].slot_cm;
    for (std::size_t k = 0; k < ranks.size(); ++k) {
      if (!now[ranks[i]]) continue;
      const Way way = way_of(table.members[ranks[k]].slot_cm, *now[ranks[i]]);
      cost[i][k] = way.x * way.x + way.y * way.y;
    }
  }
  const Matching matching(ranks.size(), cost);
  for (std::size_t k = 0; k < ranks.size(); ++k) {
    table.members[ranks[matching.row_of(k)]].slot_cm = places[k];
  }
}

FleetTable matched(const FleetTable& requested, Now now, bool all) {
  FleetTable table = requested;
  std::array<std::size_t, kMax> ranks{};
  std::size_t count = 0;
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    const FleetMember& member = table.members[rank];
    if (all || (member.leader != 0 && !member.only_leads)) ranks[count++] = rank;
  }
  match(table, now, std::span(ranks).first(count));
  return table;
}

/// Least clearance between any two boats during the move, beyond two hull lengths, cm. The
/// separation filter delays boats that pass nearer.
double room_cm(const FleetTable& table, Now now) {
  double least = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < table.count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!now[i] || !now[j]) continue;
      const Way before = way_of(*now[i], *now[j]);
      const Way after = way_of(table.members[i].slot_cm, table.members[j].slot_cm);
      const Way d = after - before;
      const double square = d.x * d.x + d.y * d.y;
      const double along = -(before.x * d.x + before.y * d.y);
      const double share = square > 0 ? std::clamp(along / square, 0.0, 1.0) : 0.0;
      const double hulls_cm = 10.0 * (table.members[i].length_dm + table.members[j].length_dm);
      const Way nearest{before.x + share * d.x, before.y + share * d.y};
      least = std::min(least, length(nearest) - hulls_cm);
    }
  }
  return least;
}

/// Velocity over ground of a place, m/s, in the shape's axes. `place`: relative to the root's, cm.
Way velocity(bool turns, const Way& place, const FleetCourse& root) {
  const double u = root.ahead_mps, r = root.turn_radps;
  if (turns) return {u - r * place.y / 100, r * place.x / 100};
  return {u * std::cos(double{root.heading_rad}), u * std::sin(double{root.heading_rad})};
}

/// Duration of the path d, s, at full speed in a shape that moves with v.
double lasts_s(const Way& d, const Way& v, double most_mps) {
  const double far_cm = length(d);
  if (far_cm < 1) return 0;
  const double along = (v.x * d.x + v.y * d.y) / far_cm;
  const double spare = most_mps * most_mps - v.x * v.x - v.y * v.y;
  const double mps = std::sqrt(std::max(0.0, along * along + spare)) - along;
  return far_cm / 100 / std::max(mps, 0.1);
}

/// Duration of the slowest path relative to the root, s, if the root keeps this motion.
double slowest_s(const FleetTable& table, Now now, std::size_t root, const FleetCourse& course,
                 double most_mps) {
  const FleetSlot& root_to = table.members[root].slot_cm;
  const FleetSlot root_from = now[root].value_or(root_to);
  double slowest = 0;
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    if (!now[rank] || rank == root) continue;
    const Way from = way_of(*now[rank], root_from);
    const Way to = way_of(table.members[rank].slot_cm, root_to);
    for (const Way& place : {from, to}) {
      slowest =
          std::max(slowest, lasts_s(to - from, velocity(table.turns, place, course), most_mps));
    }
  }
  return slowest;
}

/// For each outlook sample: duration of the slowest path if the root keeps that motion, s.
class Slowest {
 public:
  Slowest(const FleetTable& table, Now now, std::size_t root, const FleetOutlook& outlook,
          double in_s)
      : in_s_(in_s), count_(outlook.count) {
    const double most_mps = 0.97 * (outlook.most_mps > 0 ? double{outlook.most_mps} : 1.5);
    for (std::size_t k = 0; k < count_; ++k) {
      at_s_[k] = slowest_s(table, now, root, outlook.at[k], most_mps);
      moves_ = moves_ || at_s_[k] > 0;
    }
  }

  bool moves() const { return moves_; }

  /// The longest of these durations between two times of the move; at least kShortest_s.
  double between(double from_s, double to_s) const {
    const double end = static_cast<double>(count_) - 1;
    const auto sample = [&](double number) {
      return at_s_.begin() + static_cast<std::ptrdiff_t>(std::min(number, end));
    };
    const auto first = sample(std::floor((in_s_ + from_s) / FleetOutlook::kEvery_s));
    const auto last = sample(std::ceil((in_s_ + to_s) / FleetOutlook::kEvery_s));
    return std::max(*std::max_element(first, last + 1), kShortest_s);
  }

 private:
  std::array<double, FleetOutlook::kMax> at_s_{};
  double in_s_;
  std::size_t count_;
  bool moves_ = false;
};

/// The quickest pace at which no place is ever too fast. A longer move spans more of the outlook,
/// which may need a slower pace still.
FleetPace quickest(const Slowest& slowest) {
  FleetPace best;
  const auto until_slow_enough = [](double all_s, auto needs_s) {
    for (double longer_s = needs_s(all_s); longer_s > all_s; longer_s = needs_s(all_s)) {
      all_s = longer_s;
    }
    return all_s;
  };
  best.all_s =
      until_slow_enough(0, [&](double all_s) { return slowest.between(0, all_s) + kMoveRamp_s; });
  for (std::size_t k = 1; k < FleetOutlook::kMax; ++k) {
    const double first_s = static_cast<double>(k) * FleetOutlook::kEvery_s;
    if (first_s < 1.5 * kMoveRamp_s) continue;
    const double exact =
        (first_s - kMoveRamp_s / 2) / slowest.between(0, first_s + kMoveRamp_s / 2);
    if (exact >= 1) break;
    const double share = std::floor(kShares * exact) / kShares;  // as it goes over the wire
    const double all_s = until_slow_enough(first_s + 1.5 * kMoveRamp_s, [&](double all) {
      return first_s + kMoveRamp_s / 2 +
             (1 - share) * slowest.between(first_s - kMoveRamp_s / 2, all);
    });
    if (all_s < best.all_s) best = {all_s, first_s, share};
  }
  return best;
}

std::uint16_t tenths(double s) {
  return static_cast<std::uint16_t>(std::min(std::ceil(10 * s), 65'535.0));
}

}  // namespace

FleetTable assigned(const FleetTable& requested, Now now, std::size_t root,
                    const FleetOutlook& outlook, double in_s) {
  FleetTable table = matched(requested, now, false);
  if (const double room = room_cm(table, now); room < 0) {
    const FleetTable free = matched(requested, now, true);
    if (room_cm(free, now) > room) table = free;
  }
  table.assigns = false;
  const Slowest slowest(table, now, root, outlook, in_s);
  const FleetPace pace = slowest.moves() ? quickest(slowest) : FleetPace{};
  table.move_ds = tenths(pace.all_s);
  table.first_ds = tenths(pace.first_s);
  table.first_share = static_cast<std::uint8_t>(std::lround(kShares * pace.first_share));
  return table_of(message_of(table, 0));  // with its digest
}

}  // namespace flotilla::app
