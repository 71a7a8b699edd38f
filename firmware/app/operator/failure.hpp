// SPDX-License-Identifier: MIT
// The failure requested by MAV_CMD_INJECT_FAILURE. Only a host that simulates the boat's
// surroundings can accept it.
#pragma once

#include <cstdint>

namespace flotilla::app {

/// Numbers of common.xml: FAILURE_UNIT, FAILURE_TYPE, and the instance (0: all).
struct Failure {
  std::uint8_t unit = 0, type = 0, instance = 0;
  bool operator==(const Failure&) const = default;
};

/// The host's answer, a MAV_RESULT. After the tick it takes accepted failures from the boat.
using FailureJudge = std::uint8_t (*)(const Failure&);

}  // namespace flotilla::app
