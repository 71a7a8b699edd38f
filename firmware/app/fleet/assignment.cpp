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
constexpr std::size_t kMost = FleetTable::kMost;
constexpr double kAstern_mps = 0.4;  // over the ground: any hull still keeps its course

struct Way {
  double x = 0, y = 0;  ///< cm
};

Way operator-(const Way& a, const Way& b) { return {a.x - b.x, a.y - b.y}; }
Way way_of(const FleetSlot& to, const FleetSlot& from = {}) {
  return {double(to[0]) - from[0], double(to[1]) - from[1]};
}
double length(const Way& d) { return std::sqrt(d.x * d.x + d.y * d.y); }

/// Who gets which of `count` places, so that the sum of `cost` is least.
class Matching {
 public:
  Matching(std::size_t count, const std::array<std::array<double, kMost>, kMost>& cost)
      : count_(count), cost_(cost) {
    row_of_.fill(count);
    for (std::size_t row = 0; row < count; ++row) add(row);
  }

  std::size_t row_of(std::size_t column) const { return row_of_[column]; }

 private:
  /// Gives `row` a column along the shortest path of exchanges.
  void add(std::size_t row) {
    std::array<double, kMost> far{};
    std::array<std::size_t, kMost> before{};
    std::array<bool, kMost> done{};
    far.fill(std::numeric_limits<double>::max());
    before.fill(count_);
    std::size_t last = count_;  // the column that the path has come to
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
  const std::array<std::array<double, kMost>, kMost>& cost_;
  std::array<std::size_t, kMost> row_of_{};
  std::array<double, kMost> of_row_{}, of_column_{};  // prices
};

/// Gives the places of the members at `ranks` to them anew.
void match(FleetTable& table, Now now, std::span<const std::size_t> ranks) {
  std::array<std::array<double, kMost>, kMost> cost{};
  std::array<FleetSlot, kMost> places{};
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

FleetTable matched(const FleetTable& wanted, Now now, bool all) {
  FleetTable table = wanted;
  std::array<std::size_t, kMost> ranks{};
  std::size_t count = 0;
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    const FleetMember& member = table.members[rank];
    if (all || (member.leader != 0 && !member.only_leads)) ranks[count++] = rank;
  }
  match(table, now, std::span(ranks).first(count));
  return table;
}

/// By how much two boats stay farther apart on their ways than 1.2 hulls, cm; the least.
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
      const double hulls_cm = 6.0 * (table.members[i].length_dm + table.members[j].length_dm);
      const Way nearest{before.x + share * d.x, before.y + share * d.y};
      least = std::min(least, length(nearest) - hulls_cm);
    }
  }
  return least;
}

/// How fast a place can move along (x, y), ahead and to starboard, if the boats sail at `pace`.
double place_mps(const FleetPace& pace, double x, double y) {
  const double most = 0.92 * (pace.most_mps > 0 ? double{pace.most_mps} : 1.5);
  const double u = std::clamp(double{pace.ahead_mps}, 0.0, most);
  const double root = std::sqrt(std::max(0.0, most * most - u * u * y * y));
  double w = root - u * x;
  if (x < 0) w = std::min(w, (u + kAstern_mps) / -x);
  return std::max(w, 0.1);
}

/// Until the last boat has reached its place, 0.1 s; ways are relative to the first one's.
std::uint16_t moves_ds(const FleetTable& table, Now now, const FleetPace& pace) {
  const double heading = table.turns ? 0.0 : double{pace.heading_rad};
  const double cos = std::cos(heading), sin = std::sin(heading);
  const Way of_root = now[0] ? way_of(table.members[0].slot_cm, *now[0]) : Way{};
  double most_s = 0;
  for (std::size_t rank = 1; rank < table.count; ++rank) {
    if (!now[rank]) continue;
    const Way d = way_of(table.members[rank].slot_cm, *now[rank]) - of_root;
    const double far_cm = length(d);
    if (far_cm < 1) continue;
    const double x = (cos * d.x + sin * d.y) / far_cm, y = (cos * d.y - sin * d.x) / far_cm;
    most_s = std::max(most_s, far_cm / 100 / place_mps(pace, x, y));
  }
  if (!(most_s > 0)) return 0;
  const double all_s = std::max(most_s, kMoveRamp_s) + kMoveRamp_s;
  return static_cast<std::uint16_t>(std::min(std::ceil(10 * all_s), 65'535.0));
}

}  // namespace

FleetTable assigned(const FleetTable& wanted, Now now, const FleetPace& pace) {
  FleetTable table = matched(wanted, now, false);
  if (const double room = room_cm(table, now); room < 0) {
    const FleetTable free = matched(wanted, now, true);
    if (room_cm(free, now) > room) table = free;
  }
  table.assigns = false;
  table.move_ds = moves_ds(table, now, pace);
  return table_of(message_of(table, 0));  // with its digest
}

}  // namespace flotilla::app
