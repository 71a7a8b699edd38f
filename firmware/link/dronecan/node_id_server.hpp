// SPDX-License-Identifier: MIT
// Allocates ids to DroneCAN nodes that have none, such as ESCs as they are shipped.
// Source: DroneCAN specification, chapter 6 "Dynamic node ID allocation", a single allocator.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <span>

#include "link/dronecan/messages.hpp"

namespace flotilla::link {

/// The allocator and its table. A returning node gets its previous id.
class NodeIdServer {
 public:
  using UniqueId = std::array<std::uint8_t, 16>;
  struct Entry {
    UniqueId unique_id{};
    std::uint8_t node = 0;
  };

  explicit NodeIdServer(std::uint8_t own_node) { occupied(own_node); }

  /// Marks an id as in use on the bus, whoever allocated it.
  void occupied(std::uint8_t node) { occupied_[node & 0x7FU] = true; }

  /// The answer to an anonymous node's request; nullopt if it is out of turn or the table is full.
  std::optional<Allocation> answer(const Allocation& request, std::int64_t now_us);

  std::span<const Entry> table() const { return {table_.data(), count_}; }

  /// Restores an entry of an earlier run; false if impossible (table full, id taken or unusable).
  bool restore(const Entry& entry);

 private:
  static constexpr std::int64_t kFollowUp_us = 500'000;

  std::uint8_t node_for(const UniqueId& unique_id, std::uint8_t preferred);
  bool is_free(unsigned node) const;

  std::bitset<128> occupied_{};
  std::array<Entry, 32> table_{};
  std::size_t count_ = 0;
  UniqueId heard_{};
  std::size_t heard_size_ = 0;
  std::int64_t heard_us_ = 0;
};

}  // namespace flotilla::link
