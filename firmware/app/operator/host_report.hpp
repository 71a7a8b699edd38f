// SPDX-License-Identifier: MIT
// Status reported by the host.
#pragma once

#include <cstdint>
#include <string_view>

namespace flotilla::app {

constexpr std::string_view kParametersUnsaved =
    "parameters are default or old: check and save them";
constexpr std::string_view kFenceLost = "stored fence is not usable: send or clear it";
constexpr std::string_view kFenceUnsaved = "fence could not be saved: see the host's disk";

/// State that only the host knows.
struct HostReport {
  bool bus_up = true;                 ///< the CAN interface is up and not bus-off
  std::string_view why_not_to_arm{};  ///< one of the texts above; empty: the boat may arm
  std::uint32_t overruns = 0;         ///< ticks more than a period late, since the start
  std::int64_t unix_us = 0;           ///< present time, µs since 1970; 0: unknown
  bool save_failed = false;           ///< the last attempt to save the parameters failed
  std::string_view unsaved_list{};    ///< "fence", "plan", "rally points": its last save failed
  bool stop_pressed = false;          ///< stop switch wired to the host
  std::uint8_t closed_links = 0;      ///< bit mask of MAVLink links whose device is not open
  bool clock_is_set = true;  ///< false: unix_us is a guess; the unit's SYSTEM_TIME replaces it
};

}  // namespace flotilla::app
