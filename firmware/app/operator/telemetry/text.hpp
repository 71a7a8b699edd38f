// SPDX-License-Identifier: MIT
// Short messages to the operator, without a heap.
#pragma once

#include <algorithm>
#include <array>
#include <string_view>

#include "core/supervisor.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

inline std::string_view name_of(core::State state) {
  constexpr std::array<std::string_view, core::kStates> kNames{
      "DISARMED", "HOLD", "MANUAL", "FORMATION", "COAST", "TEST",
      "FAULT",    "AUTO", "GUIDED", "LOITER",    "RTL"};
  return kNames[static_cast<std::size_t>(state)];
}

struct Complaint {
  core::Conditions condition;
  std::string_view sentence;
};

/// Texts for unmet conditions, the most important first.
inline constexpr std::array<Complaint, core::kConditionCount> kComplaints{{
    {core::kSoleController, "another controller on the CAN bus"},
    {core::kBusUp, "CAN bus is down"},
    {core::kInRange, "numeric overflow in the control law"},
    {core::kSoleVessel, "another sender uses this boat's ids"},
    {core::kOwnFresh, "no recent navigation data"},
    {core::kOwnLive, "navigation data frozen"},
    {core::kOwnSteady, "jump in navigation data"},
    {core::kOwnTimed, "navigation lag unknown: set NAV_LAG_S"},
    {core::kOwnGood, "navigation unit reports a poor estimate"},
    {core::kOwnPrompt, "navigation latency is too high"},
    {core::kEscsOnline, "an ESC is offline or reports a fault"},
    {core::kEscsObey, "ESC spinning while commanded to stop"},
    {core::kBoatAnswers, "boat does not respond to thrust"},
    {core::kLeaderFresh, "leader lost or origin unknown"},
    {core::kLeaderTimed, "leader latency unknown: set FORM_LAG_S"},
    {core::kLeaderNear, "leader is beyond FORM_DIST_MAX"},
    {core::kLeaderLive, "leader's state is frozen"},
    {core::kLeaderSteady, "leader's state jumps or has two senders"},
    {core::kLeadersEnd, "leaders form a cycle"},
    {core::kSlotSound, "slot is taken, or astern while turning"},
    {core::kOnStation, "boat does not keep its slot or path"},
    {core::kPlanReady, "no plan, or it cannot be sailed now"},
    {core::kLocated, "own global position is unknown"},
    {core::kHomeNear, "no home or rally point within 2.9 km"},
    {core::kClear, "a vessel is nearer than FS_SEP_M"},
    {core::kInsideFence, "fence: outside, ahead, or no position"},
    {core::kBatteryGood, "battery is below FS_BATT_V, or unknown"},
    {core::kGcsHeard, "no ground station is heard"},
    {core::kGainsFit, "a gain does not fit the hull"},
    {core::kParametersSaved, "parameters or fence are not saved"},
    {core::kSticksFresh, "no MANUAL_CONTROL or RC input"},
    {core::kSticksCentred, "centre the sticks first"},
    {core::kTestRunning, "no motor test is running"},
    {core::kCoastRunning, "FS_COAST_S elapsed, or position lost"},
}};

/// Calls f(text) for each unmet condition, the most important first.
template <class F>
void for_each_complaint(core::Conditions unmet, F f) {
  for (const Complaint& complaint : kComplaints) {
    if ((unmet & complaint.condition) != 0) f(complaint.sentence);
  }
}

/// The text of the most important unmet condition; empty if all are met.
inline std::string_view complaint_of(core::Conditions unmet) {
  for (const Complaint& complaint : kComplaints) {
    if ((unmet & complaint.condition) != 0) return complaint.sentence;
  }
  return {};
}

/// Why the boat ignores a message addressed to it, for messages that the protocol has no refusal
/// for; empty for all others.
constexpr std::string_view refusal_of(std::uint32_t message_id) {
  switch (message_id) {
    case 82:   // SET_ATTITUDE_TARGET
    case 139:  // SET_ACTUATOR_CONTROL_TARGET
      return "use position or velocity setpoints";
    case 70:  // RC_CHANNELS_OVERRIDE
      return "RC override: use MANUAL_CONTROL";
    case 48:   // SET_GPS_GLOBAL_ORIGIN
    case 243:  // SET_HOME_POSITION
      return "origin and home cannot be set";
    case 121:  // LOG_ERASE
      return "logs cannot be erased remotely";
    default:
      return {};
  }
}

/// Copies as much of the text as fits; the rest is NUL.
template <std::size_t N>
void put_text(link::Text<N>& out, std::string_view text) {
  out = {};
  std::copy_n(text.begin(), std::min(text.size(), N), out.begin());
}

/// A named number for plots; names have up to 10 characters.
inline link::NamedValueFloat value_of(std::string_view name, float value, std::uint32_t boot_ms) {
  link::NamedValueFloat message{boot_ms, value, {}};
  put_text(message.name, name);
  return message;
}

}  // namespace flotilla::app
