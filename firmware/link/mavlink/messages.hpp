// SPDX-License-Identifier: MIT
// MAVLink messages as plain structs with the protocol's names and units (mavlink.io, common message
// set), generated from messages.txt by generate.py during the build.
#pragma once

#include <array>
#include <cstdint>

#include "dialect/messages.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::link {

/// A received message. std::monostate is one that this firmware does not read.
struct Received {
  Address from;
  Message message;
  Address target{};      ///< 0, 0 if the message names none
  std::uint32_t id = 0;  ///< message id
  std::uint8_t sequence = 0;
  bool is_signed = false;  ///< with a good signature; forged messages never get here
};

/// Whether a message is a vessel's state; these are a hundred times as frequent as all others.
inline bool tells_motion(const Message& message) {
  return std::holds_alternative<Attitude>(message) ||
         std::holds_alternative<LocalPositionNed>(message) ||
         std::holds_alternative<Odometry>(message) ||
         std::holds_alternative<GlobalPositionInt>(message) ||
         std::holds_alternative<FollowTarget>(message);
}

/// Whether the sender is a vehicle, and no ground station, companion or part of a vehicle.
[[gnu::noinline]] inline bool is_vehicle(const Heartbeat& beat) {
  // MAV_TYPE: generic, tracker, station, companion, and parts of vehicles. Source: mavlink.io.
  constexpr std::array<std::uint8_t, 22> kNone{0,  5,  6,  18, 26, 27, 30, 31, 32, 33, 34,
                                               36, 37, 38, 39, 40, 41, 42, 44, 48, 49, 50};
  bool vehicle = beat.autopilot != mav::kAutopilotInvalid;
  for (const std::uint8_t none : kNone) vehicle = vehicle && beat.type != none;
  return vehicle;
}

}  // namespace flotilla::link
