// SPDX-License-Identifier: MIT
// The failure requested by MAV_CMD_INJECT_FAILURE. Only a host that simulates the boat's
// surroundings can accept it.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "link/mavlink/mav.hpp"

namespace flotilla::app {

/// Numbers of common.xml: FAILURE_UNIT, FAILURE_TYPE, and the instance (0: all).
struct Failure {
  std::uint8_t unit = 0, type = 0, instance = 0;
  bool operator==(const Failure&) const = default;
};

/// The host's answer, a MAV_RESULT. After the tick it takes accepted failures from the boat.
using FailureJudge = std::uint8_t (*)(const Failure&);

/// Without a judge, a boat supports no injected failures.
class InjectedFailures {
 public:
  void let(FailureJudge by) { judge_ = by; }

  /// Keeps a failure that the judge accepts until it is taken. A MAV_RESULT.
  std::uint8_t answer(const Failure& failure) {
    if (judge_ == nullptr) return link::mav::kUnsupported;
    if (failure_) return link::mav::kTemporarilyRejected;
    const std::uint8_t result = judge_(failure);
    if (result == link::mav::kAccepted) failure_ = failure;
    return result;
  }

  std::optional<Failure> take() { return std::exchange(failure_, std::nullopt); }

 private:
  FailureJudge judge_ = nullptr;
  std::optional<Failure> failure_;
};

}  // namespace flotilla::app
