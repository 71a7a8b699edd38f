// SPDX-License-Identifier: MIT
// Decodes the setpoints of scripts: SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT.
#pragma once

#include <optional>
#include <string_view>

#include "app/convert/convert_telemetry.hpp"
#include "app/plan/errand.hpp"
#include "core/drive.hpp"

namespace flotilla::app {

/// A place or velocities; if neither, `why` gives the error.
struct Setpoint {
  std::optional<Target> target{};
  std::optional<core::Drive<double>> drive{};
  std::string_view why{};
};

/// own: its place must be known; local places count from its origin.
Setpoint setpoint_of(const link::SetPositionTargetLocalNed& message, const convert::OwnState& own);
Setpoint setpoint_of(const link::SetPositionTargetGlobalInt& message);

}  // namespace flotilla::app
