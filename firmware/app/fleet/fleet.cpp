// SPDX-License-Identifier: MIT
#include "app/fleet/fleet.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace flotilla::app {
namespace {

constexpr std::uint8_t kFit = 1, kLeads = 2;

// With eight boats' signed beacons: 250 bytes a second, 4.3 % of 57,600 Bd.
constexpr std::int64_t kBeacon_us = 1'200'000;
// A change is told at once, and again, so that a bad radio does not hold it back.
constexpr std::array<std::int64_t, 3> kRepeats_us{150'000, 150'000, 200'000};
// A boat that lacks the newest table gets it from the first member whose turn it is.
constexpr std::int64_t kTurn_us = 100'000, kPassed_us = 2'000'000;
// Beyond FS_LEADER_S: by then a follower already coasts.
constexpr std::int64_t kMore_us = 200'000;
// While a shape changes the slots are set anew that often; between, the law has their speed.
constexpr std::int64_t kMove_us = 200'000;

std::optional<std::size_t> rank_in(const FleetTable* table, std::uint8_t system) {
  if (table == nullptr) return std::nullopt;
  return table->rank_of(system);
}

bool is_of(const FleetTable& table, std::uint8_t system) {
  return table.rank_of(system).has_value();
}

/// Whether a boat hears so many that they are more than half of the table with it. A smaller part
/// may be cut off from one that still sails the plan: it waits, lest both sail on one line.
bool is_most(const FleetTable& table, std::size_t own, std::span<const FleetPeer> peers) {
  std::size_t heard = 1;
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    if (rank != own && peers[rank].heard) ++heard;
  }
  return 2 * heard > table.count;
}

bool same(const Configuration::Formation& a, const Configuration::Formation& b) {
  return a.leader == b.leader && a.north_m == b.north_m && a.east_m == b.east_m &&
         a.turns == b.turns;
}

}  // namespace

void Fleet::hear(const link::Received& received, bool commands, std::int64_t now_us) {
  if (const auto rank = rank_in(ledger_.current(), received.from.system)) heard_us_[*rank] = now_us;
  if (const auto* beacon = std::get_if<link::FleetBeacon>(&received.message)) {
    take(received.from.system, *beacon, now_us);
  } else if (const auto* table = std::get_if<link::FleetTable>(&received.message)) {
    take(received, *table, commands, now_us);
  }
}

/// Accepts it from an operator, and from a member of the table that is held; the first one from a
/// member of its own.
void Fleet::take(const link::Received& received, const link::FleetTable& message, bool commands,
                 std::int64_t now_us) {
  FleetTable table = table_of(message);
  const FleetTable& held = ledger_.newest();
  const bool from_member = is_of(held.epoch != 0 ? held : table, received.from.system);
  if (!commands && (table.assigns || !from_member)) return;
  if (table.epoch == held.epoch && table.digest == held.digest) passed_us_ = now_us;
  if (const TableVerdict verdict = verdict_of(table); verdict.fault != TableFault::kNone) {
    refusal_ = verdict;
    return;
  }
  if (table.assigns) {
    if (table.epoch <= held.epoch) return;  // heard again: its places are given already
    std::array<std::optional<FleetSlot>, FleetTable::kMost> places;
    std::ranges::transform(table.all(), places.begin(), [&](const FleetMember& member) {
      return place_of(member.system, now_us);
    });
    table = assigned(table, places, pace_);
  }
  if (ledger_.take(table, now_us + std::int64_t{message.in_ms} * 1000, now_us)) {
    beacon_us_ = now_us;  // who lacks it asks
    table_us_ = kNever;
  }
}

void Fleet::take(std::uint8_t from, const link::FleetBeacon& beacon, std::int64_t now_us) {
  const FleetTable& held = ledger_.newest();
  if (held.epoch == 0) {
    asks_ = asks_ || beacon.epoch != 0;
    return;
  }
  const auto rank = held.rank_of(from);
  if (!rank) return;
  FleetTable theirs;
  theirs.epoch = beacon.epoch;
  theirs.digest = beacon.digest;
  const bool lacks = is_newer(held.epoch, held.digest, theirs);
  if (lacks && table_us_ == kNever && now_us - passed_us_ > kPassed_us / 4) {
    const auto own = held.rank_of(system_);
    table_us_ = now_us + kTurn_us * static_cast<std::int64_t>(own.value_or(0));
  }
  const auto now_rank = rank_in(ledger_.current(), from);
  if (!now_rank) return;
  FleetPeer& peer = peers_[*now_rank];
  peer.fit = (beacon.flags & kFit) != 0;
  peer.leads = (beacon.flags & kLeads) != 0;
  peer.epoch = beacon.epoch;
  if (*now_rank == succession_.leader() && peer.leads) {
    place_ = {beacon.plan_id, beacon.plan_item};
  }
}

/// Members' last beacons stay valid in a new table.
void Fleet::begin(const Configuration::Formation& own, std::int64_t now_us) {
  const FleetTable before = ledger_.current() != nullptr ? *ledger_.current() : FleetTable{};
  const FleetTable next = ledger_.newest();
  std::array<FleetSlot, FleetTable::kMost> from_cm{};
  std::ranges::transform(next.all(), from_cm.begin(), [&](const FleetMember& member) {
    const auto place = place_of(member.system, now_us);
    return place && before.turns == next.turns ? *place : member.slot_cm;
  });
  ledger_.forward(now_us);
  from_cm_ = from_cm;
  begun_us_ = now_us;
  const auto peers = std::exchange(peers_, {});
  const auto heard_us = heard_us_;
  heard_us_.fill(kNever);
  for (std::size_t rank = 0; rank < before.count; ++rank) {
    const auto now = ledger_.current()->rank_of(before.members[rank].system);
    if (!now) continue;
    peers_[*now] = peers[rank];
    heard_us_[*now] = heard_us[rank];
  }
  by_parameters_ = own;
  by_hand_ = false;
  const FleetTable& table = *ledger_.current();
  if (const auto rank = table.rank_of(system_); rank && table.members[*rank].leader == 0) {
    // Whom it followed may follow it now.
    hang_ = is_of(table, own.leader) ? std::optional(Hang{}) : std::nullopt;
    changed_ = true;
  }
  succession_.begin(table);
  told_epoch_ = ledger_.current()->epoch;
}

void Fleet::listen(std::int64_t limit_us, std::int64_t now_us) {
  const FleetTable& table = *ledger_.current();
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    peers_[rank].heard = now_us - heard_us_[rank] < limit_us;
  }
}

FleetOrder Fleet::step(const FleetReport& report, const Configuration::Formation& own,
                       std::int64_t leader_limit_us, std::int64_t now_us) {
  system_ = report.system;
  pace_ = report.pace;
  if (ledger_.is_due(now_us)) begin(own, now_us);
  FleetOrder order = FleetOrder::kNone;
  std::optional<Hang> next;
  std::array<float, 2> slot_mps{};
  const FleetTable* table = ledger_.current();
  by_hand_ = by_hand_ || !same(own, by_parameters_);
  if (const auto rank = rank_in(table, system_)) {
    listen(leader_limit_us + kMore_us, now_us);
    const core::State state = report.state;
    const bool follows = core::follows(state);
    const bool ordered = state == core::State::kAuto || state == core::State::kGuided;
    order = succession_.step(*table,
                             {*rank, follows && report.fit && !by_hand_,
                              core::law_drives(state) || state == core::State::kManual,
                              core::sails_alone(state), ordered, by_hand_},
                             std::span(peers_).first(table->count));
    if (order == FleetOrder::kLead && !is_most(*table, *rank, peers_)) place_ = {};
    next = by_hand_ ? std::nullopt : hang(*rank, now_us);
    if (next) slot_mps = rate(*rank, now_us);
    if (succession_.leads()) place_ = ordered ? report.place : place_;
  }
  changed_ = changed_ || next != hang_ || slot_mps != slot_mps_;
  slot_mps_ = slot_mps;
  hang_ = next;
  speak(report, now_us);
  return order;
}

/// Of the way to the new places.
FleetMove Fleet::move(std::int64_t now_us) const {
  const std::int64_t since_us = (now_us - begun_us_) / kMove_us * kMove_us;
  return move_at(1e-6 * static_cast<double>(since_us), 0.1 * ledger_.current()->move_ds);
}

/// A member's place in the shape as it is now; nothing for others.
std::optional<FleetSlot> Fleet::place_of(std::uint8_t system, std::int64_t now_us) const {
  const auto rank = rank_in(ledger_.current(), system);
  if (!rank) return std::nullopt;
  const double share = move(now_us).share;
  FleetSlot place{};
  for (std::size_t axis = 0; axis < place.size(); ++axis) {
    const int from = from_cm_[*rank][axis], to = ledger_.current()->members[*rank].slot_cm[axis];
    place[axis] = static_cast<std::int16_t>(std::lround(from + share * (to - from)));
  }
  return place;
}

std::array<float, 2> Fleet::rate(std::size_t own, std::int64_t now_us) const {
  const FleetTable& table = *ledger_.current();
  const std::size_t root = succession_.leader();
  if (root >= table.count) return {};
  const double rate = move(now_us).rate;
  const auto mps = [&](std::size_t axis) {
    const int way = table.members[own].slot_cm[axis] - from_cm_[own][axis];
    const int roots = table.members[root].slot_cm[axis] - from_cm_[root][axis];
    return static_cast<float>(0.01 * rate * (way - roots));
  };
  return {mps(0), mps(1)};
}

/// The leader of the law, 0 for none: nothing leaves what the parameters say.
std::optional<Fleet::Hang> Fleet::hang(std::size_t own, std::int64_t now_us) const {
  const FleetTable& table = *ledger_.current();
  const auto followed = succession_.followed();
  if (!followed) return hang_;  // it leads, or knows no leader: as before
  const std::uint8_t leader = table.members[*followed].system;
  const FleetSlot here = *place_of(table.members[own].system, now_us);
  const FleetSlot there = *place_of(leader, now_us);
  const auto metres = [&](std::size_t axis) {
    return static_cast<float>(here[axis] - there[axis]) / 100;
  };
  return Hang{leader, metres(0), metres(1), table.turns};
}

Parameters Fleet::applied(const Parameters& own) const {
  Parameters out = own;
  if (hang_) {
    out.FORM_LEADER = hang_->leader;
    out.FORM_OFS_N = hang_->north_m;
    out.FORM_OFS_E = hang_->east_m;
    out.FORM_FRAME = hang_->turns ? 1.0F : 0.0F;
  }
  return out;
}

/// A beacon that differs from the last one is due at once.
void Fleet::speak(const FleetReport& report, std::int64_t now_us) {
  const FleetTable& newest = ledger_.newest();
  link::FleetBeacon now{};
  now.epoch = newest.epoch;
  now.digest = newest.digest;
  if (rank_in(ledger_.current(), system_)) {
    const bool fit = core::follows(report.state) && report.fit && !by_hand_;
    const bool leads = succession_.leads();
    now.flags = static_cast<std::uint8_t>((fit ? kFit : 0U) | (leads ? kLeads : 0U));
    now.leader = leads || !hang_ ? std::uint8_t{0} : hang_->leader;
    now.plan_id = place_.plan_id;
    now.plan_item = place_.item;
  }
  const bool urgent = now.flags != told_.flags || now.epoch != told_.epoch;
  told_ = now;
  if (!urgent) return;
  beacon_us_ = now_us;
  repeats_ = kRepeats_us.size();
}

std::optional<link::FleetBeacon> Fleet::beacon(std::int64_t now_us) {
  const bool speaks = ledger_.newest().epoch != 0 ? is_of(ledger_.newest(), system_) : asks_;
  if (!speaks || now_us < beacon_us_) return std::nullopt;
  asks_ = false;
  const bool again = repeats_ > 0;
  beacon_us_ = now_us + (again ? kRepeats_us[kRepeats_us.size() - repeats_] : kBeacon_us);
  if (again) --repeats_;
  return told_;
}

std::optional<link::FleetTable> Fleet::table(std::int64_t now_us) {
  if (table_us_ == kNever || now_us < table_us_) return std::nullopt;
  const bool another_did = now_us - passed_us_ <= kPassed_us / 4;
  table_us_ = kNever;
  if (another_did) return std::nullopt;
  passed_us_ = now_us;
  return message_of(ledger_.newest(), ledger_.in_ms(now_us));
}

}  // namespace flotilla::app
