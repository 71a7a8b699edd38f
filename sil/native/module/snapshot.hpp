// SPDX-License-Identifier: MIT
// A boat's snapshot and parameters as Python dictionaries.
#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <utility>

#include "app/boat/boat.hpp"

inline constexpr std::array<std::pair<flotilla::core::Conditions, const char*>,
                            flotilla::core::kConditionCount>
    kConditionNames{{{flotilla::core::kOwnFresh, "own_fresh"},
                     {flotilla::core::kLeaderFresh, "leader_fresh"},
                     {flotilla::core::kEscsOnline, "escs_online"},
                     {flotilla::core::kBusUp, "bus_up"},
                     {flotilla::core::kSoleController, "sole_controller"},
                     {flotilla::core::kParametersSaved, "parameters_saved"},
                     {flotilla::core::kSticksFresh, "sticks_fresh"},
                     {flotilla::core::kTestRunning, "test_running"},
                     {flotilla::core::kOwnLive, "own_live"},
                     {flotilla::core::kOwnSteady, "own_steady"},
                     {flotilla::core::kOwnPrompt, "own_prompt"},
                     {flotilla::core::kLeaderLive, "leader_live"},
                     {flotilla::core::kLeaderSteady, "leader_steady"},
                     {flotilla::core::kBoatAnswers, "boat_answers"},
                     {flotilla::core::kEscsObey, "escs_obey"},
                     {flotilla::core::kGcsHeard, "gcs_heard"},
                     {flotilla::core::kBatteryGood, "battery_good"},
                     {flotilla::core::kInsideFence, "inside_fence"},
                     {flotilla::core::kClear, "clear"},
                     {flotilla::core::kCoastRunning, "coast_running"},
                     {flotilla::core::kInRange, "in_range"},
                     {flotilla::core::kOnStation, "on_station"},
                     {flotilla::core::kLeadersEnd, "leaders_end"},
                     {flotilla::core::kSlotSound, "slot_sound"},
                     {flotilla::core::kOwnTimed, "own_timed"},
                     {flotilla::core::kLeaderTimed, "leader_timed"},
                     {flotilla::core::kOwnGood, "own_good"},
                     {flotilla::core::kSoleVessel, "sole_vessel"},
                     {flotilla::core::kSticksCentred, "sticks_centred"},
                     {flotilla::core::kLeaderNear, "leader_near"},
                     {flotilla::core::kPlanReady, "plan_ready"},
                     {flotilla::core::kHomeNear, "home_near"},
                     {flotilla::core::kLocated, "located"},
                     {flotilla::core::kGainsFit, "gains_fit"}}};
static_assert(kConditionNames.back().second != nullptr, "a condition without a name");

nanobind::dict snapshot_dict(const flotilla::app::Snapshot& snapshot);

/// Every parameter's value by name.
nanobind::dict parameters_dict(const flotilla::app::Parameters& parameters);
