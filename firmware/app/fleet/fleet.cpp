// SPDX-License-Identifier: MIT
#include "app/fleet/fleet.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace flotilla::app {
namespace {

// With eight boats' signed beacons: 253 bytes a second, 4.4 % of 57,600 Bd.
constexpr std::int64_t kBeacon_us = 1'200'000;
// A change is sent at once and repeated, because radios lose packets.
constexpr std::array<std::int64_t, 3> kRepeats_us{150'000, 150'000, 200'000};
// A boat that has lost the leader reports the loss this often, because the next leader waits for a
// beacon of each member. A radio that loses 30 % loses all twelve once in two million times.
constexpr std::size_t kLossReports = 12;
constexpr std::int64_t kLossReport_us = 100'000;
// Interval after those, while a fit boat has no leader, until its coast ends.
constexpr std::int64_t kLeaderless_us = 200'000;
// A boat without the newest table gets it from the member with the earliest turn.
constexpr std::int64_t kTurn_us = 100'000, kPassed_us = 2'000'000;
// Beyond FS_LEADER_S: by then a follower already coasts.
constexpr std::int64_t kMore_us = 200'000;
// Other boats wait this long before they answer a request: only the leader knows its plan.
constexpr std::int64_t kLeaders_us = 1'500'000;
// A boat without a place does not know the others' places. It waits this long before it answers a
// request, and meanwhile receives their table.
constexpr std::int64_t kMembers_us = 6'000'000;
// An operator's order reaches most boats within this time. A boat that misses it takes the lead when
// the leader has been silent for FS_LEADER_S.
constexpr std::int64_t kOneOrder_us = 3'000'000;

std::optional<std::size_t> rank_in(const FleetTable* table, std::uint8_t system) {
  if (table == nullptr) return std::nullopt;
  return table->rank_of(system);
}

bool is_of(const FleetTable& table, std::uint8_t system) {
  return table.rank_of(system).has_value();
}

/// Whether the boat and the members that it hears are a majority of the table. A minority may be
/// cut off from boats that still sail the plan, so it waits instead of sailing the same line.
bool is_most(const FleetTable& table, std::size_t own, std::span<const FleetPeer> peers) {
  std::size_t heard = 1;
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    if (rank != own && peers[rank].heard) ++heard;
  }
  return 2 * heard > table.count;
}

/// Whether an operator has stopped most of the members that the boat hears.
bool most_stopped(std::size_t own, std::span<const FleetPeer> peers) {
  std::size_t heard = 0, stopped = 0;
  for (std::size_t rank = 0; rank < peers.size(); ++rank) {
    if (rank == own || !peers[rank].heard) continue;
    ++heard;
    if (peers[rank].stopped) ++stopped;
  }
  return 2 * stopped > heard;
}

bool same(const Configuration::Formation& a, const Configuration::Formation& b) {
  return a.leader == b.leader && a.north_m == b.north_m && a.east_m == b.east_m &&
         a.turns == b.turns;
}

}  // namespace

void Fleet::hear(const link::Received& received, Trust trust, std::int64_t now_us) {
  if (const auto rank = rank_in(ledger_.current(), received.from.system)) {
    const bool only_leads = ledger_.current()->members[*rank].only_leads;
    if (!peers_.hear(*rank, received, only_leads, now_us)) return;
  }
  if (const auto* beacon = std::get_if<link::FleetBeacon>(&received.message)) {
    take(received.from.system, *beacon, now_us);
  } else if (const auto* table = std::get_if<link::FleetTable>(&received.message)) {
    take(received, *table, trust, now_us);
  }
}

/// Accepts a table from an operator or a current member; a first table also from a trusted sender
/// that it lists.
void Fleet::take(const link::Received& received, const link::FleetTable& message, Trust trust,
                 std::int64_t now_us) {
  FleetTable table = table_of(message);
  const FleetTable& held = ledger_.newest();
  const bool from_member = held.epoch != 0
                               ? is_of(held, received.from.system)
                               : trust == Trust::kMember && is_of(table, received.from.system);
  if (trust != Trust::kCommands && (table.assigns || !from_member)) return;
  if (!is_stop(table) && !concerns_us(table)) return;
  if (table.epoch == held.epoch && table.digest == held.digest) passed_us_ = now_us;
  stops_ = stops_ || is_stop(table);  // even if the table is refused below
  if (const TableVerdict verdict = verdict_of(table); verdict.fault != TableFault::kNone) {
    refusal_ = verdict;
    return;
  }
  const std::int64_t valid_us = now_us + 1000 * in_ms_of(message);
  if (!table.assigns) {
    take(table, valid_us, now_us);
  } else if (table.epoch > held.epoch && !(request_ && table.epoch <= request_->table.epoch)) {
    if (const auto wait_us = gives_in(table)) request_ = {table, valid_us, now_us + *wait_us};
  }
}

/// Whether the table lists this boat, or a boat of the newest table. Another fleet's table lists
/// neither.
bool Fleet::concerns_us(const FleetTable& table) const {
  const bool knows_itself = system_ != 0;  // from the first tick on
  return !knows_itself || is_of(table, system_) ||
         std::ranges::any_of(ledger_.newest().all(), [&](const FleetMember& member) {
           return is_of(table, member.system);
         });
}

/// How long this boat waits before it answers a request, because other boats may know more;
/// nullopt: it never answers.
std::optional<std::int64_t> Fleet::gives_in(const FleetTable& requested) const {
  const bool has_place = rank_in(ledger_.current(), system_).has_value();
  if (!has_place) return is_of(requested, system_) ? std::optional(kMembers_us) : std::nullopt;
  return succession_.leads() || succession_.leader() == Succession::kNobody ? 0 : kLeaders_us;
}

void Fleet::take(const FleetTable& table, std::int64_t valid_us, std::int64_t now_us) {
  if (!ledger_.take(table, valid_us, now_us)) return;
  if (request_ && request_->table.epoch <= table.epoch) request_.reset();
  beacon_us_ = now_us;  // the beacon tells others that a newer table exists
  table_us_ = kNever;
}

/// Whether the table orders this boat to stop: as its member, or a member of the replaced table.
bool Fleet::is_stop(const FleetTable& table) const {
  const FleetTable& held = ledger_.newest();
  return table.stop && is_newer(table.epoch, table.digest, held) &&
         (is_of(table, system_) || is_of(held, system_) || rank_in(ledger_.current(), system_));
}

void Fleet::give_places(const FleetOutlook& outlook, std::int64_t now_us) {
  const Request request = *std::exchange(request_, std::nullopt);
  const std::int64_t valid_us = std::max(request.valid_us, now_us);
  std::array<std::optional<FleetSlot>, FleetTable::kMax> places;
  std::ranges::transform(request.table.all(), places.begin(), [&](const FleetMember& member) {
    const auto rank = rank_in(ledger_.current(), member.system);
    return rank ? std::optional(paths_.rest(*rank, valid_us)) : std::nullopt;
  });
  const std::size_t leader = succession_.leader();
  const auto root = leader == Succession::kNobody
                        ? std::nullopt
                        : request.table.rank_of(ledger_.current()->members[leader].system);
  const FleetTable given = assigned(request.table, places, root.value_or(0), outlook,
                                    1e-6 * static_cast<double>(valid_us - now_us));
  // Hulls differ: places far enough apart for one assignment may be too near for another.
  if (const TableVerdict verdict = verdict_of(given); verdict.fault != TableFault::kNone) {
    refusal_ = verdict;
  } else {
    take(given, valid_us, now_us);
  }
}

void Fleet::take(std::uint8_t from, const link::FleetBeacon& beacon, std::int64_t now_us) {
  const FleetTable& held = ledger_.newest();
  if (held.epoch == 0) {
    if (beacon.epoch != 0) {
      asks_ = true;
      // A member has a table: leave the request to it.
      if (request_ && is_of(request_->table, from)) request_.reset();
    }
    return;
  }
  const auto now_rank = rank_in(ledger_.current(), from);
  // A boat that the newest table omits needs it too, or it might take over from the leader.
  if (!is_of(held, from) && !now_rank && !ledger_.replaces(beacon.epoch, beacon.digest)) return;
  FleetTable theirs;
  theirs.epoch = beacon.epoch;
  theirs.digest = beacon.digest;
  const bool lacks = is_newer(held.epoch, held.digest, theirs);
  if (lacks && table_us_ == kNever && now_us - passed_us_ > kPassed_us / 4) {
    const auto own = held.rank_of(system_);
    // The order rotates, because the requester may not hear the first member.
    table_us_ = now_us + kTurn_us * static_cast<std::int64_t>((own.value_or(0) + beacon.sequence) %
                                                              held.count);
  }
  if (now_rank) take_member(*now_rank, beacon, now_us);
}

/// A member's beacon. Takes the fleet's place in its plan from the leader or, if this boat does not
/// hear the leader, from a member that does.
void Fleet::take_member(std::size_t rank, const link::FleetBeacon& beacon, std::int64_t now_us) {
  const std::size_t leader = succession_.leader();
  const FleetPeer& peer = peers_.all()[rank];
  const bool relayed = peer.hears == leader;
  const bool sailed = peer.heard && peer.epoch != 0 && !peer.stopped;
  const bool names_leader = peers_.take(rank, beacon, ledger_, now_us);
  if (sailed && peer.stopped) note_stop(ledger_.current()->members[rank].system, now_us);
  if (names_leader) contradict(peer, now_us);
  const bool unheard = leader < peers_.all().size() && !peers_.all()[leader].heard;
  // After the leader's stop, the member's first beacon no longer names a leader.
  const bool ends = relayed && beacon.plan_id == 0;
  // A boat that is not fit may report no plan only because it has been stopped itself.
  const bool knows = peer.fit || beacon.plan_id != 0;
  const bool relays = unheard && knows && (peer.hears == leader || ends);
  const bool by_leader = rank == leader && (peer.leads || peer.stopped);
  if (by_leader) leader_stopped_ = peer.stopped;
  if (by_leader || relays) note_place({beacon.plan_id, beacon.plan_item});
}

/// A member that has missed this boat's beacons, perhaps after a restart, may still take it for its
/// leader. Then this boat repeats its beacon.
void Fleet::contradict(const FleetPeer& peer, std::int64_t now_us) {
  const auto own = rank_in(ledger_.current(), system_);
  if (!own || peer.hears != *own || succession_.leads()) return;
  if (ledger_.current()->members[*own].only_leads || now_us < next_burst_us_) return;
  next_burst_us_ = now_us + kBeacon_us;
  beacon_us_ = now_us;
  repeats_ = std::max(repeats_, kRepeats_us.size());
}

/// An operator has stopped a member.
void Fleet::note_stop(std::uint8_t system, std::int64_t now_us) {
  if (system != last_stopped_) stop_before_us_ = last_stop_us_;
  last_stopped_ = system;
  last_stop_us_ = now_us;
}

void Fleet::note_place(const FleetPlace& place) {
  place_ = place;
  if (place.plan_id != 0) plan_id_ = place.plan_id;
}

/// The newest table comes into force.
void Fleet::begin(const Configuration::Formation& own, core::State state, std::int64_t now_us) {
  const FleetTable before = ledger_.current() != nullptr ? *ledger_.current() : FleetTable{};
  ledger_.forward(now_us);
  const FleetTable& table = *ledger_.current();
  paths_.begin(table, before, std::min(now_us, ledger_.valid_us()));
  peers_.begin(table, before, now_us);
  by_parameters_ = own;
  const bool obeyed = !std::exchange(by_hand_, false) && before.rank_of(system_).has_value();
  // Without a slot in the table, a follower must not sail to the slot of its parameters, and a boat
  // that took over must not sail on alone, because no operator has ordered this.
  const bool sails_by_table =
      core::follows(state) || (core::sails_alone(state) && succession_.sails_by_rule());
  if (obeyed && !table.rank_of(system_) && sails_by_table) stops_ = true;
  if (const auto rank = table.rank_of(system_); rank && table.members[*rank].leader == 0) {
    // Its former leader may be its follower now.
    attachment_ = is_of(table, own.leader) ? std::optional(Attachment{}) : std::nullopt;
    changed_ = true;
  }
  succession_.begin(table);
  told_epoch_ = table.epoch;
}

FleetOrder Fleet::step(const FleetReport& report, const Configuration::Formation& own,
                       std::int64_t leader_limit_us, std::int64_t now_us) {
  system_ = report.system;
  if (ledger_.is_due(now_us)) begin(own, report.state, now_us);
  FleetOrder order = FleetOrder::kNone;
  std::optional<Attachment> next;
  SlotMotion slot_motion;
  const FleetTable* table = ledger_.current();
  const core::State state = report.state;
  const bool drives = core::law_drives(state) || state == core::State::kManual;
  by_hand_ = by_hand_ || !same(own, by_parameters_);
  sailed_ = sailed_ || core::law_drives(state);
  // Stops before an order to sail are over.
  if (core::law_drives(state) && !core::law_drives(state_))
    last_stop_us_ = stop_before_us_ = kNever;
  bool stops = stops_;
  if (const auto rank = rank_in(table, system_)) {
    if (peers_.update(table->count, leader_limit_us + kMore_us, now_us)) {
      beacon_us_ = now_us;  // parts of the fleet meet
      repeats_ = std::max(repeats_, kRepeats_us.size());
    }
    const bool follows = core::follows(state);
    const bool ordered = state == core::State::kAuto || state == core::State::kGuided;
    const bool alone = core::sails_alone(state);
    order = succession_.step(
        *table,
        {*rank, ledger_.newest().epoch, follows && report.fit && !by_hand_, drives, alone, ordered,
         by_hand_, alone && state != state_, state == core::State::kManual},
        std::span(peers_.all()).first(table->count));
    const bool by_rule = order == FleetOrder::kLead || (succession_.sails_by_rule() && alone);
    const bool unled = succession_.leads() ? by_rule : follows && lacks_leader();
    const std::int64_t since_us = now_us - leader_limit_us - kOneOrder_us;
    stops = stops || (unled && has_missed_stop(*rank, *table, since_us));
    if (succession_.leads() && order != FleetOrder::kLead) {
      // In other modes its own item says nothing about the fleet's plan.
      note_place(state == core::State::kAuto ? report.place : FleetPlace{0, place_.item});
    }
    const std::size_t leader = succession_.leader();
    const bool tells_no_plan = leader < table->count && table->members[leader].only_leads;
    const bool waits = order == FleetOrder::kLead && !is_most(*table, *rank, peers_.all());
    if (tells_no_plan || waits || report.stopped) place_.plan_id = 0;
    next = by_hand_ ? std::nullopt : attachment(*rank, now_us);
    if (next && leader < table->count) slot_motion = paths_.motion(*rank, leader, now_us);
  } else {
    succession_ = {};
  }
  state_ = state;
  changed_ = changed_ || next != attachment_ || slot_motion != slot_motion_;
  slot_motion_ = slot_motion;
  attachment_ = next;
  update_beacon(report, order == FleetOrder::kFollow, now_us);
  return stops ? FleetOrder::kStop : order;
}

/// It follows the table's rule, but knows no leader.
bool Fleet::lacks_leader() const {
  return !by_hand_ && succession_.leader() == Succession::kNobody;
}

/// Operators have stopped most of the boats that this one hears: among them the leader of a fleet
/// under way, or two since since_us. So they meant the whole fleet.
bool Fleet::has_missed_stop(std::size_t own, const FleetTable& table, std::int64_t since_us) const {
  const bool with_leader = leader_stopped_ && (succession_.leads() || succession_.lost());
  return (with_leader || since_us < stop_before_us_) &&
         most_stopped(own, std::span(peers_.all()).first(table.count));
}

void Fleet::confirm_stop() {
  stops_ = false;
  succession_.confirm_stop();
}

/// Leader and slot from the table; nullopt: use the parameters.
std::optional<Fleet::Attachment> Fleet::attachment(std::size_t own, std::int64_t now_us) const {
  const FleetTable& table = *ledger_.current();
  const auto followed = succession_.followed();
  if (!followed) return attachment_;  // it leads, or knows no leader: unchanged
  const std::uint8_t leader = table.members[*followed].system;
  const auto here = paths_.place(own, now_us).cm, there = paths_.place(*followed, now_us).cm;
  const auto metres = [&](std::size_t axis) {
    return static_cast<float>(std::round(here[axis] - there[axis])) / 100;
  };
  return Attachment{leader, metres(0), metres(1), table.turns};
}

Parameters Fleet::applied(const Parameters& own) const {
  Parameters out = own;
  if (attachment_) {
    out.FORM_LEADER = attachment_->leader;
    out.FORM_OFS_N = attachment_->north_m;
    out.FORM_OFS_E = attachment_->east_m;
    out.FORM_FRAME = attachment_->turns ? 1.0F : 0.0F;
  }
  return out;
}

bool Fleet::may_claim(std::uint8_t system) const {
  const FleetTable* table = ledger_.current();
  return by_hand_ || !rank_in(table, system_) || is_of(*table, system);
}

/// Both boats' centres are then farther apart than half the sum of their lengths.
std::optional<float> Fleet::reach_m(std::uint8_t system) const {
  const auto own = rank_in(ledger_.current(), system_), other = rank_in(ledger_.current(), system);
  if (!own || !other) return std::nullopt;
  const int ours_dm = ledger_.current()->members[*own].length_dm;
  const int theirs_dm = ledger_.current()->members[*other].length_dm;
  if (ours_dm == 0 || theirs_dm == 0) return std::nullopt;
  return 0.05F * static_cast<float>(std::max(theirs_dm - ours_dm, 0));
}

/// A beacon that differs from the last one is due at once. A leader that yields follows from the
/// next tick on; it is reported fit already, or it would leave the tree.
void Fleet::update_beacon(const FleetReport& report, bool yields, std::int64_t now_us) {
  const FleetTable& newest = ledger_.newest();
  link::FleetBeacon now{};
  now.sequence = told_.sequence;
  now.epoch = newest.epoch;
  now.digest = newest.digest;
  if (const auto own = rank_in(ledger_.current(), system_)) {
    const FleetTable& table = *ledger_.current();
    const auto heard = succession_.heard_leader(table, *own, newest.epoch, peers_.all());
    const auto hears = heard ? newest.rank_of(table.members[*heard].system) : std::nullopt;
    const bool led = (told_.flags & FleetPeers::kLeads) != 0;
    const bool follows = core::follows(report.state) || (yields && led);
    const bool fit = follows && report.fit && !by_hand_;
    const bool leads = succession_.leads();
    const bool ends = report.stopped && sailed_;  // not if it has only restarted
    now.flags = static_cast<std::uint8_t>(
        (fit ? FleetPeers::kFit : 0U) | (leads ? FleetPeers::kLeads : 0U) |
        (ends ? FleetPeers::kEnds : 0U) | (hears ? *hears + 1 : 0U) << FleetPeers::kHears);
    now.leader = leads || !attachment_ ? std::uint8_t{0} : attachment_->leader;
    now.plan_id = place_.plan_id;
    now.plan_item = place_.item;
  }
  const bool loses = FleetPeers::heard_of(now.flags) == 0 && FleetPeers::heard_of(told_.flags) != 0;
  const bool urgent = now.flags != told_.flags || now.epoch != told_.epoch ||
                      (now.plan_id == 0) != (told_.plan_id == 0);
  told_ = now;
  if (!urgent) return;
  beacon_us_ = now_us;
  repeats_ = loses ? kLossReports : std::max(repeats_, kRepeats_us.size());
}

std::optional<link::FleetBeacon> Fleet::beacon(std::int64_t now_us) {
  // A leader that the next table leaves out still leads until that table comes into force.
  const bool member = is_of(ledger_.newest(), system_) || rank_in(ledger_.current(), system_);
  const bool speaks = ledger_.newest().epoch != 0 ? member : asks_;
  if (!speaks || now_us < beacon_us_) return std::nullopt;
  asks_ = false;
  const bool waited_for = succession_.lost() && (told_.flags & FleetPeers::kFit) != 0;
  beacon_us_ = now_us + (waited_for ? kLeaderless_us : kBeacon_us);
  if (repeats_ > 0) {
    const std::size_t left = repeats_--;
    beacon_us_ = now_us + (left > kRepeats_us.size() ? kLossReport_us
                                                     : kRepeats_us[kRepeats_us.size() - left]);
  }
  ++told_.sequence;
  return told_;
}

std::optional<link::FleetTable> Fleet::table(std::int64_t now_us) {
  if (table_us_ == kNever || now_us < table_us_) return std::nullopt;
  const bool another_did = now_us - passed_us_ <= kPassed_us / 4;
  table_us_ = kNever;
  if (another_did) return std::nullopt;
  passed_us_ = now_us;
  return message_of(ledger_.newest(), (ledger_.valid_us() - now_us) / 1000);
}

}  // namespace flotilla::app
