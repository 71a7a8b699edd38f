// SPDX-License-Identifier: MIT
// Decodes the setpoints of scripts: SET_POSITION_TARGET_LOCAL_NED and SET_POSITION_TARGET_GLOBAL_INT.
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

/// own: must have a known place; its origin is also that of local places.
Setpoint setpoint_of(const link::SetPositionTargetLocalNed& message, const convert::OwnState& own);
Setpoint setpoint_of(const link::SetPositionTargetGlobalInt& message);

}  // namespace flotilla::app
