// SPDX-License-Identifier: MIT
// MAVLink messages as plain structs with the protocol's names, units and order. Source: mavlink.io
// common message set; only fields that this firmware reads or sends. Texts are NUL-padded; one that
// fills its array has no NUL.
#pragma once

#include <array>
#include <cstdint>
#include <variant>

#include "link/mavlink/mav.hpp"

namespace flotilla::link {

/// Sender or addressee of a message; 0 is everybody.
struct Address {
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  bool operator==(const Address&) const = default;
};

template <std::size_t N>
using Text = std::array<char, N>;

// Vessels report their motion.

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
  std::uint8_t reset_counter = 0;  ///< changes when the estimate jumps
  std::int8_t quality = 0;         ///< %, 0: unknown, negative: the estimator has failed
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
  Address target{};  ///< in answers; 0, 0 from a sender without targets
};

struct GlobalPositionInt {
  std::uint32_t time_boot_ms;
  std::int32_t lat, lon;           ///< degE7
  std::int32_t alt, relative_alt;  ///< mm
  std::int16_t vx, vy, vz;         ///< cm/s, north east down
  std::uint16_t hdg;               ///< cdeg, 65535: unknown
};

struct FollowTarget {
  std::uint64_t timestamp;        ///< ms, epoch unspecified
  std::int32_t lat, lon;          ///< degE7
  float alt;                      ///< m above mean sea level
  std::array<float, 3> vel, acc;  ///< m/s, m/s², north east down
  std::array<float, 4> q;         ///< w x y z, body to north east down
  std::array<float, 3> rates;     ///< body rates, rad/s
  std::uint8_t est_capabilities;  ///< mav::kFollow… bits: known fields
};

/// A vessel's position and motion. Units: lengths 1/1024 m, velocities 1/1024 m/s, accelerations
/// 1/1024 m/s²; heading 1/8192 rad, r 1/4096 rad/s, its derivatives 1/1024 rad/s² and rad/s³.
struct ReferenceMotion {
  std::int32_t latitude, longitude;        ///< degE7, origin of the plane of the next two
  std::int32_t north, east;                ///< from that origin
  std::int16_t heading;                    ///< clockwise from that plane's north
  std::array<std::int16_t, 3> nu, nu_dot;  ///< u v r over ground, their rates of change
  std::int16_t r_ddot;                     ///< rate of change of ṙ
};

struct FormationReference {
  std::uint32_t time_boot_ms;            ///< when the message is sent
  std::uint16_t age_ms;                  ///< age of the motion at time_boot_ms
  std::uint16_t sequence;                ///< the maker's sequence number
  std::uint8_t root, maker;              ///< system ids: whose motion it is, who first sent it
  std::uint8_t flags;                    ///< mav::kReference… bits
  ReferenceMotion motion;                ///< of the root
  std::array<std::int32_t, 2> offset_n;  ///< sender's slot: the part that keeps its bearing
  std::array<std::uint8_t, 24> path;     ///< from the sender's leader up, 0 after the last
  std::array<std::int32_t, 2> offset_b;  ///< the part that turns with the root
};

struct SystemTime {
  std::uint64_t time_unix_usec;
  std::uint32_t time_boot_ms;
};

struct HomePosition {
  std::int32_t latitude, longitude;  ///< degE7
  std::int32_t altitude;             ///< mm
  float x, y, z;                     ///< m from the local origin
  std::array<float, 4> q;
  std::uint64_t time_usec;
};

// Operators' requests.

struct CommandLong {
  std::uint16_t command;
  std::array<float, 7> param;
  Address target;
  std::uint8_t confirmation;
};

struct CommandInt {
  std::uint16_t command;
  std::array<float, 4> param;  ///< 1 … 4
  std::int32_t x, y;           ///< param 5 and 6
  float z;                     ///< param 7
  Address target;
  std::uint8_t frame;
};

struct CommandAck {
  std::uint16_t command;
  std::uint8_t result;
  Address target;
};

struct SetMode {
  std::uint32_t custom_mode;
  std::uint8_t target_system;
  std::uint8_t base_mode;
};

struct ManualControl {
  std::int16_t x, y, z, r;  ///< −1000 … 1000, 32767: axis not used
  std::uint16_t buttons;
  std::uint8_t target_system;
};

struct Ping {
  std::uint64_t time_usec;
  std::uint32_t seq;
  Address target;  ///< 0, 0 in a request
};

struct MessageInterval {
  std::int32_t interval_us;  ///< −1: disabled, 0: not available
  std::uint16_t message_id;
};

struct ParamRequestList {
  Address target;
};

struct ParamRequestRead {
  std::int16_t param_index;  ///< −1: by name
  Address target;
  Text<16> param_id;
};

struct ParamSet {
  float param_value;
  Address target;
  Text<16> param_id;
  std::uint8_t param_type;
};

struct ParamValue {
  float param_value;
  std::uint16_t param_count, param_index;
  Text<16> param_id;
  std::uint8_t param_type;
};

struct ParamError {
  std::int16_t param_index;
  Address target;
  Text<16> param_id;
  std::uint8_t error;
};

struct MissionRequestList {
  Address target;
  std::uint8_t mission_type;
};

struct MissionCount {
  std::uint16_t count;
  Address target;
  std::uint8_t mission_type;
};

struct MissionClearAll {
  Address target;
  std::uint8_t mission_type;
};

struct MissionAck {
  Address target;
  std::uint8_t type;
  std::uint8_t mission_type;
};

struct FileTransferProtocol {
  Address target;
  std::array<std::uint8_t, 251> payload;
};

struct RadioStatus {
  std::uint8_t txbuf;  ///< free share of the radio's send buffer, %
};

// The boat's answers and its health.

struct Statustext {
  std::uint8_t severity;
  Text<50> text;
  std::uint16_t id = 0;  ///< equal in all chunks of a longer text, else 0
  std::uint8_t chunk_seq = 0;
};

struct NamedValueFloat {
  std::uint32_t time_boot_ms;
  float value;
  Text<10> name;
};

struct SysStatus {
  std::uint32_t sensors_present, sensors_enabled, sensors_health;  ///< mav::kSensor… bits
  std::uint16_t load;                                              ///< ‰
  std::uint16_t voltage_battery;                                   ///< mV, 65535: unknown
  std::int16_t current_battery;                                    ///< cA, −1: unknown
  std::int8_t battery_remaining;                                   ///< %, −1: unknown
};

struct AutopilotVersion {
  std::uint64_t capabilities;
  std::uint64_t uid;
  std::uint32_t flight_sw_version;
  std::array<std::uint8_t, 8> flight_custom_version;
};

struct ProtocolVersion {
  std::uint16_t version, min_version, max_version;
};

struct ComponentInformationBasic {
  std::uint32_t time_boot_ms;
  std::uint64_t capabilities;
  Text<32> vendor_name, model_name;
  Text<24> software_version;
};

struct ComponentMetadata {
  std::uint32_t time_boot_ms;
  std::uint32_t file_crc;
  Text<100> uri;
};

struct AvailableModes {
  std::uint8_t number_modes, mode_index;  ///< from 1
  std::uint8_t standard_mode;
  std::uint32_t custom_mode;
  std::uint32_t properties;
  Text<35> mode_name;
};

struct CurrentMode {
  std::uint8_t standard_mode;
  std::uint32_t custom_mode, intended_custom_mode;
};

struct MavEscInfo {
  std::uint8_t index;  ///< of the first of four
  std::uint64_t time_usec;
  std::uint16_t counter;
  std::uint8_t count, connection_type, info;
  std::array<std::uint32_t, 4> error_count;
  std::array<std::int16_t, 4> temperature;  ///< c°C, 32767: unknown
};

struct MavEscStatus {
  std::uint8_t index;  ///< of the first of four
  std::uint64_t time_usec;
  std::array<std::int32_t, 4> rpm;
  std::array<float, 4> voltage, current;  ///< V, A
};

struct NavControllerOutput {
  std::int16_t nav_bearing, target_bearing;  ///< deg
  std::uint16_t wp_dist;                     ///< m
  float xtrack_error;                        ///< m
};

struct PositionTargetLocalNed {
  std::uint32_t time_boot_ms;
  std::uint8_t coordinate_frame;
  std::uint16_t type_mask;  ///< set bits: fields to ignore
  float x, y, z, vx, vy, vz, yaw, yaw_rate;
};

struct BatteryStatus {
  std::uint16_t voltage_mV;  ///< of the whole battery, 65535: unknown
  std::int16_t current_cA;   ///< −1: unknown
};

struct ExtendedSysState {
  std::uint8_t vtol_state, landed_state;
};

using Message =
    std::variant<std::monostate, Heartbeat, Attitude, LocalPositionNed, Odometry, GpsGlobalOrigin,
                 Timesync, GlobalPositionInt, FollowTarget, FormationReference, SystemTime,
                 HomePosition, CommandLong, CommandInt, CommandAck, SetMode, ManualControl, Ping,
                 MessageInterval, ParamRequestList, ParamRequestRead, ParamSet, ParamValue,
                 ParamError, MissionRequestList, MissionCount, MissionClearAll, MissionAck,
                 FileTransferProtocol, RadioStatus, Statustext, NamedValueFloat, SysStatus,
                 AutopilotVersion, ProtocolVersion, ComponentInformationBasic, ComponentMetadata,
                 AvailableModes, CurrentMode, MavEscInfo, MavEscStatus, NavControllerOutput,
                 PositionTargetLocalNed, BatteryStatus, ExtendedSysState>;

/// A received message. std::monostate is one that this firmware does not read.
struct Received {
  Address from;
  Message message;
  Address target{};      ///< where the message names one, else 0, 0
  std::uint32_t id = 0;  ///< message id
  std::uint8_t sequence = 0;
  bool is_signed = false;  ///< with a good signature; forged messages are dropped before
};

}  // namespace flotilla::link
