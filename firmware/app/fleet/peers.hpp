// SPDX-License-Identifier: MIT
// The members of the fleet, as this boat hears them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "app/fleet/ledger.hpp"
#include "app/fleet/succession.hpp"

namespace flotilla::app {

/// Members are named by their ranks in the table in force.
class FleetPeers {
 public:
  /// Flags of FLEET_BEACON. Five bits from kHears on: rank, from 1, of the leader that the sender
  /// hears. kEnds: an operator has stopped the boat, and with it the plan that it led.
  static constexpr std::uint8_t kFit = 1, kLeads = 2, kEnds = 128;
  static constexpr unsigned kHears = 2;
  static constexpr std::size_t heard_of(std::uint8_t flags) { return (flags & ~kEnds) >> kHears; }

  /// Call when a table comes into force in place of `before`. Members' last beacons stay valid.
  void begin(const FleetTable& table, const FleetTable& before, std::int64_t now_us);

  /// Takes any message of a member. False if it is a beacon and a newer one arrived before it.
  bool hear(std::size_t rank, const link::Received& received, bool only_leads, std::int64_t now_us);

  /// Takes a member's beacon; call after hear(). True if it names a leader that this boat knows.
  bool take(std::size_t rank, const link::FleetBeacon& beacon, const FleetLedger& ledger,
            std::int64_t now_us);

  /// Once a tick: members that were silent for limit_us are no longer heard. True if one that was
  /// silent is heard again. If it led, it counts as a leader only after its next beacon.
  [[nodiscard]] bool update(std::size_t count, std::int64_t limit_us, std::int64_t now_us);

  /// By rank; this boat's own is not kept up to date.
  const std::array<FleetPeer, FleetTable::kMax>& all() const { return peers_; }

 private:
  /// The last messages of a member. component sends its beacons; 0: none was heard yet. ahead_ms:
  /// start of the time in which it reports a greater epoch than this boat's; 0: it does not.
  /// beacon_ds, in 0.1 s, and sequence: of its latest beacon.
  struct Heard {
    std::int64_t at_us = std::numeric_limits<std::int64_t>::min() / 2;
    std::uint32_t ahead_ms = 0;
    std::uint16_t beacon_ds = 0;
    std::uint8_t component = 0, sequence = 0;
  };

  static bool note_beacon(Heard& heard, const link::FleetBeacon& beacon, std::int64_t now_us);
  static bool note_leader(FleetPeer& peer, const link::FleetBeacon& beacon,
                          const FleetLedger& ledger);

  std::array<FleetPeer, FleetTable::kMax> peers_{};
  std::array<Heard, FleetTable::kMax> heard_{};
};

}  // namespace flotilla::app
