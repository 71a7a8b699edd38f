// SPDX-License-Identifier: MIT
// Where the boat stands in the tree of leaders, as its leader tells it.
#pragma once

#include <cstdint>
#include <optional>

#include "app/convert/convert_reference.hpp"

namespace flotilla::app {

/// The system ids above a boat, its leader first, 0 after the last.
using TreePath = decltype(link::FormationReference::path);

/// Whose motion is followed, and who made the reference of it.
struct Branch {
  std::uint8_t root = 0, maker = 0;
  bool operator==(const Branch&) const = default;
};

/// A slot seen from the root: the part that keeps its bearing, and that which turns with the root.
struct RootOffset {
  convert::WireOffset n{}, b{};
};

class TreePlace {
 public:
  struct Own {
    std::uint8_t system = 0, leader = 0;
    convert::WireOffset offset{};
    bool turns = false;  ///< FORM_FRAME 1
  };

  /// Another leader's word counts for nothing.
  void configure(const Own& own);

  /// The leader has spoken, of a motion that was true at `valid_us`.
  void hear(const link::FormationReference& message, std::int64_t valid_us, std::int64_t now_us);

  /// The branch that the leader sails in; nothing where it tells none, or one that is too old for a
  /// boat behind it, where it does not sail in its slot, or where our slot turns with a leader whose
  /// own slot turns: that has another heading than the root.
  std::optional<Branch> branch(std::int64_t now_us) const;

  /// Our slot and our leader's, seen from that branch's root, or from the leader where there is none;
  /// ours is nothing where it is farther than any fleet reaches.
  std::optional<RootOffset> offset(std::int64_t now_us) const;
  RootOffset leaders_offset(std::int64_t now_us) const;

  /// How many links of the tree lie above; as many as the path has room for: it may be more.
  std::size_t depth(std::int64_t now_us) const;
  TreePath path(std::int64_t now_us) const;
  bool too_deep(std::int64_t now_us) const;

  /// The leader follows this boat, if by others.
  bool is_cycle(std::int64_t now_us) const;

  const Own& own() const { return own_; }

 private:
  struct Word {
    std::int64_t heard_us = 0;
    Branch branch;
    RootOffset offset;
    TreePath path{};
    std::size_t length = 0;  ///< of the path
    bool cycle = false;      ///< we are on it
    bool followed = false;
  };

  const Word* word(std::int64_t now_us) const;

  Own own_;
  std::optional<Word> word_;
  bool leads_ = true;              // what the leader tells is young enough
  std::int64_t not_young_us_ = 0;  // when it last was too old to begin with
};

/// How many ids a path has.
std::size_t length_of(const TreePath& path);

}  // namespace flotilla::app
