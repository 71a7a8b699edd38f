// SPDX-License-Identifier: MIT
#include "app/guidance/tree_place.hpp"

#include <algorithm>
#include <cstring>

namespace flotilla::app {
namespace {

// A leader silent for this long has lost its reference, or runs other software.
constexpr std::int64_t kLeaderSilent_us = 3'000'000;
// After a fleet rearranges its tree, late messages of a new leader may still say that it follows
// this boat. In the first second they do not count.
constexpr std::uint32_t kAttaches_ms = 1000;
// A boat whose leader's reference is older than kOld_us starts its own branch. It rejoins only
// after kSteady_us of references younger than kYoung_us, so that a boat deep in the tree, on a bad
// radio, does not alternate between the branches.
constexpr std::int64_t kOld_us = 3'000'000, kYoung_us = 2'100'000, kSteady_us = 3'000'000;

}  // namespace

std::size_t length_of(const TreePath& path) {
  return static_cast<std::size_t>(std::ranges::find(path, 0) - path.begin());
}

void TreePlace::configure(const Own& own) {
  if (own.leader != own_.leader || own.system != own_.system) {
    message_.reset();
    leads_ = true;
  }
  own_ = own;
  alone_ = behind({});
  if (message_) message_->ours = behind(message_->offset);
}

/// Our slot relative to the root, from our leader's.
std::optional<RootOffset> TreePlace::behind(const RootOffset& leaders) const {
  const auto n = convert::sum_of(leaders.n, own_.turns ? convert::WireOffset{} : own_.offset);
  const auto b = convert::sum_of(leaders.b, own_.turns ? own_.offset : convert::WireOffset{});
  if (!n || !b) return std::nullopt;
  return RootOffset{*n, *b};
}

void TreePlace::hear(const link::FormationReference& m, std::int64_t valid_us,
                     std::int64_t now_us) {
  const bool followed = (m.flags & link::mav::kReferenceFollowed) != 0;
  const auto now_ms = static_cast<std::uint32_t>(now_us / 1000);
  if (!message_) first_ms_ = now_ms;
  const bool cycle = now_ms - first_ms_ >= kAttaches_ms &&
                     std::memchr(m.path.data(), own_.system, m.path.size()) != nullptr;
  const RootOffset offset{m.offset_n, m.offset_b};
  const auto ours = message_ && message_->offset == offset ? message_->ours : behind(offset);
  message_.emplace(now_us, Branch{m.root, m.maker}, offset, ours, m.path, length_of(m.path), cycle,
                   followed);
  const std::int64_t age_us = now_us - valid_us;
  if (age_us > kOld_us) leads_ = false;
  if (age_us > kYoung_us) not_young_us_ = now_us;
  leads_ = leads_ || now_us - not_young_us_ > kSteady_us;
}

const TreePlace::LeaderMessage* TreePlace::message(std::int64_t now_us) const {
  return message_ && now_us - message_->heard_us < kLeaderSilent_us ? &*message_ : nullptr;
}

/// The leader's recent message, if we sail in its branch.
const TreePlace::LeaderMessage* TreePlace::followed(std::int64_t now_us) const {
  const LeaderMessage* told = message(now_us);
  if (told == nullptr || !leads_ || !told->followed || told->branch.maker == own_.system)
    return nullptr;
  if (own_.turns && told->offset.b != convert::WireOffset{}) return nullptr;
  return told;
}

std::optional<Branch> TreePlace::branch(std::int64_t now_us) const {
  const LeaderMessage* told = followed(now_us);
  return told != nullptr ? std::optional(told->branch) : std::nullopt;
}

RootOffset TreePlace::leaders_offset(std::int64_t now_us) const {
  const LeaderMessage* told = followed(now_us);
  return told != nullptr ? told->offset : RootOffset{};
}

const std::optional<RootOffset>& TreePlace::offset(std::int64_t now_us) const {
  const LeaderMessage* told = followed(now_us);
  return told != nullptr ? told->ours : alone_;
}

std::size_t TreePlace::depth(std::int64_t now_us) const {
  const LeaderMessage* told = message(now_us);
  return std::min(TreePath{}.size(), 1 + (told == nullptr ? 0 : told->length));
}

TreePath TreePlace::path(std::int64_t now_us) const {
  TreePath path{own_.leader};
  if (const LeaderMessage* told = message(now_us)) {
    // In a cycle the path ends at our own id, else it would grow without end.
    const auto end = std::ranges::find(told->path, own_.system);
    const auto count = std::min<std::size_t>(static_cast<std::size_t>(end - told->path.begin()) + 1,
                                             path.size() - 1);
    std::copy_n(told->path.begin(), std::min(count, told->length), path.begin() + 1);
  }
  return path;
}

bool TreePlace::too_deep(std::int64_t now_us) const {
  const LeaderMessage* told = message(now_us);
  return told != nullptr && told->length >= TreePath{}.size() - 1;
}

bool TreePlace::is_cycle(std::int64_t now_us) const {
  const LeaderMessage* told = message(now_us);
  return told != nullptr && told->cycle;
}

}  // namespace flotilla::app
