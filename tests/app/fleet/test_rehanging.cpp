// SPDX-License-Identifier: MIT
// The effect of the rule of succession on the tree, for every tree of up to five boats and every
// set of failed boats. LAW.md, "When the tree changes", relies on it.
#include <doctest/doctest.h>

#include <array>
#include <vector>

#include "app/fleet/succession.hpp"

namespace flotilla::app {
namespace {

constexpr std::size_t kMaxBoats = 5;
constexpr FleetSelf kSails{.fit = true, .drives = true};

struct Fleet {
  FleetTable table;
  std::array<Succession, kMaxBoats> rules;
  std::array<bool, kMaxBoats> alive{}, alone{};

  explicit Fleet(const FleetTable& of) : table(of) {
    for (std::size_t i = 0; i < table.count; ++i) {
      rules[i].begin(table);
      alive[i] = true;
    }
    alone[0] = true;  // the first one sails the plan
  }

  void step() {
    std::array<FleetPeer, kMaxBoats> peers{};
    for (std::size_t i = 0; i < table.count; ++i) {
      peers[i] = {alive[i], !alone[i], rules[i].leads(), table.epoch};
    }
    for (std::size_t i = 0; i < table.count; ++i) {
      if (!alive[i]) continue;
      FleetSelf self = kSails;
      self.rank = i;
      self.epoch = table.epoch;
      self.fit = !alone[i];
      self.alone = self.ordered = alone[i];
      const FleetOrder order = rules[i].step(table, self, std::span(peers).first(table.count));
      if (order == FleetOrder::kLead) alone[i] = true;
    }
  }

  /// Number of links from a boat up to the leader; more than the number of boats if there is no
  /// path.
  std::size_t depth(std::size_t boat) const {
    for (std::size_t links = 0; links <= table.count; ++links) {
      if (rules[boat].leads()) return links;
      const auto above = rules[boat].followed();
      if (!above || !alive[*above]) break;
      boat = *above;
    }
    return table.count + 1;
  }
};

/// All trees in which each boat follows one before it.
std::vector<FleetTable> trees(std::size_t boats) {
  std::vector<FleetTable> found{FleetTable{.epoch = 1, .count = 1}};
  found[0].members[0] = {.system = 1, .leader = 0, .can_lead = true, .length_dm = 10};
  for (std::uint8_t i = 1; i < boats; ++i) {
    std::vector<FleetTable> next;
    for (const FleetTable& tree : found) {
      for (std::uint8_t leader = 1; leader <= i; ++leader) {
        FleetTable grown = tree;
        grown.members[i] = {.system = static_cast<std::uint8_t>(i + 1),
                            .leader = leader,
                            .can_lead = true,
                            .length_dm = 10};
        ++grown.count;
        next.push_back(grown);
      }
    }
    found = std::move(next);
  }
  return found;
}

TEST_CASE("whichever boats fail, all others follow one leader, none deeper than before") {
  std::size_t judged = 0, hung = 0;
  for (std::size_t boats = 2; boats <= kMaxBoats; ++boats) {
    for (const FleetTable& tree : trees(boats)) {
      for (unsigned failed = 1; failed + 1 < 1U << boats; ++failed) {
        Fleet fleet(tree);
        fleet.step();
        fleet.step();
        std::array<std::size_t, kMaxBoats> before{};
        std::array<std::optional<std::size_t>, kMaxBoats> above{};
        for (std::size_t i = 0; i < boats; ++i) {
          before[i] = fleet.depth(i);
          above[i] = fleet.rules[i].followed();
          REQUIRE(before[i] < boats);
        }
        for (std::size_t i = 0; i < boats; ++i) fleet.alive[i] = (failed >> i & 1U) == 0;
        for (int tick = 0; tick < 4; ++tick) fleet.step();
        for (std::size_t i = 0; i < boats; ++i) {
          if (!fleet.alive[i]) continue;
          CHECK(fleet.depth(i) <= before[i]);
          if (fleet.rules[i].followed() != above[i]) ++hung;
          ++judged;
        }
      }
    }
  }
  CHECK(judged > 1900);
  CHECK(hung > 500);
}

}  // namespace
}  // namespace flotilla::app
