// SPDX-License-Identifier: MIT
// Composes the boat's telemetry messages.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/guidance/guidance.hpp"
#include "app/plan/fence_watch.hpp"
#include "core/supervisor.hpp"
#include "link/dronecan/messages.hpp"

namespace flotilla::app {

/// The boat's state at a whole millisecond of our clock.
struct OwnReport {
  std::uint32_t time_boot_ms = 0;
  convert::OwnState state{};
  bool located = false;  ///< the local frame's origin is known
  bool adrift = false;   ///< it was known, and followers still use positions relative to it
};

/// One propeller's ESC, with its last status if that is recent.
struct EscReport {
  std::uint8_t index = 0;
  std::optional<link::EscStatus> status;
};

/// Errors and limits of the law, SI units.
struct FormationReport {
  std::optional<bool> in_slot;  ///< in FORMATION or alone, if FS_SLOT_M judges it; false closing up
  core::Error<double> error;
  core::Nu<double> nu_star;
  core::Tau<double> missing;  ///< of the wrench that the law desired
};

struct Home {
  std::int32_t latitude = 0, longitude = 0;  ///< degE7
  std::int32_t altitude_mm = 0;
};

/// The plan, as in MISSION_CURRENT.
struct PlanReport {
  std::uint16_t item = 0, count = 0;
  std::uint8_t state = 0;  ///< MISSION_STATE
  std::uint32_t id = 0, fence_id = 0, rally_id = 0;
};

/// Input of all telemetry of one tick.
struct Report {
  std::int64_t now_us = 0;
  std::int64_t unix_us = 0;  ///< 0: unknown
  core::Conditions conditions = 0;
  std::uint8_t mode = 0, intended_mode = 0;
  std::optional<OwnReport> own;              ///< while it is fresh
  std::optional<link::GpsRawInt> gps;        ///< the navigation unit's, while it is fresh
  std::optional<Home> home;                  ///< see FailsafeLimits::home()
  std::optional<FormationReport> formation;  ///< while own and leader's state are fresh, or alone
  std::optional<double> own_age_s, leader_age_s, leader_uncertainty_m;
  std::optional<link::FormationReference> reference;  ///< for followers, while it can be followed
  std::optional<PlanReport> plan;                     ///< if one is stored
  std::optional<FenceReport> fence;                   ///< if one is stored
  std::optional<double> depth;         ///< in the tree of leaders; unless FS_SEP_M is 0
  std::optional<double> separation_m;  ///< predicted, of the nearest vessel, while the law drives
  std::optional<Estimates> estimates;  ///< while the boat's state is fresh
  std::optional<float> balance, drag, yaw_damping;  ///< as learnt, while they look wrong
  core::Thrust<double> thrust{};                    ///< N, of the commands as sent
  double most_N = 0, least_N = 0;             ///< of one propeller, N; least: astern, negative
  std::uint8_t leader = 0;                    ///< system id
  std::array<EscReport, 2> escs{};            ///< port, starboard
  bool fenced = false, fence_is_off = false;  ///< by FS_FENCE_M or a stored fence
  bool battery_limited = false;               ///< by FS_BATT_V
  std::uint32_t overruns = 0;
  link::Address self{};
};

/// Whether compose() knows the message, even if it has nothing to send now.
bool can_compose(std::uint16_t id);

/// The `turn`-th message of that id, from 0 on; nothing after the last, or while there is nothing
/// to send. Messages that no stream or request may name are composed elsewhere.
std::optional<link::Message> compose(std::uint16_t id, std::uint32_t turn, const Report& report);

}  // namespace flotilla::app
