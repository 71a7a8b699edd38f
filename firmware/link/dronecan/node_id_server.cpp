// SPDX-License-Identifier: MIT
#include "link/dronecan/node_id_server.hpp"

#include <algorithm>

namespace flotilla::link {
namespace {

// 126 and 127 are reserved for diagnostic tools.
constexpr unsigned kHighestNode = 125;

}  // namespace

bool NodeIdServer::is_free(unsigned node) const {
  return node >= 1 && node <= kHighestNode && !occupied_[node] &&
         std::ranges::none_of(table(), [&](const Entry& entry) { return entry.node == node; });
}

bool NodeIdServer::restore(const Entry& entry) {
  const bool known = std::ranges::any_of(
      table(), [&](const Entry& other) { return other.unique_id == entry.unique_id; });
  if (known || count_ == table_.size() || !is_free(entry.node)) return false;
  table_[count_++] = entry;
  return true;
}

std::uint8_t NodeIdServer::node_for(const UniqueId& unique_id, std::uint8_t preferred) {
  for (const Entry& entry : table()) {
    if (entry.unique_id == unique_id) return entry.node;
  }
  // From the preferred id upwards, then downwards; without a preference from the top.
  const unsigned desired = preferred == 0 ? kHighestNode : preferred;
  for (unsigned node = desired; node <= kHighestNode; ++node) {
    if (restore({unique_id, static_cast<std::uint8_t>(node)})) return table_[count_ - 1].node;
  }
  for (unsigned node = std::min(desired, kHighestNode); node >= 1; --node) {
    if (restore({unique_id, static_cast<std::uint8_t>(node)})) return table_[count_ - 1].node;
  }
  return 0;
}

std::optional<Allocation> NodeIdServer::answer(const Allocation& request, std::int64_t now_us) {
  // A node sends its unique id in three parts, 6 + 6 + 4 bytes; each answer repeats all so far.
  constexpr std::array<std::size_t, 3> kParts{6, 6, 4};
  if (request.first_part) {
    heard_size_ = 0;
  } else if (heard_size_ == 0 || now_us - heard_us_ > kFollowUp_us) {
    heard_size_ = 0;
    return std::nullopt;
  }
  if (request.size != kParts[heard_size_ / 6]) return std::nullopt;
  std::copy_n(request.unique_id.begin(), request.size,
              heard_.begin() + static_cast<std::ptrdiff_t>(heard_size_));
  heard_size_ += request.size;
  heard_us_ = now_us;
  Allocation out;
  out.size = static_cast<std::uint8_t>(heard_size_);
  out.unique_id = heard_;
  if (heard_size_ == heard_.size()) {
    heard_size_ = 0;
    out.node_id = node_for(heard_, request.node_id);
    if (out.node_id == 0) return std::nullopt;
  }
  return out;
}

}  // namespace flotilla::link
