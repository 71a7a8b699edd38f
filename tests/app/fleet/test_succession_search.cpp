// SPDX-License-Identifier: MIT
// Every history of four boats under the shipped rule of succession. The radio may lose, repeat and
// delay any message; two boats fail; the radio splits once; there are three tables, and the last
// one stops all boats. Time is left out: a member may count as silent at any moment, so the
// histories include every timing of the radio.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <deque>
#include <limits>
#include <string_view>
#include <vector>

#include "app/fleet/ledger.hpp"
#include "app/fleet/succession.hpp"
#include "app/fleet/tables.hpp"

namespace flotilla::app {
namespace {

constexpr std::size_t kMaxBoats = 4;
constexpr std::uint16_t kStopEpoch = 3;

enum class Mode : std::uint8_t { kCrashed, kHold, kFollows, kAlone };

/// The contents of a boat's beacon.
struct Word {
  bool fit = false, leads = false;
  std::uint16_t epoch = 1;
  std::uint8_t hears = FleetTable::kMax;
  bool behind = false;
  bool operator==(const Word&) const = default;
};

struct Vessel {
  Mode mode = Mode::kFollows;
  bool reports = true;  ///< the leader that it hears
  std::uint16_t epoch = 1;
  Succession rule;
  std::array<FleetPeer, kMaxBoats> peers{};
  std::array<Word, 2> said{};  ///< its last two beacons: both may still arrive
};

struct Node {
  std::array<Vessel, kMaxBoats> boats;
  unsigned failures = 0, deafs = 0;
  unsigned split = 0;  ///< boats on one side, a bit each; 0: everybody hears everybody
  bool was_split = false;
  std::uint16_t issued = 1;  ///< epoch of the operator's last table
};

/// Mistakes that the search must find.
enum class Bug { kNone, kNeverYields, kTakesOldTables, kLeaderIgnoresStop, kNeverSilent };

struct Limits {
  std::size_t boats = kMaxBoats;
  unsigned failures = 2, deafs = 2;
  bool splits = true;
  bool reports = true;                         ///< boats report the leader that they hear
  std::uint16_t first = 1, last = kStopEpoch;  ///< epochs
  std::size_t states = std::numeric_limits<std::size_t>::max();  ///< breadth first, then cut off
};

const FleetTable& table_at(std::uint16_t epoch) {
  static const std::array<FleetTable, 3> kTables = [] {
    std::array<FleetTable, 3> out{testing::table_of_four(1), testing::table_of_four(2),
                                  testing::table_of_four(3, true)};
    out[1].members[2].leader = 1;
    return out;
  }();
  return kTables[epoch - 1U];
}

bool connected(const Node& n, std::size_t a, std::size_t b) {
  return (n.split >> a & 1U) == (n.split >> b & 1U);
}

Word word_of(const Vessel& v, std::size_t rank) {
  const auto heard = v.rule.heard_leader(table_at(v.epoch), rank, v.epoch, v.peers);
  const auto hears = v.reports ? heard : std::nullopt;
  return {v.mode == Mode::kFollows, v.mode == Mode::kAlone && v.rule.leads(), v.epoch,
          static_cast<std::uint8_t>(hears.value_or(FleetTable::kMax)),
          hears && v.rule.followed() == hears};
}

/// Steps a boat until it has carried out its rule's orders, then sends its beacon.
void settle(Vessel& v, std::size_t rank, Bug bug) {
  if (v.mode == Mode::kCrashed) return;
  for (bool again = true; again;) {
    const Mode was = v.mode;
    auto peers = v.peers;
    if (bug == Bug::kNeverYields && v.rule.leads()) {
      for (FleetPeer& peer : peers) peer.leads = false;
    }
    const bool alone = v.mode == Mode::kAlone;
    const FleetSelf self{.rank = rank,
                         .epoch = v.epoch,
                         .fit = v.mode == Mode::kFollows,
                         .drives = v.mode != Mode::kHold,
                         .alone = alone,
                         .ordered = alone};
    switch (v.rule.step(table_at(v.epoch), self, peers)) {
      case FleetOrder::kNone:
        break;
      case FleetOrder::kLead:
        v.mode = Mode::kAlone;
        break;
      case FleetOrder::kFollow:
        v.mode = Mode::kFollows;
        break;
      case FleetOrder::kStop:
        if (bug != Bug::kLeaderIgnoresStop || v.mode != Mode::kAlone) v.mode = Mode::kHold;
        break;
    }
    again = v.mode != was;
  }
  const Word now = word_of(v, rank);
  if (now != v.said[0]) v.said = {now, v.said[0]};
}

void hear(Node& n, std::size_t who, std::size_t from, std::size_t word, Bug bug) {
  const Word& said = n.boats[from].said[word];
  FleetPeer& peer = n.boats[who].peers[from];
  if (peer.heard && Word{peer.fit, peer.leads, peer.epoch, peer.hears, peer.behind} == said) return;
  peer = {true, said.fit, said.leads, said.epoch, said.hears, said.behind};
  settle(n.boats[who], who, bug);
}

/// A boat gets the table of that epoch.
void take(Node& n, std::size_t who, std::uint16_t epoch, Bug bug) {
  Vessel& v = n.boats[who];
  const bool newer = is_newer(epoch, 0, FleetTable{.epoch = v.epoch});
  if (v.mode == Mode::kCrashed || (bug != Bug::kTakesOldTables ? !newer : epoch == v.epoch)) return;
  v.rule.begin(table_at(epoch));
  v.epoch = epoch;
  settle(v, who, bug);
}

Node start(const Limits& limits) {
  const std::size_t boats = limits.boats;
  Node n;
  n.issued = limits.first;
  for (std::size_t i = boats; i < kMaxBoats; ++i) n.boats[i].mode = Mode::kCrashed;
  n.boats[0].mode = Mode::kAlone;
  for (std::size_t i = 0; i < boats; ++i) {
    Vessel& v = n.boats[i];
    v.epoch = limits.first;
    v.reports = limits.reports;
    for (std::size_t j = 0; j < boats; ++j) v.peers[j] = {true, j != 0, j == 0, v.epoch};
    v.rule.begin(table_at(v.epoch));
    // The operator has put boat 1 into AUTO.
    v.rule.step(table_at(v.epoch), {i, v.epoch, i != 0, true, i == 0, i == 0, false}, v.peers);
    v.said = {word_of(v, i), word_of(v, i)};
  }
  return n;
}

/// The events that may happen next, one at a time.
template <class F>
void events(const Node& n, const Limits& limits, Bug bug, F f) {
  const auto with = [&](auto change) {
    Node next = n;
    change(next);
    f(next);
  };
  for (std::size_t i = 0; i < limits.boats; ++i) {
    if (n.boats[i].mode == Mode::kCrashed) continue;
    if (n.failures < limits.failures) {
      for (const Mode end : {Mode::kCrashed, Mode::kHold}) {
        if (n.boats[i].mode == end) continue;
        with([&](Node& next) {
          ++next.failures;
          next.boats[i].mode = end;
          settle(next.boats[i], i, bug);
        });
      }
    }
    for (std::size_t j = 0; j < limits.boats; ++j) {
      if (i == j) continue;
      if (connected(n, i, j)) {
        for (const std::size_t word : {0U, 1U}) {
          with([&](Node& next) { hear(next, i, j, word, bug); });
        }
        with([&](Node& next) { take(next, i, n.boats[j].epoch, bug); });
      }
      if (!n.boats[i].peers[j].heard || bug == Bug::kNeverSilent) continue;
      const bool cut_off = n.boats[j].mode == Mode::kCrashed || !connected(n, i, j);
      if (!cut_off && n.deafs == limits.deafs) continue;
      with([&](Node& next) {
        if (!cut_off) ++next.deafs;
        next.boats[i].peers[j] = {};
        settle(next.boats[i], i, bug);
      });
    }
    if (n.issued < limits.last) {
      with([&](Node& next) { take(next, i, ++next.issued, bug); });
    }
  }
  if (n.split != 0) with([](Node& next) { next.split = 0; });
  if (n.was_split || !limits.splits) return;
  for (const unsigned side : {0b0001U, 0b0010U, 0b0011U, 0b0101U, 0b1001U}) {
    with([&](Node& next) {
      next.split = side;
      next.was_split = true;
    });
  }
}

/// A quiet radio for a while: each boat hears all boats that it can, and gets every table.
Node closing(Node n, Bug bug) {
  for (int round = 0; round < 8; ++round) {
    for (std::size_t i = 0; i < kMaxBoats; ++i) {
      for (std::size_t j = 0; j < kMaxBoats; ++j) {
        if (i == j || n.boats[i].mode == Mode::kCrashed) continue;
        if (n.boats[j].mode != Mode::kCrashed && connected(n, i, j)) {
          take(n, i, n.boats[j].epoch, bug);
          hear(n, i, j, 0, bug);
        } else if (bug != Bug::kNeverSilent) {
          n.boats[i].peers[j] = {};
          settle(n.boats[i], i, bug);
        }
      }
    }
  }
  return n;
}

/// Violations found in the states searched, a counter each.
struct Broken {
  std::size_t two_leaders = 0, not_the_best = 0, sails_after_stop = 0, older_table = 0;
  std::size_t parts_differ = 0, leaders_in_part = 0, wrong_leader = 0, tree_open = 0, stop_lost = 0;

  std::size_t all() const {
    return two_leaders + not_the_best + sails_after_stop + older_table + parts_differ +
           leaders_in_part + wrong_leader + tree_open + stop_lost;
  }

  /// In each state: a boat obeys one leader, the best that it knows; a stopped boat is at rest.
  void look(const Node& n) {
    for (std::size_t i = 0; i < kMaxBoats; ++i) {
      const Vessel& v = n.boats[i];
      if (v.mode == Mode::kCrashed) continue;
      const bool leads = v.rule.leads();
      two_leaders += leads && v.rule.followed().has_value();
      two_leaders += v.rule.followed() == i;
      sails_after_stop += v.epoch == kStopEpoch && v.mode != Mode::kHold;
      for (std::size_t j = 0; j < kMaxBoats; ++j) {
        const FleetPeer& peer = v.peers[j];
        if (j == i || !peer.heard || !peer.leads) continue;
        const std::size_t chosen = v.rule.leader();
        if (chosen == Succession::kNobody) {
          ++not_the_best;
          continue;
        }
        const std::uint16_t epoch = chosen == i ? v.epoch : v.peers[chosen].epoch;
        not_the_best += peer.epoch > epoch || (peer.epoch == epoch && j < chosen);
      }
    }
  }

  void look_between(const Node& before, const Node& after) {
    for (std::size_t i = 0; i < kMaxBoats; ++i) {
      older_table += after.boats[i].epoch < before.boats[i].epoch;
    }
  }

  /// After a quiet while: in each part one table, one leader, one tree; no stop is lost.
  void look_closed(const Node& n) {
    for (std::size_t i = 0; i < kMaxBoats; ++i) {
      const Vessel& v = n.boats[i];
      if (v.mode == Mode::kCrashed) continue;
      std::size_t leaders = 0, sailing = 0, leader = kMaxBoats;
      for (std::size_t j = 0; j < kMaxBoats; ++j) {
        const Vessel& other = n.boats[j];
        if (other.mode == Mode::kCrashed || !connected(n, i, j)) continue;
        parts_differ += other.epoch != v.epoch;
        stop_lost += v.epoch == kStopEpoch && other.mode != Mode::kHold;
        sailing += other.mode != Mode::kHold;
        if (!other.rule.leads()) continue;
        ++leaders;
        leader = j;
      }
      leaders_in_part += leaders != (sailing > 0 ? 1 : 0);
      if (v.mode == Mode::kHold || leaders != 1) continue;
      wrong_leader += v.rule.leader() != leader;
      std::size_t at = i, steps = 0;
      while (at != leader && n.boats[at].rule.followed() && steps++ < kMaxBoats) {
        at = *n.boats[at].rule.followed();
        if (n.boats[at].mode == Mode::kHold || !connected(n, i, at)) break;
      }
      tree_open += at != leader;
    }
  }
};

struct Print {
  std::uint64_t a = 0x9E37'79B9'7F4A'7C15, b = 0xC2B2'AE3D'27D4'EB4F;
  void add(std::uint64_t word) {
    a = std::rotl((a ^ word) * 0x9FB2'1C65'1E98'DF25, 29);
    b = std::rotl((b + word) * 0xD6E8'FEB8'6659'FD93, 37) ^ a;
  }
};

/// 128 bits: among 10⁸ states the chance that two share one is below 10⁻²².
std::array<std::uint64_t, 2> print_of(const Node& n) {
  Print print;
  for (const Vessel& v : n.boats) {
    print.add(v.rule.code());
    std::uint64_t rest = static_cast<std::uint64_t>(v.mode) << 2U | v.epoch;
    const auto add = [&](bool heard, const Word& w) {
      rest = rest << 9U | std::min<unsigned>(w.hears, 7) << 6U | (w.behind ? 32U : 0U) |
             (heard ? 16U : 0U) | (w.fit ? 8U : 0U) | (w.leads ? 4U : 0U) | w.epoch;
    };
    for (const FleetPeer& p : v.peers) add(p.heard, {p.fit, p.leads, p.epoch, p.hears, p.behind});
    for (const Word& w : v.said) add(true, w);
    print.add(rest);
  }
  print.add((n.failures * 8ULL + n.deafs) << 16U | n.split << 8U | std::uint64_t{n.issued} << 1U |
            (n.was_split ? 1U : 0U));
  return {print.a, print.b};
}

/// A set of prints, open addressing.
class Seen {
 public:
  bool insert(const std::array<std::uint64_t, 2>& print) {
    if (2 * count_ >= slots_.size()) grow();
    const bool added = put(slots_, print);
    count_ += added ? 1 : 0;
    return added;
  }
  std::size_t size() const { return count_; }

 private:
  using Slots = std::vector<std::array<std::uint64_t, 2>>;
  static bool put(Slots& slots, const std::array<std::uint64_t, 2>& print) {
    std::size_t at = print[0] & (slots.size() - 1);
    while (slots[at] != std::array<std::uint64_t, 2>{}) {
      if (slots[at] == print) return false;
      at = (at + 1) & (slots.size() - 1);
    }
    slots[at] = print;
    return true;
  }
  void grow() {
    Slots next(slots_.size() * 2);
    for (const auto& print : slots_) {
      if (print != std::array<std::uint64_t, 2>{}) put(next, print);
    }
    slots_.swap(next);
  }
  Slots slots_ = Slots(1U << 16U);
  std::size_t count_ = 0;
};

struct Found {
  std::size_t states = 0;
  bool whole = false;  ///< no state was left out
  Broken broken;
};

/// Searches all states, those nearest to the start first, and ends at the first violation.
Found search(const Limits& limits, Bug bug) {
  Found found;
  Seen seen;
  std::deque<Node> open;
  const auto visit = [&](const Node& n) {
    if (!seen.insert(print_of(n))) return;
    open.push_back(n);
    found.broken.look(n);
    found.broken.look_closed(closing(n, bug));
  };
  visit(start(limits));
  while (!open.empty() && seen.size() < limits.states && found.broken.all() == 0) {
    const Node n = open.front();
    open.pop_front();
    events(n, limits, bug, [&](const Node& next) {
      found.broken.look_between(n, next);
      visit(next);
    });
  }
  found.states = seen.size();
  found.whole = open.empty();
  return found;
}

/// FLOTILLA_SEARCH=wide takes some five minutes and 9 GB in the release build.
bool is_wide() {
  const char* wish = std::getenv("FLOTILLA_SEARCH");
  return wish != nullptr && std::string_view(wish) == "wide";
}

void check(const Limits& limits) {
  const Found found = search(limits, Bug::kNone);
  const std::string_view which = found.whole ? "all" : "the nearest";
  const std::string_view split = limits.splits ? "a" : "no";
  const std::string_view told = limits.reports ? "" : ", no reports of a leader";
  MESSAGE(which, " ", found.states, " states: ", limits.boats, " boats, ", limits.failures,
          " failures, ", limits.deafs, " false silences, ", split, " split, ",
          limits.last - limits.first + 1, " tables", told);
  CHECK(found.broken.two_leaders == 0);
  CHECK(found.broken.not_the_best == 0);
  CHECK(found.broken.sails_after_stop == 0);
  CHECK(found.broken.older_table == 0);
  CHECK(found.broken.parts_differ == 0);
  CHECK(found.broken.leaders_in_part == 0);
  CHECK(found.broken.wrong_leader == 0);
  CHECK(found.broken.tree_open == 0);
  CHECK(found.broken.stop_lost == 0);
}

TEST_CASE("no sequence of boat and radio failures leads to two leaders, or loses a stop") {
  check({.failures = 2, .deafs = 0, .splits = false, .reports = false, .last = 1});
  check({.boats = 3, .failures = 1, .deafs = 0, .reports = false, .last = 1});
  check({.boats = 3, .failures = 1, .deafs = 0, .splits = false, .last = 1, .states = 100'000});
  check({.boats = 3, .failures = 0, .deafs = 0, .splits = false, .first = 2});
  check({.states = is_wide() ? 20'000'000U : 20'000U});
  if (!is_wide()) return;
  check({.boats = 3, .failures = 2, .deafs = 0, .last = 1});
  check({.boats = 3, .failures = 1, .deafs = 1, .last = 1});
  check({.boats = 3, .failures = 1, .deafs = 0, .reports = false, .first = 2});
  check({.boats = 3, .failures = 1, .deafs = 0, .splits = false, .first = 2});
  check({.failures = 1, .deafs = 0, .splits = false, .last = 1});
  check({.failures = 1, .deafs = 0, .reports = false, .last = 1});
}

TEST_CASE("the search finds mistakes that were built into the rule on purpose") {
  for (const Bug bug :
       {Bug::kNeverYields, Bug::kTakesOldTables, Bug::kLeaderIgnoresStop, Bug::kNeverSilent}) {
    CAPTURE(static_cast<int>(bug));
    CHECK(search({.failures = 1, .deafs = 1, .states = 20'000}, bug).broken.all() > 0);
  }
}

}  // namespace
}  // namespace flotilla::app
