// SPDX-License-Identifier: MIT
// The failures of MAV_CMD_INJECT_FAILURE that a fleet knows, as its faults.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "app/operator/failure.hpp"
#include "fleet/fault.hpp"

namespace flotilla::fleet {

/// What a failure is: all of `clears` end first, at `esc` or everywhere; then `sets` begins.
struct Injection {
  std::span<const FaultKind> clears{};
  std::optional<std::size_t> esc{};
  std::optional<Fault> sets{};
};

/// As an app::FailureJudge: kUnsupported where there is no such failure, kDenied where there is no
/// such instance. Navigation unit (GPS): OFF, STUCK, WRONG; propeller 1 port, 2 starboard (MOTOR):
/// OFF, STUCK, WRONG; radio (MAVLINK_SIGNAL): OFF, GARBAGE, INTERMITTENT; each of them OK.
std::uint8_t judge(const app::Failure& failure);

/// Of a failure that was accepted.
Injection injection_of(const app::Failure& failure);

}  // namespace flotilla::fleet
