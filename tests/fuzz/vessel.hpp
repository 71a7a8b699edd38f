// SPDX-License-Identifier: MIT
// The vessel of the fuzz histories, realistic enough for a boat to accept its states: surge and yaw
// follow the thrust; there is no sway. It sends its state as any navigation unit may.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "app/convert/convert_telemetry.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::fuzz {

struct Vessel {
  double north_m = 0, east_m = 0, psi = 0, u = 0, r = 0;
  std::uint8_t source = 0;    ///< one of four kinds of state message
  std::int64_t clock_us = 0;  ///< its clock − ours
  link::GpsGlobalOrigin origin{410'000'000, 20'000'000, 0, 0};

  /// For any dt: backward Euler keeps it bounded with all parameters.
  void push(const app::Parameters& p, const core::Thrust<double>& thrust_N, double dt) {
    const double X = thrust_N.port + thrust_N.stbd;
    const double N = double{p.THR_ARM} * (thrust_N.port - thrust_N.stbd);
    u = (u + dt * X / double{p.VES_M11}) / (1 + dt * double{p.VES_D11} / double{p.VES_M11});
    r = (r + dt * N / double{p.VES_M33}) / (1 + dt * double{p.VES_D33} / double{p.VES_M33});
    u = std::clamp(u, -30.0, 30.0);
    r = std::clamp(r, -3.0, 3.0);
  }

  void go(double dt) {
    north_m += dt * u * std::cos(psi);
    east_m += dt * u * std::sin(psi);
    psi = std::remainder(psi + dt * r, 6.283185307179586);
  }

  /// Calls say(message) for each message of the present state; successive states always differ.
  template <class Say>
  void tell(std::int64_t now_us, Say tell) const {
    const double noise = 1e-4 * static_cast<double>(now_us / 1000 % 37 - 18);
    const auto state = app::convert::own_state_of<double>({north_m + noise, east_m - noise, origin},
                                                          {{}, psi + noise, {u, 0, r}, {}});
    const std::int64_t stamp_us = now_us + clock_us;
    const auto boot_ms = static_cast<std::uint32_t>(stamp_us / 1000);
    switch (source % 4) {
      case 0: {
        link::Odometry odometry = app::convert::odometry_of(state, boot_ms);
        odometry.time_usec = static_cast<std::uint64_t>(stamp_us);
        return tell(odometry);
      }
      case 1:
        tell(app::convert::attitude_of(state, boot_ms));
        return tell(app::convert::local_position_of(state, boot_ms));
      case 2:
        tell(app::convert::attitude_of(state, boot_ms));
        return tell(app::convert::global_position_of(state, boot_ms));
      default:
        return tell(app::convert::follow_target_of(state, boot_ms));
    }
  }
};

}  // namespace flotilla::fuzz
