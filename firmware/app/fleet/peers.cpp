// SPDX-License-Identifier: MIT
#include "app/fleet/peers.hpp"

#include <algorithm>
#include <utility>

namespace flotilla::app {
namespace {

// A boat gets a newer table within this time if any member holds it. A member that still reports
// the greater epoch afterwards is faulty and no longer counts as a leader.
constexpr std::uint32_t kAhead_ms = 10'000;
// Greatest difference in link latency. A smaller number after that comes from a restarted boat.
constexpr std::uint16_t kOvertaken_ds = 30;
constexpr int kNumbersBack = 32;  // more beacons than a boat sends in kOvertaken_ds

std::uint32_t ms_of(std::int64_t us) { return static_cast<std::uint32_t>(us / 1000); }

std::uint16_t deciseconds(std::int64_t us) { return static_cast<std::uint16_t>(us / 100'000); }

std::uint8_t rank_or_none(const FleetTable& table, std::uint8_t system) {
  return static_cast<std::uint8_t>(table.rank_of(system).value_or(FleetTable::kMax));
}

}  // namespace

void FleetPeers::begin(const FleetTable& table, const FleetTable& before, std::int64_t now_us) {
  const FleetPeers old = std::exchange(*this, {});
  for (std::size_t rank = 0; rank < table.count; ++rank) {
    if (const auto was = before.rank_of(table.members[rank].system)) {
      FleetPeer& peer = peers_[rank] = old.peers_[*was];
      if (peer.hears < before.count) {
        peer.hears = rank_or_none(table, before.members[peer.hears].system);
      }
      peer.behind = peer.behind && table.members[rank].leader == before.members[*was].leader;
      heard_[rank] = old.heard_[*was];
    } else if (!table.members[rank].only_leads) {
      // A new member counts as fit and just heard until it falls silent.
      peers_[rank].fit = true;
      heard_[rank].at_us = now_us;
    }
  }
}

bool FleetPeers::hear(std::size_t rank, const link::Received& received, bool only_leads,
                      std::int64_t now_us) {
  Heard& heard = heard_[rank];
  if (const auto* beacon = std::get_if<link::FleetBeacon>(&received.message)) {
    if (!note_beacon(heard, *beacon, now_us)) return false;
    heard.component = received.from.component;
  }
  const bool speaks = only_leads
                          ? link::tells_motion(received.message)
                          : heard.component == 0 || heard.component == received.from.component;
  if (speaks) heard.at_us = now_us;
  return true;
}

/// Records the beacon's number; false if a newer one arrived first, on a faster link. A boat that
/// has restarted begins its numbers anew, in most cases far from its last one.
bool FleetPeers::note_beacon(Heard& heard, const link::FleetBeacon& beacon, std::int64_t now_us) {
  const auto ahead = static_cast<std::int8_t>(beacon.sequence - heard.sequence);
  const std::uint16_t now_ds = deciseconds(now_us);
  const auto since_ds = static_cast<std::uint16_t>(now_ds - heard.beacon_ds);
  const bool overtaken = heard.component != 0 && since_ds < kOvertaken_ds && ahead < 0;
  const bool restarted = ahead <= -kNumbersBack && beacon.sequence <= kNumbersBack;
  if (overtaken && !restarted) return false;
  heard.sequence = beacon.sequence;
  heard.beacon_ds = now_ds;
  return true;
}

bool FleetPeers::take(std::size_t rank, const link::FleetBeacon& beacon, const FleetLedger& ledger,
                      std::int64_t now_us) {
  std::uint32_t& ahead_ms = heard_[rank].ahead_ms;
  if (beacon.epoch <= ledger.newest().epoch) {
    ahead_ms = 0;
  } else if (ahead_ms == 0) {
    ahead_ms = std::max<std::uint32_t>(ms_of(now_us), 1);
  }
  FleetPeer& peer = peers_[rank];
  peer.fit = (beacon.flags & kFit) != 0;
  peer.leads = (beacon.flags & kLeads) != 0;
  peer.stopped = (beacon.flags & kEnds) != 0;
  peer.epoch = beacon.epoch;
  return note_leader(peer, beacon, ledger);
}

/// The rank refers to the sender's newest table. If this boat does not have that table, it keeps
/// the last report. True if the beacon names a leader that this boat knows.
bool FleetPeers::note_leader(FleetPeer& peer, const link::FleetBeacon& beacon,
                             const FleetLedger& ledger) {
  const std::size_t told = heard_of(beacon.flags);
  if (told == 0) peer.hears = FleetTable::kMax;
  bool known = false;
  for (const FleetTable* table : {&ledger.newest(), ledger.current()}) {
    if (table->epoch != beacon.epoch || table->digest != beacon.digest) continue;
    if (told == 0 || told > table->count) continue;
    const std::uint8_t leader = table->members[told - 1].system;
    peer.hears = rank_or_none(*ledger.current(), leader);
    peer.behind = beacon.leader == leader;
    known = peer.hears < ledger.current()->count;
  }
  return known;
}

bool FleetPeers::update(std::size_t count, std::int64_t limit_us, std::int64_t now_us) {
  bool returns = false;
  for (std::size_t rank = 0; rank < count; ++rank) {
    const Heard& heard = heard_[rank];
    FleetPeer& peer = peers_[rank];
    const bool was_heard = std::exchange(peer.heard, now_us - heard.at_us < limit_us);
    returns = returns || (peer.heard && !was_heard);
    const bool faulty = heard.ahead_ms != 0 && ms_of(now_us) - heard.ahead_ms >= kAhead_ms;
    peer.leads = peer.leads && !faulty;
    const auto since_ds = static_cast<std::uint16_t>(deciseconds(now_us) - heard.beacon_ds);
    peer.recent = heard.component != 0 && since_ds < kOvertaken_ds;
    // Meanwhile another boat may lead, or this one may have been sent elsewhere.
    if (!peer.heard && !peer.recent) peer.leads = false;
    if (peer.hears >= count) continue;
    const std::int64_t lost_us = now_us - heard_[peer.hears].at_us - limit_us;
    peer.current = 100'000 * (since_ds + std::int64_t{1}) < lost_us;
  }
  return returns;
}

}  // namespace flotilla::app
