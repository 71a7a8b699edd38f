// SPDX-License-Identifier: MIT
// The boat as a member of its fleet: reports the boat's state to the fleet's rule, asks the boat to
// carry out the rule's orders, and passes on messages and news. Does nothing on targets that have
// too little flash.
#pragma once

#include <array>
#include <cstdint>

#include "app/fleet/fleet.hpp"
#include "app/guidance/sender.hpp"
#include "app/operator/vehicle.hpp"

namespace flotilla::app {

class Membership {
 public:
  static constexpr bool kKeepsFleet = FLOTILLA_KEEPS_FLEET != 0;

  /// All must outlive this.
  Membership(Vehicle& vehicle, MavlinkLinks& links, link::Counters& counters)
      : vehicle_(vehicle), links_(links), counters_(counters) {}

  /// Takes any message.
  void hear(const link::Received& received, std::int64_t now_us);

  /// See Fleet.
  bool asks_outlook(std::int64_t now_us) const { return fleet().asks_outlook(now_us); }
  void give_places(const FleetOutlook& outlook, std::int64_t now_us) {
    fleet().give_places(outlook, now_us);
  }

  /// The rule's order; call it once a tick. `stopped`: see FleetReport.
  FleetOrder order(core::State state, bool stopped, core::Conditions conditions,
                   std::int64_t now_us);

  /// Whether applied() has changed since the last call.
  [[nodiscard]] bool take_change() { return kKeepsFleet && fleet().take_change(); }
  Parameters applied(const Parameters& own) const;
  /// The table's data about the sender of a message.
  Sender sender(const link::Received& received) const {
    Sender sender;
    if (!kKeepsFleet) return sender;
    if (std::holds_alternative<link::FormationReference>(received.message)) {
      sender.may_claim = fleet().may_claim(received.from.system);
    } else if (link::tells_motion(received.message)) {
      sender.reach_m = fleet().reach_m(received.from.system);
    }
    return sender;
  }
  SlotMotion slot_motion() const { return kKeepsFleet ? fleet().slot_motion() : SlotMotion{}; }

  bool shape_moves(std::int64_t now_us) const { return kKeepsFleet && fleet().moves(now_us); }

  /// Requests that the boat carry out the order. False if there is no order.
  bool obey(FleetOrder order);

  /// Sends the messages that are due.
  void tell(std::int64_t now_us);

 private:
  Fleet& fleet() { return fleets_[0]; }
  const Fleet& fleet() const { return fleets_[0]; }
  void lead();

  Vehicle& vehicle_;
  MavlinkLinks& links_;
  link::Counters& counters_;
  std::array<Fleet, kKeepsFleet ? 1 : 0> fleets_;  // takes no memory where it does nothing
};

}  // namespace flotilla::app
