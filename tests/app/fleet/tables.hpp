// SPDX-License-Identifier: MIT
// Tables of small fleets.
#pragma once

#include "app/fleet/table.hpp"

namespace flotilla::app::testing {

/// Boats 1 to 4, in line ahead, 4 m apart: 2 and 4 follow 1, 3 follows 2.
inline FleetTable table_of_four(std::uint16_t epoch, bool stop = false) {
  FleetTable table{.epoch = epoch, .stop = stop, .count = 4};
  for (std::uint8_t i = 0; i < 4; ++i) {
    table.members[i] = {.system = static_cast<std::uint8_t>(i + 1),
                        .leader = i,
                        .can_lead = true,
                        .length_dm = 13,
                        .slot_cm = {static_cast<std::int16_t>(-400 * i), 0}};
  }
  table.members[3].leader = 1;
  return table_of(message_of(table, 0));
}

}  // namespace flotilla::app::testing
