// SPDX-License-Identifier: MIT
// MAVLink messages as plain structs: the protocol's names, units and order; nothing is decided
// here. Source: mavlink.io common message set; only fields that somebody in this firmware reads or
// sends.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <variant>

namespace flotilla::link {

struct Heartbeat {
  std::uint32_t custom_mode;
  std::uint8_t type;
  std::uint8_t autopilot;
  std::uint8_t base_mode;
  std::uint8_t system_status;
};

struct Attitude {
  std::uint32_t time_boot_ms;
  float roll, pitch, yaw;                 ///< rad
  float rollspeed, pitchspeed, yawspeed;  ///< body rates, rad/s
};

struct LocalPositionNed {
  std::uint32_t time_boot_ms;
  float x, y, z;     ///< m from the sender's own origin
  float vx, vy, vz;  ///< m/s
};

struct Odometry {
  std::uint64_t time_usec;  ///< since boot or 1970
  float x, y, z;            ///< m, in frame_id
  std::array<float, 4> q;   ///< w x y z, body to frame_id
  float vx, vy, vz;         ///< m/s, in child_frame_id
  float rollspeed, pitchspeed, yawspeed;
  std::uint8_t frame_id;
  std::uint8_t child_frame_id;
};

struct GpsGlobalOrigin {
  std::int32_t latitude;   ///< degE7
  std::int32_t longitude;  ///< degE7
  std::int32_t altitude;   ///< mm
  std::uint64_t time_usec;
};

struct Timesync {
  std::int64_t tc1;  ///< ns, 0 in a request
  std::int64_t ts1;  ///< ns, returned unchanged
};

struct CommandLong {
  std::uint16_t command;
  std::array<float, 7> param;
  std::uint8_t target_system;
  std::uint8_t target_component;
  std::uint8_t confirmation;
};

struct CommandAck {
  std::uint16_t command;
  std::uint8_t result;
  std::uint8_t target_system;
  std::uint8_t target_component;
};

struct Statustext {
  std::uint8_t severity;
  std::array<char, 50> text;  ///< NUL-padded; 50 characters have no NUL
};

struct NamedValueFloat {
  std::uint32_t time_boot_ms;
  float value;
  std::array<char, 10> name;  ///< NUL-padded
};

using Message =
    std::variant<std::monostate, Heartbeat, Attitude, LocalPositionNed, Odometry, GpsGlobalOrigin,
                 Timesync, CommandLong, CommandAck, Statustext, NamedValueFloat>;

struct Sender {
  std::uint8_t system = 0;
  std::uint8_t component = 0;
};

/// A message as it came: who sent it and what. std::monostate is one that nobody here reads.
struct Received {
  Sender from;
  Message message;
};

/// The protocol's numbers that this firmware uses.
namespace mav {
constexpr std::uint8_t kTypeGeneric = 0, kTypeSurfaceBoat = 11, kAutopilotGeneric = 0;
constexpr std::uint8_t kModeFlagCustom = 1, kModeFlagArmed = 128;
constexpr std::uint8_t kStateStandby = 3, kStateActive = 4, kStateEmergency = 6;
constexpr std::uint8_t kFrameLocalNed = 1, kFrameLocalEnu = 4, kFrameBodyNed = 8,
                       kFrameBodyOffsetNed = 9, kFrameBodyFrd = 12;
constexpr std::uint16_t kCmdDoSetMode = 176, kCmdPreflightStorage = 245,
                        kCmdComponentArmDisarm = 400;
constexpr std::uint8_t kAccepted = 0, kTemporarilyRejected = 1, kDenied = 2, kUnsupported = 3;
constexpr std::uint8_t kSeverityError = 3, kSeverityWarning = 4, kSeverityInfo = 6;
}  // namespace mav

}  // namespace flotilla::link
