// SPDX-License-Identifier: MIT
// What a boat lets others see, as Python's dictionaries.
#pragma once

#include <nanobind/nanobind.h>

#include <array>
#include <utility>

#include "app/boat.hpp"

inline constexpr std::array<std::pair<flotilla::core::Conditions, const char*>,
                            flotilla::core::kConditionCount>
    kConditionNames{{{flotilla::core::kOwnFresh, "own_fresh"},
                     {flotilla::core::kLeaderFresh, "leader_fresh"},
                     {flotilla::core::kEscsOnline, "escs_online"},
                     {flotilla::core::kBusUp, "bus_up"},
                     {flotilla::core::kSoleController, "sole_controller"},
                     {flotilla::core::kParametersSaved, "parameters_saved"},
                     {flotilla::core::kSticksFresh, "sticks_fresh"},
                     {flotilla::core::kTestRunning, "test_running"}}};

nanobind::dict snapshot_dict(const flotilla::app::Snapshot& snapshot);

/// Every parameter's value by name.
nanobind::dict parameters_dict(const flotilla::app::Parameters& parameters);
