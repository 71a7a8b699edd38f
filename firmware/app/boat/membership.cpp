// SPDX-License-Identifier: MIT
#include "app/boat/membership.hpp"

namespace flotilla::app {

void Membership::hear(const link::Received& received, std::int64_t now_us) {
  const std::uint8_t from = received.from.system;
  if (!kKeepsFleet || from == vehicle_.self().system) return;
  const Configuration& own = vehicle_.configuration();
  const auto commander = own.operators.commander;
  const bool member = received.is_signed || from == own.formation.leader;
  using Trust = Fleet::Trust;
  const Trust trust = member ? Trust::kMember : Trust::kNone;
  fleet().hear(received, !commander || *commander == from ? Trust::kCommands : trust, now_us);
}

FleetOrder Membership::order(core::State state, bool stopped, core::Conditions conditions,
                             std::int64_t now_us) {
  if (!kKeepsFleet) return FleetOrder::kNone;
  const MissionService& missions = vehicle_.missions();
  const Configuration& configuration = vehicle_.configuration();
  const auto item = static_cast<std::uint16_t>(missions.current());
  const bool fit = (conditions & core::kLoiterBegins) == core::kLoiterBegins;
  const bool goes_on = !vehicle_.orders().is_paused() && !missions.is_complete();
  const std::uint32_t plan_id = goes_on ? missions.id(Stored::kPlan) : 0;
  return fleet().step({vehicle_.self().system, state, fit, {plan_id, item}, stopped},
                      configuration.formation, configuration.navigation.leader_limit_us, now_us);
}

Parameters Membership::applied(const Parameters& own) const {
  return kKeepsFleet ? fleet().applied(own) : own;
}

bool Membership::obey(FleetOrder order) {
  switch (order) {
    case FleetOrder::kNone:
      return false;
    case FleetOrder::kLead:
      lead();
      break;
    case FleetOrder::kFollow:
      vehicle_.obey(core::Request::kFormation, counters_);
      break;
    case FleetOrder::kStop:
      if (vehicle_.obey_stop(counters_)) fleet().confirm_stop();
      break;
  }
  return true;
}

/// Takes the last leader's item if this boat has the fleet's plan, and continues the plan there if
/// the fleet sails it now. Otherwise the boat waits in LOITER.
void Membership::lead() {
  MissionService& missions = vehicle_.missions();
  const std::uint32_t plan_id = fleet().last_plan_id();
  const bool shared = plan_id != 0 && plan_id == missions.id(Stored::kPlan);
  const bool there = shared && missions.set_current(fleet().place().item, true);
  const bool sails = there && fleet().place().plan_id != 0;
  if (sails && vehicle_.obey(core::Request::kAuto, counters_)) return;
  vehicle_.obey(core::Request::kLoiter, counters_);
}

void Membership::tell(std::int64_t now_us) {
  if (!kKeepsFleet) return;
  if (const auto beacon = fleet().beacon(now_us)) links_.broadcast(*beacon, counters_);
  if (const auto table = fleet().table(now_us)) links_.broadcast(*table, counters_);
  if (const auto epoch = fleet().take_epoch()) {
    Sentence text;
    text << "fleet table " << static_cast<float>(*epoch) << " active"
         << (fleet().is_member() ? "" : "; this boat is not in it");
    vehicle_.texts().send(link::mav::kSeverityInfo, {text.text()}, counters_);
  }
  if (const auto refused = fleet().take_refusal()) {
    vehicle_.texts().send(link::mav::kSeverityWarning, {sentence_of(*refused).text()}, counters_);
  }
}

}  // namespace flotilla::app
