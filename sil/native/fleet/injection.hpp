// SPDX-License-Identifier: MIT
// Maps the failures of MAV_CMD_INJECT_FAILURE to a fleet's faults.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "app/operator/requests/failure.hpp"
#include "fleet/fault.hpp"

namespace flotilla::fleet {

/// Effect of a failure: all of `clears` end first, at `esc` or everywhere; then `sets` begins.
struct Injection {
  std::span<const FaultKind> clears{};
  std::optional<std::size_t> esc{};
  std::optional<Fault> sets{};
};

/// An app::FailureJudge: kUnsupported for an unknown failure, kDenied for an unknown instance.
/// Navigation unit (GPS): OFF, STUCK, WRONG; propeller 1 port, 2 starboard (MOTOR): OFF, STUCK,
/// WRONG; radio (MAVLINK_SIGNAL): OFF, GARBAGE, INTERMITTENT; each also OK.
std::uint8_t judge(const app::Failure& failure);

/// For a failure that was accepted.
Injection injection_of(const app::Failure& failure);

}  // namespace flotilla::fleet
