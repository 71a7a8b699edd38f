// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <initializer_list>
#include <vector>

#include "app/guidance/tree_place.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::uint8_t kOwn = 3, kLeader = 2, kRoot = 100, kMaker = 1;

TreePath path_of(std::initializer_list<std::uint8_t> ids) {
  TreePath path{};
  std::ranges::copy(ids, path.begin());
  return path;
}

/// The message of a leader in a line, 3 m behind the maker.
link::FormationReference word(std::initializer_list<std::uint8_t> path = {kMaker, kRoot}) {
  link::FormationReference m{};
  m.root = kRoot;
  m.maker = kMaker;
  m.flags = link::mav::kReferenceFollowed;
  m.offset_n = {-3072, 0};
  m.path = path_of(path);
  return m;
}

TreePlace place(bool turns = false) {
  TreePlace place;
  place.configure({kOwn, kLeader, {-1024, 2048}, turns});
  return place;
}

TEST_CASE("a boat whose leader sends no place counts as directly behind the root") {
  const TreePlace p = place();
  CHECK_FALSE(p.branch(0));
  CHECK(p.offset(0)->n == convert::WireOffset{-1024, 2048});
  CHECK(p.depth(0) == 1);
  CHECK(p.path(0) == path_of({kLeader}));
  CHECK_FALSE(p.is_cycle(0));
}

TEST_CASE("behind a leader that sends its place, slots and paths add up") {
  TreePlace p = place();
  p.hear(word(), 0, 0);
  CHECK(p.branch(0) == Branch{kRoot, kMaker});
  CHECK(p.offset(0)->n == convert::WireOffset{-4096, 2048});
  CHECK(p.offset(0)->b == convert::WireOffset{});
  CHECK(p.leaders_offset(0).n == convert::WireOffset{-3072, 0});
  CHECK(p.depth(0) == 3);
  CHECK(p.path(0) == path_of({kLeader, kMaker, kRoot}));
}

TEST_CASE("offsets that turn with the root and offsets that do not are summed separately") {
  TreePlace p = place(true);
  p.hear(word(), 0, 0);
  CHECK(p.offset(0)->n == convert::WireOffset{-3072, 0});
  CHECK(p.offset(0)->b == convert::WireOffset{-1024, 2048});
  // A slot that does not turn, behind one that does, moves with it.
  TreePlace behind = place(false);
  auto m = word();
  m.offset_b = {-1024, 2048};
  behind.hear(m, 0, 0);
  CHECK(behind.offset(0)->n == convert::WireOffset{-4096, 2048});
  CHECK(behind.offset(0)->b == convert::WireOffset{-1024, 2048});
}

TEST_CASE("a turning slot behind a turning slot has no fixed offset from the root") {
  TreePlace p = place(true);
  auto m = word();
  m.offset_b = {-1024, 0};
  p.hear(m, 0, 0);
  CHECK_FALSE(p.branch(0));
  CHECK(p.offset(0)->b == convert::WireOffset{-1024, 2048});  // of the leader
  CHECK(p.depth(0) == 3);                                     // the tree is the same
}

TEST_CASE("a leader out of its slot is followed directly") {
  TreePlace p = place();
  auto m = word();
  m.flags = 0;
  p.hear(m, 0, 0);
  CHECK_FALSE(p.branch(0));
  CHECK(p.offset(0)->n == convert::WireOffset{-1024, 2048});
  CHECK(p.path(0) == path_of({kLeader, kMaker, kRoot}));
}

TEST_CASE("a leader's place is valid for three seconds, and not for another leader") {
  TreePlace p = place();
  p.hear(word(), 0, 0);
  CHECK(p.branch(3 * kSecond_us - 1));
  CHECK_FALSE(p.branch(3 * kSecond_us));
  CHECK(p.depth(3 * kSecond_us) == 1);
  p.hear(word(), 0, 0);
  p.configure({kOwn, 7, {}, false});
  CHECK_FALSE(p.branch(0));
  CHECK(p.path(0) == path_of({7}));
}

TEST_CASE("every boat in a cycle of any length detects it, and no path grows in it") {
  for (std::size_t boats = 2; boats <= 20; ++boats) {
    std::vector<TreePlace> ring(boats);
    const auto id = [&](std::size_t i) { return static_cast<std::uint8_t>(i % boats + 1); };
    for (std::size_t i = 0; i < boats; ++i) ring[i].configure({id(i), id(i + 1), {}, false});
    std::int64_t now_us = 0;
    for (std::size_t round = 0; round < 3 * boats; ++round, now_us += kSecond_us) {
      for (std::size_t i = 0; i < boats; ++i) {
        auto m = word({});
        m.maker = id(i + 1);
        m.path = ring[(i + 1) % boats].path(now_us);
        ring[i].hear(m, now_us, now_us);
      }
    }
    for (const TreePlace& p : ring) {
      CAPTURE(boats);
      CHECK(p.is_cycle(now_us));
      CHECK(p.depth(now_us) <= boats + 1);
      CHECK(length_of(p.path(now_us)) <= boats + 1);
    }
  }
}

TEST_CASE("messages in a new leader's first second, perhaps outdated, make no cycle") {
  TreePlace p = place();
  const auto behind_us = word({kMaker, kOwn});
  p.hear(behind_us, 0, 5 * kSecond_us);
  CHECK_FALSE(p.is_cycle(5 * kSecond_us));
  p.hear(behind_us, 0, 6 * kSecond_us - 1);
  CHECK_FALSE(p.is_cycle(6 * kSecond_us - 1));
  p.hear(behind_us, 0, 6 * kSecond_us);
  CHECK(p.is_cycle(6 * kSecond_us));
  p.hear(word(), 0, 6 * kSecond_us + 1);
  CHECK_FALSE(p.is_cycle(6 * kSecond_us + 1));
}

TEST_CASE("a branch whose reference the boat made itself is not used") {
  TreePlace p = place();
  auto m = word();
  m.maker = kOwn;
  p.hear(m, 0, 0);
  CHECK_FALSE(p.branch(0));
}

TEST_CASE("a boat behind a full path is too deep in the tree") {
  TreePlace p = place();
  auto m = word();
  for (std::size_t i = 0; i < m.path.size(); ++i) m.path[i] = static_cast<std::uint8_t>(10 + i);
  p.hear(m, 0, 0);
  CHECK(p.too_deep(0));
  CHECK(p.depth(0) == TreePath{}.size());
  m.path[m.path.size() - 2] = m.path[m.path.size() - 1] = 0;
  p.hear(m, 0, 0);
  CHECK_FALSE(p.too_deep(0));
  CHECK(length_of(p.path(0)) == TreePath{}.size() - 1);
}

TEST_CASE("a leader with outdated data is dropped, and used again only after some good seconds") {
  TreePlace p = place();
  const auto hear = [&](std::int64_t now_us, std::int64_t age_us) {
    p.hear(word(), now_us - age_us, now_us);
    return p.branch(now_us).has_value();
  };
  CHECK(hear(10 * kSecond_us, 2'900'000));
  CHECK_FALSE(hear(11 * kSecond_us, 3'100'000));
  CHECK_FALSE(hear(12 * kSecond_us, 2'500'000));  // less old, but still too old
  for (int s = 13; s < 16; ++s) CHECK_FALSE(hear(s * kSecond_us, 2'000'000));
  CHECK(hear(16 * kSecond_us, 2'000'000));
  CHECK(hear(17 * kSecond_us, 2'900'000));
}

}  // namespace
}  // namespace flotilla::app
