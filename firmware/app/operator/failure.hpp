// SPDX-License-Identifier: MIT
// What MAV_CMD_INJECT_FAILURE asks for. Only a host that simulates what is around the boat can
// answer it.
#pragma once

#include <cstdint>

namespace flotilla::app {

/// Numbers of common.xml: FAILURE_UNIT, FAILURE_TYPE, which one of several (0: all).
struct Failure {
  std::uint8_t unit = 0, type = 0, instance = 0;
  bool operator==(const Failure&) const = default;
};

/// The host's answer, a MAV_RESULT. What it accepts it takes out of the boat after the tick.
using FailureJudge = std::uint8_t (*)(const Failure&);

}  // namespace flotilla::app
