// SPDX-License-Identifier: MIT
// The boat's place in the tree of leaders, from its leader's messages.
#pragma once

#include <cstdint>
#include <optional>

#include "app/convert/convert_reference.hpp"

namespace flotilla::app {

/// System ids above a boat, its leader first, 0 after the last.
using TreePath = decltype(link::FormationReference::path);

/// The vessel whose motion is followed, and the boat that made its reference.
struct Branch {
  std::uint8_t root = 0, maker = 0;
  bool operator==(const Branch&) const = default;
};

/// A slot relative to the root: n keeps its bearing, b turns with the root.
struct RootOffset {
  convert::WireOffset n{}, b{};
  friend bool operator==(const RootOffset&, const RootOffset&) = default;
};

class TreePlace {
 public:
  struct Own {
    std::uint8_t system = 0, leader = 0;
    convert::WireOffset offset{};
    bool turns = false;  ///< FORM_FRAME 1
  };

  /// A change of leader discards the old leader's message.
  void configure(const Own& own);

  /// A message from the leader, with a motion valid at `valid_us`.
  void hear(const link::FormationReference& message, std::int64_t valid_us, std::int64_t now_us);

  /// The branch that the leader sails in. nullopt if the leader announces none, does not follow it,
  /// or has a reference too old for a boat behind it; if we made the reference; or if our slot and
  /// the leader's both turn, because the leader's heading then differs from the root's.
  std::optional<Branch> branch(std::int64_t now_us) const;

  /// Our slot and our leader's, relative to that branch's root, or to the leader if there is no
  /// branch; ours is nullopt beyond 100 km.
  const std::optional<RootOffset>& offset(std::int64_t now_us) const;
  RootOffset leaders_offset(std::int64_t now_us) const;

  /// Number of links above us in the tree; saturates at the path's capacity.
  std::size_t depth(std::int64_t now_us) const;
  TreePath path(std::int64_t now_us) const;
  bool too_deep(std::int64_t now_us) const;

  /// The leader follows this boat, directly or through others. Not judged by the messages of a new
  /// leader's first second.
  bool is_cycle(std::int64_t now_us) const;

  const Own& own() const { return own_; }

 private:
  struct LeaderMessage {
    std::int64_t heard_us = 0;
    Branch branch;
    RootOffset offset;
    std::optional<RootOffset> ours;  ///< our slot, if we sail in that branch
    TreePath path{};
    std::size_t length = 0;  ///< of the path
    bool cycle = false;      ///< the path contains our id, see is_cycle()
    bool followed = false;
  };

  const LeaderMessage* message(std::int64_t now_us) const;
  const LeaderMessage* followed(std::int64_t now_us) const;
  std::optional<RootOffset> behind(const RootOffset& leaders) const;

  Own own_;
  std::optional<RootOffset> alone_{RootOffset{}};  // our slot relative to the leader
  std::optional<LeaderMessage> message_;
  bool leads_ = true;              // the leader's reference is young enough to follow
  std::uint32_t first_ms_ = 0;     // first message of this leader
  std::int64_t not_young_us_ = 0;  // last time it was older than kYoung_us
};

std::size_t length_of(const TreePath& path);

}  // namespace flotilla::app
