// SPDX-License-Identifier: MIT
// Vehicle: sends heartbeats, telemetry and pending answers.
#include <algorithm>

#include "app/operator/telemetry/text.hpp"
#include "app/operator/vehicle.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::State;

std::uint8_t base_mode_of(State state) {
  unsigned flags = mav::kModeFlagCustom;
  if (core::armed(state)) flags |= mav::kModeFlagArmed;
  if (state == State::kManual) flags |= mav::kModeFlagManual;
  if (core::law_drives(state)) flags |= mav::kModeFlagAuto | mav::kModeFlagGuided;
  if (state == State::kTest) flags |= mav::kModeFlagTest;
  return static_cast<std::uint8_t>(flags);
}

std::uint8_t status_of(State state) {
  if (state == State::kFault) return mav::kStateEmergency;
  if (state == State::kCoast) return mav::kStateCritical;
  return core::armed(state) ? mav::kStateActive : mav::kStateStandby;
}

}  // namespace

link::Heartbeat Vehicle::heartbeat() const {
  const bool companion = identity_.companion();
  return {supervisor_.mode(), companion ? mav::kTypeOnboardController : mav::kTypeSurfaceBoat,
          identity_.autopilot(), base_mode_of(supervisor_.state()), status_of(supervisor_.state())};
}

std::optional<PlanReport> Vehicle::plan_report() const {
  if (missions_.plan().empty()) return std::nullopt;
  const bool sails = supervisor_.state() == State::kAuto;
  const std::uint8_t state = missions_.is_complete()         ? mav::kMissionComplete
                             : sails && !orders_.is_paused() ? mav::kMissionActive
                             : missions_.is_begun() || sails ? mav::kMissionPaused
                                                             : mav::kMissionNotStarted;
  const std::size_t count = missions_.plan().size();
  const std::size_t item = missions_.is_complete() ? count - 1 : missions_.current();
  return PlanReport{static_cast<std::uint16_t>(item),
                    static_cast<std::uint16_t>(count),
                    state,
                    missions_.id(Stored::kPlan),
                    missions_.id(Stored::kFence),
                    missions_.id(Stored::kRally)};
}

void Vehicle::report_progress(const PlanMark& ahead, std::optional<std::size_t> reached,
                              bool complete, link::Counters& counters) {
  missions_.sailed(ahead, complete);
  if (std::exchange(reached_, reached) == reached || !reached) return;
  links_.broadcast(link::MissionItemReached{static_cast<std::uint16_t>(*reached)}, counters);
  sender_.streams().make_due(link::MissionCurrent::kId);
}

void Vehicle::locate(const link::GpsGlobalOrigin& origin) {
  if (sender_.locate(origin)) missions_.locate(origin);
}

void Vehicle::report(const Report& report) {
  report_ = report;
  if (report_.own) report_.own->adrift = !report_.own->located && sender_.is_located();
  refresh();
}

void Vehicle::tell(link::Counters& counters) {
  if (heartbeat_due_.take_if_due(now_us_) || announce_) links_.beat(heartbeat(), counters);
  announce_ = false;
  const std::uint8_t system = self().system;
  timesync_.ask(now_us_, system, sender_.streams(), counters);
  if (core::follows(supervisor_.state()) && (report_.conditions & core::kLeaderTimed) == 0) {
    timesync_.ask_leader(now_us_, system, report_.leader, counters);
  }
  if (const auto again = missions_.repeat(now_us_)) {
    links_.send(again->link, again->message, counters);
  }
  tell_mission_news(counters);
  sender_.send_separation(counters);
  if (identity_.take_doubled() && texts_.take_if_due(TextKind::kDoubled, now_us_)) {
    texts_.send(mav::kSeverityCritical, {"another sender uses this boat's system and component id"},
                counters);
  }
  if (const auto why = std::exchange(ignored_, {});
      !why.empty() && texts_.take_if_due(TextKind::kIgnored, now_us_)) {
    texts_.send(mav::kSeverityWarning, {"Refused: ", why}, counters);
  }
  sender_.send(counters);
}

}  // namespace flotilla::app
