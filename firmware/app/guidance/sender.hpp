// SPDX-License-Identifier: MIT
// The sender of a message, as the fleet's table knows it.
#pragma once

#include <optional>

namespace flotilla::app {

struct Sender {
  bool may_claim = true;         ///< a slot of our fleet, see SlotClaims
  std::optional<float> reach_m;  ///< see Neighbours::take
};

}  // namespace flotilla::app
