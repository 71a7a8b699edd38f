// SPDX-License-Identifier: MIT
#include "app/fleet/succession.hpp"

#include <algorithm>
#include <utility>

namespace flotilla::app {
namespace {

constexpr std::uint32_t bit(std::size_t rank) { return std::uint32_t{1} << rank; }

/// The other member that leads with the highest (epoch, rank); kNobody if none does.
std::size_t best_leader(const FleetTable& table, const FleetSelf& self,
                        std::span<const FleetPeer> peers) {
  std::size_t best = Succession::kNobody;
  const auto epoch_of = [&](std::size_t rank) {
    return table.members[rank].only_leads ? self.epoch : peers[rank].epoch;
  };
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    const FleetMember& member = table.members[rank];
    const bool leads = member.can_lead && (member.only_leads || peers[rank].leads);
    if (rank == self.rank || !peers[rank].heard || !leads) continue;
    if (best == Succession::kNobody || epoch_of(best) < epoch_of(rank)) best = rank;
  }
  return best;
}

/// It follows the leader that it hears, so a boat that follows it is in that leader's tree.
bool relays(const FleetPeer& peer) { return peer.heard && peer.fit && peer.behind; }

/// The first leader that another member hears and this boat does not; kNobody if there is none.
/// relayed: only if that member relays it.
std::size_t told_leader(std::size_t own, std::span<const FleetPeer> peers, bool relayed) {
  std::size_t best = Succession::kNobody;
  for (std::size_t rank = 0; rank < peers.size(); ++rank) {
    const FleetPeer& peer = peers[rank];
    if (rank == own || !peer.heard || peer.hears == own || (relayed && !relays(peer))) continue;
    if (peer.hears < peers.size() && !peers[peer.hears].heard) {
      best = std::min<std::size_t>(best, peer.hears);
    }
  }
  return best;
}

/// Other members are heard, and none of them reports that it hears another leader.
bool all_lack_leader(std::size_t own, std::span<const FleetPeer> peers) {
  bool told = false;
  for (std::size_t rank = 0; rank < peers.size(); ++rank) {
    const FleetPeer& peer = peers[rank];
    if (rank == own || !peer.heard) continue;
    if (peer.hears < peers.size() && peer.hears != own) return false;
    told = told || peer.recent;
  }
  return told;
}

}  // namespace

void Succession::begin(const FleetTable& table) {
  was_fit_ = out_ = 0;
  followed_.reset();
  leader_ = kNobody;
  stopping_ = false;
  if (!table.stop) return;
  *this = {};
  stopping_ = true;
}

FleetOrder Succession::step(const FleetTable& table, const FleetSelf& self,
                            std::span<const FleetPeer> peers) {
  judge(peers, self.rank);
  choose(table, self, peers);
  if (self.by_hand || leads_) {
    followed_.reset();
  } else {
    attach_to_leader(table, self.rank, peers);
  }
  return order(self);
}

/// Once the fleet is under way, a member that neither is fit nor leads has failed: until the next
/// table if it was fit under this one, otherwise until it is fit.
void Succession::judge(std::span<const FleetPeer> peers, std::size_t own) {
  for (std::size_t rank = 0; rank < peers.size(); ++rank) {
    if (rank == own) continue;
    const bool fit = peers[rank].heard && (peers[rank].fit || peers[rank].leads);
    if (fit && (was_fit_ & bit(rank)) == 0) out_ &= ~bit(rank);
    if (fit && peers[rank].epoch != 0) was_fit_ |= bit(rank);
    if (!fit && under_way_) out_ |= bit(rank);
  }
}

void Succession::choose(const FleetTable& table, const FleetSelf& self,
                        std::span<const FleetPeer> peers) {
  const bool led = std::exchange(leads_, false), took = taking_;
  const bool goes_on = led && (self.alone || self.by_sticks);  // a leader does not use its slot
  const bool can_lead =
      table.members[self.rank].can_lead && (!self.by_hand || goes_on) && !stopping_;
  const std::size_t other = best_leader(table, self, peers);
  const std::size_t told = told_leader(self.rank, peers, false);
  const bool has_epoch = other != kNobody && !table.members[other].only_leads;
  const bool older = has_epoch && peers[other].epoch < self.epoch;
  const bool newer = has_epoch && peers[other].epoch > self.epoch;
  const bool yields =
      newer || (other < self.rank && !older) || told_leader(self.rank, peers, true) < self.rank;
  by_rule_ = took || (by_rule_ && !self.begun);
  beside_ = self.alone && (self.begun ? yields && !led : beside_);
  const bool yields_mode = !can_lead || (yields && (self.ordered || by_rule_));
  yielding_ = (yielding_ && !self.begun) || (led && yields_mode);
  if (taking_) {
    taking_ = self.fit && !self.alone;
    leads_ = taking_ || self.alone;
  } else {
    const bool is_root = table.members[self.rank].leader == 0;
    const bool none_leads = other == kNobody && told == kNobody;
    const bool begins = is_root && none_leads && !under_way_ && all_lack_leader(self.rank, peers);
    leads_ = goes_on || (self.alone && ((self.ordered && !beside_) || begins));
  }
  if (other == kNobody && told == kNobody && !led && under_way_ && self.fit &&
      first_fit(table, self.rank, peers)) {
    leads_ = taking_ = can_lead;
  }
  leads_ = leads_ && can_lead && !yields;
  taking_ = taking_ && leads_;
  leader_ = leads_ ? self.rank : other != kNobody ? other : told;
  const bool resigns = led && !took && !goes_on;
  under_way_ = self.drives && ((under_way_ && !resigns) || leader_ != kNobody);
}

/// No member before this one in the table is known to be fit to lead.
bool Succession::first_fit(const FleetTable& table, std::size_t own,
                           std::span<const FleetPeer> peers) {
  for (std::size_t rank = 0; rank < own; ++rank) {
    if (table.members[rank].can_lead && peers[rank].heard && peers[rank].fit) return false;
  }
  return true;
}

/// Follows the nearest working ancestor, else the fleet's leader. Keeps the last choice while no
/// leader is known.
void Succession::attach_to_leader(const FleetTable& table, std::size_t own,
                                  std::span<const FleetPeer> peers) {
  std::optional<std::size_t> above = table.rank_of(table.members[own].leader);
  while (above && *above != leader_ && (out_ & bit(*above)) != 0) {
    above = table.rank_of(table.members[*above].leader);
  }
  const bool is_root = above && table.members[*above].leader == 0;
  const bool gone = !above || (is_root && leader_ != kNobody);
  if (!gone) {
    followed_ = *above == leader_ ? way_to_leader(own, peers) : *above;
  } else if (leader_ != kNobody) {
    followed_ = way_to_leader(own, peers);
  }
}

/// The leader, or if this boat does not hear it, a member that follows it.
std::size_t Succession::way_to_leader(std::size_t own, std::span<const FleetPeer> peers) const {
  if (peers[leader_].heard) return leader_;
  for (std::size_t rank = 0; rank < peers.size(); ++rank) {
    const FleetPeer& peer = peers[rank];
    if (rank != own && relays(peer) && peer.current && peer.hears == leader_) return rank;
  }
  return leader_;
}

std::optional<std::size_t> Succession::heard_leader(const FleetTable& table, std::size_t own,
                                                    std::uint16_t epoch,
                                                    std::span<const FleetPeer> peers) const {
  if (leader_ == kNobody || leader_ == own || !peers[leader_].heard) return std::nullopt;
  const bool only_leads = table.members[leader_].only_leads;
  const bool leads = only_leads || (peers[leader_].leads && peers[leader_].epoch >= epoch);
  return leads ? std::optional(leader_) : std::nullopt;
}

std::uint64_t Succession::code() const {
  static_assert(FleetTable::kMax <= 24);
  std::uint64_t code = was_fit_;
  code = code << 24U | out_;
  code = code << 5U | leader_;
  code = code << 5U | followed_.value_or(kNobody);
  for (const bool flag : {leads_, taking_, by_rule_, beside_, yielding_, under_way_, stopping_}) {
    code = code << 1U | (flag ? 1U : 0U);
  }
  return code;
}

FleetOrder Succession::order(const FleetSelf& self) {
  stopping_ = stopping_ && self.drives;
  if (stopping_) return FleetOrder::kStop;
  if (taking_) return FleetOrder::kLead;
  yielding_ = yielding_ && self.alone && !leads_;
  return yielding_ && leader_ != kNobody ? FleetOrder::kFollow : FleetOrder::kNone;
}

}  // namespace flotilla::app
