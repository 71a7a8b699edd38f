// SPDX-License-Identifier: MIT
// What the boat tells about itself, message by message.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/guidance/pilot.hpp"
#include "core/supervisor.hpp"
#include "link/dronecan/messages.hpp"

namespace flotilla::app {

/// The own state at a whole millisecond of our clock.
struct OwnReport {
  std::uint32_t time_boot_ms = 0;
  convert::OwnState state{};
  bool located = false;  ///< where on the globe the local frame's origin is, is known
  bool adrift = false;   ///< it was, and followers still take positions from there
};

/// Of both propellers' ESCs, where they are heard.
struct EscReport {
  std::uint8_t index = 0;
  std::optional<link::EscStatus> status;
};

/// Errors and limits of the law, SI units.
struct FormationReport {
  std::optional<bool> in_slot;  ///< in FORMATION, where FS_SLOT_M judges it; else it closes up
  core::Error<double> error;
  core::Nu<double> nu_star;
  core::Tau<double> missing;  ///< of the wrench that the law asked for
};

struct Home {
  std::int32_t latitude = 0, longitude = 0;  ///< degE7
  std::int32_t altitude_mm = 0;
};

/// All that telemetry is made of, of one tick.
struct Report {
  std::int64_t now_us = 0;
  std::int64_t unix_us = 0;  ///< 0: unknown
  core::Conditions conditions = 0;
  std::uint8_t mode = 0, intended_mode = 0;
  std::optional<OwnReport> own;              ///< while it is fresh
  std::optional<Home> home;                  ///< where the boat was first seen, then last armed
  std::optional<FormationReport> formation;  ///< while own and leader's state are fresh
  std::optional<double> own_age_s, leader_age_s, leader_uncertainty_m;
  std::optional<link::FormationReference> reference;  ///< for others, while it can be followed
  std::optional<double> depth;         ///< in the tree of leaders; while FS_SEP_M is not 0
  std::optional<double> separation_m;  ///< predicted, of the nearest vessel, while the law drives
  std::optional<Estimates> estimates;  ///< while the own state is fresh
  core::Thrust<double> thrust{};       ///< N, of the commands as sent
  double most_N = 0, least_N = 0;      ///< of one propeller, least: astern, negative
  std::uint8_t leader = 0;             ///< system id
  std::array<EscReport, 2> escs{};     ///< port, starboard
  bool fenced = false, battery_limited = false;  ///< by FS_FENCE_M, FS_BATT_V
  std::uint32_t overruns = 0;
  link::Address self{};
};

/// Whether there is such a message at all, though perhaps nothing to tell now.
bool can_compose(std::uint16_t id);

/// The `turn`-th message of that id, from 0 on; nothing after the last, or while there is nothing
/// to tell. What no stream or request may name is not made here.
std::optional<link::Message> compose(std::uint16_t id, std::uint32_t turn, const Report& report);

}  // namespace flotilla::app
