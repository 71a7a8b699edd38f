// SPDX-License-Identifier: MIT
// A boat that hears other vessels: their messages, and what it makes of them.
#pragma once

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "app/navigation/neighbours.hpp"
#include "app/operator/telemetry/text.hpp"

namespace flotilla::app::vessels {

inline constexpr std::uint8_t kOwn = 3, kLeader = 2;
inline constexpr std::int32_t kLatitude = 410'000'000, kLongitude = 20'000'000;
inline constexpr std::int64_t kSecond_us = 1'000'000;

inline link::Heartbeat beat(std::uint8_t type = link::mav::kTypeSurfaceBoat,
                            std::uint8_t autopilot = link::mav::kAutopilotGeneric,
                            bool steered = true) {
  return {0, type, autopilot, steered ? link::mav::kModeFlagGuided : std::uint8_t{0}, 4};
}

/// The position in degE7 at these metres from the origin; a sphere is accurate enough for metres.
inline link::GlobalPositionInt at(double north_m, double east_m, double v_north = 0,
                                  double v_east = 0) {
  const double degE7_per_m = 1e7 / 111'050;
  const double c = std::cos(41.0 / 180 * 3.14159265358979);
  return {0,
          kLatitude + static_cast<std::int32_t>(north_m * degE7_per_m),
          kLongitude + static_cast<std::int32_t>(east_m * degE7_per_m * 111'050 / 111'412 / c),
          0,
          0,
          static_cast<std::int16_t>(100 * v_north),
          static_cast<std::int16_t>(100 * v_east),
          0,
          65535};
}

struct Watch {
  Neighbours neighbours;
  convert::Position own{0, 0, {kLatitude, kLongitude, 0, 0}};

  explicit Watch(float least_m = 1.5F) { neighbours.configure(kOwn, kLeader, least_m); }

  void hear(std::uint8_t system, const link::Message& message, std::int64_t now_us = 0,
            std::uint8_t component = 1) {
    neighbours.take({{system, component}, message}, own, now_us);
  }
  /// Receives a boat at that place, with its depth in the tree.
  void meet(std::uint8_t system, double north_m, double east_m, int depth, bool steered = true) {
    hear(system, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotGeneric, steered));
    hear(system, at(north_m, east_m));
    hear(system, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotGeneric, steered));
    if (depth >= 0) tell_depth(system, static_cast<float>(depth));
  }
  void tell_depth(std::uint8_t system, float depth) {
    hear(system, link::FleetBeacon{});
    hear(system, value_of("DEPTH", depth, 0));
  }
  core::Traffic<double> look(std::int64_t now_us = 0) const {
    return neighbours.traffic(own, core::Vec2<double>{}, now_us);
  }
};

}  // namespace flotilla::app::vessels
