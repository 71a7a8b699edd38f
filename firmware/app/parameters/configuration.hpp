// SPDX-License-Identifier: MIT
// Parameters in the units and types of their consumers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "app/parameters.hpp"
#include "core/supervisor.hpp"

namespace flotilla::app {

/// Derived again after each change of a parameter, so that no tick converts one. The law's numbers,
/// in its scalar, are in convert::Law. An empty optional: the parameter is 0, the limit is off.
struct Configuration {
  /// Changes take effect at the next start.
  struct Start {
    std::uint8_t system = 0, component = 0;
    bool companion = false;
    bool ardupilot = false;  ///< MAV_AUTOPILOT 1
    std::uint8_t can_node = 0;
    std::int64_t tick_us = 0;
  };

  struct Formation {
    std::uint8_t leader = 0;
    float north_m = 0, east_m = 0;              ///< the slot
    bool turns = false;                         ///< FORM_FRAME 1
    std::optional<float> reach_m;               ///< FORM_DIST_MAX
    bool follows_root = false;                  ///< LAW_REF
    std::optional<std::int64_t> leader_lag_us;  ///< FORM_LAG_S; nothing: unknown
    std::optional<std::size_t> max_depth;
    float beam_m = 0;        ///< slots closer than this count as one
    float separation_m = 0;  ///< FS_SEP_M
    bool judges_station = false;
    std::int64_t wait_us = 0;    ///< WP_WAIT_S
    bool returns_alone = false;  ///< RTL_ALONE
  };

  /// Limits of the quality that the boat's navigation unit reports; 0: no limit.
  struct Quality {
    std::uint8_t fix = 0;  ///< least GPS_FIX_TYPE
    float hdop = 0, accuracy_m = 0, ratio = 0;
    bool operator==(const Quality&) const = default;
  };

  struct Navigation {
    std::optional<float> lag_s;        ///< NAV_LAG_S; nothing: unknown
    std::uint8_t component = 0;        ///< NAV_COMPID, 0: any
    std::optional<std::uint8_t> link;  ///< NAV_LINK; nothing: any
    Quality quality;
    std::int64_t own_limit_us = 0, leader_limit_us = 0;  ///< ages at which states are too old
  };

  struct Propulsion {
    std::uint8_t port_esc = 0, stbd_esc = 0;
    bool port_reversed = false, stbd_reversed = false;
    float ahead_N = 0, astern_N = 0;  ///< greatest thrust of one propeller
    float dead_N = 0;
    std::int64_t esc_limit_us = 0;  ///< silence after which an ESC is offline
  };

  struct Failsafes {
    core::Choices choices;
    std::int64_t coast_us = 0;
    std::optional<float> battery_V, fence_m;
  };

  struct Operators {
    std::optional<std::uint8_t> commander;     ///< the only system id that may command
    std::optional<std::uint8_t> rc_switch;     ///< RC_MODE_CH
    std::optional<std::int64_t> gcs_limit_us;  ///< silence after which ground stations are lost
    std::int64_t state_us = 0, slow_us = 0;    ///< intervals, 0: not sent
  };

  struct Plan {
    float speed_mps = 0, radius_m = 0, fastest_mps = 0;  ///< fastest: 0, no limit
    float margin_m = 0;                                  ///< to keep from the fence
    float room_m = 0, fastest_radps = 0;  ///< of a voyage that measures the hull; 0: no limit
    std::size_t homes = 0;                ///< items before the plan that are no part of it
  };

  /// How the boat comes to rest, for the fence.
  struct Stopping {
    float reaction_s = 0, brake_mps2 = 0;
    float drag_s = 0;  ///< time in which the drag takes away most of the speed
  };

  Start start;
  Formation formation;
  Plan plan;
  Stopping stopping;
  Navigation navigation;
  Propulsion propulsion;
  Failsafes failsafes;
  Operators operators;
  bool gains_fit = true;  ///< gain_fault() finds none
};

/// Parameters must be valid.
Configuration configuration_of(const Parameters& p);

}  // namespace flotilla::app
