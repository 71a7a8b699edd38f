// SPDX-License-Identifier: MIT
#include "link/mavlink/read.hpp"

#include <cstring>

#include "link/mavlink/entries.hpp"

namespace flotilla::link {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// Bytes that the frame leaves out are zero.
template <class Wire, std::uint32_t kId>
Wire decoded(Bytes payload) {
  constexpr std::size_t kSize = mavlink_size<kId, Wire>();
  Wire wire;
  auto* const bytes = reinterpret_cast<std::uint8_t*>(&wire);
  if (payload.size() >= kSize) {
    std::memcpy(bytes, payload.data(), kSize);
  } else {
    std::memcpy(bytes, payload.data(), payload.size());
    std::memset(bytes + payload.size(), 0, kSize - payload.size());
  }
  return wire;
}

/// Copies a text or an array of numbers. The generated structs are packed: no reference
/// may be bound to their members.
template <class Array>
Array copy_of(const void* wire) {
  Array out;
  std::memcpy(out.data(), wire, sizeof out);
  return out;
}

Heartbeat heartbeat(Bytes payload) {
  const auto w = decoded<mavlink_heartbeat_t, MAVLINK_MSG_ID_HEARTBEAT>(payload);
  return Heartbeat{w.custom_mode, w.type, w.autopilot, w.base_mode, w.system_status};
}

Attitude attitude(Bytes payload) {
  const auto w = decoded<mavlink_attitude_t, MAVLINK_MSG_ID_ATTITUDE>(payload);
  return Attitude{w.time_boot_ms, w.roll, w.pitch, w.yaw, w.rollspeed, w.pitchspeed, w.yawspeed};
}

LocalPositionNed local_position_ned(Bytes payload) {
  const auto w = decoded<mavlink_local_position_ned_t, MAVLINK_MSG_ID_LOCAL_POSITION_NED>(payload);
  return LocalPositionNed{w.time_boot_ms, w.x, w.y, w.z, w.vx, w.vy, w.vz};
}

Odometry odometry(Bytes payload) {
  const auto w = decoded<mavlink_odometry_t, MAVLINK_MSG_ID_ODOMETRY>(payload);
  return Odometry{w.time_usec,
                  w.x,
                  w.y,
                  w.z,
                  copy_of<std::array<float, 4>>(w.q),
                  w.vx,
                  w.vy,
                  w.vz,
                  w.rollspeed,
                  w.pitchspeed,
                  w.yawspeed,
                  w.frame_id,
                  w.child_frame_id,
                  w.reset_counter,
                  w.quality};
}

GpsGlobalOrigin gps_global_origin(Bytes payload) {
  const auto w = decoded<mavlink_gps_global_origin_t, MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN>(payload);
  return GpsGlobalOrigin{w.latitude, w.longitude, w.altitude, w.time_usec};
}

Timesync timesync(Bytes payload) {
  const auto w = decoded<mavlink_timesync_t, MAVLINK_MSG_ID_TIMESYNC>(payload);
  return Timesync{w.tc1, w.ts1, timesync_target(payload)};
}

GlobalPositionInt global_position_int(Bytes payload) {
  const auto w =
      decoded<mavlink_global_position_int_t, MAVLINK_MSG_ID_GLOBAL_POSITION_INT>(payload);
  return GlobalPositionInt{w.time_boot_ms, w.lat, w.lon, w.alt, w.relative_alt,
                           w.vx,           w.vy,  w.vz,  w.hdg};
}

FollowTarget follow_target(Bytes payload) {
  const auto w = decoded<mavlink_follow_target_t, MAVLINK_MSG_ID_FOLLOW_TARGET>(payload);
  using Vector = std::array<float, 3>;
  return FollowTarget{w.timestamp,
                      w.lat,
                      w.lon,
                      w.alt,
                      copy_of<Vector>(w.vel),
                      copy_of<Vector>(w.acc),
                      copy_of<std::array<float, 4>>(w.attitude_q),
                      copy_of<Vector>(w.rates),
                      w.est_capabilities};
}

FormationReference formation_reference(Bytes payload) {
  const auto w =
      decoded<mavlink_formation_reference_t, MAVLINK_MSG_ID_FORMATION_REFERENCE>(payload);
  return FormationReference{w.time_boot_ms,
                            w.age_ms,
                            w.sequence,
                            w.root,
                            w.maker,
                            w.flags,
                            {w.latitude,
                             w.longitude,
                             w.north,
                             w.east,
                             w.heading,
                             {w.u, w.v, w.r},
                             {w.u_dot, w.v_dot, w.r_dot},
                             w.r_ddot},
                            {w.offset_north, w.offset_east},
                            copy_of<std::array<std::uint8_t, 24>>(w.path),
                            {w.offset_ahead, w.offset_starboard}};
}

SystemTime system_time(Bytes payload) {
  const auto w = decoded<mavlink_system_time_t, MAVLINK_MSG_ID_SYSTEM_TIME>(payload);
  return SystemTime{w.time_unix_usec, w.time_boot_ms};
}

CommandLong command_long(Bytes payload) {
  const auto w = decoded<mavlink_command_long_t, MAVLINK_MSG_ID_COMMAND_LONG>(payload);
  return CommandLong{w.command,
                     {w.param1, w.param2, w.param3, w.param4, w.param5, w.param6, w.param7},
                     {w.target_system, w.target_component},
                     w.confirmation};
}

CommandInt command_int(Bytes payload) {
  const auto w = decoded<mavlink_command_int_t, MAVLINK_MSG_ID_COMMAND_INT>(payload);
  return CommandInt{w.command, {w.param1, w.param2, w.param3, w.param4}, w.x,    w.y,
                    w.z,       {w.target_system, w.target_component},    w.frame};
}

CommandAck command_ack(Bytes payload) {
  const auto w = decoded<mavlink_command_ack_t, MAVLINK_MSG_ID_COMMAND_ACK>(payload);
  return CommandAck{w.command, w.result, {w.target_system, w.target_component}};
}

SetMode set_mode(Bytes payload) {
  const auto w = decoded<mavlink_set_mode_t, MAVLINK_MSG_ID_SET_MODE>(payload);
  return SetMode{w.custom_mode, w.target_system, w.base_mode};
}

ManualControl manual_control(Bytes payload) {
  const auto w = decoded<mavlink_manual_control_t, MAVLINK_MSG_ID_MANUAL_CONTROL>(payload);
  return ManualControl{w.x, w.y, w.z, w.r, w.buttons, w.target};
}

Ping ping(Bytes payload) {
  const auto w = decoded<mavlink_ping_t, MAVLINK_MSG_ID_PING>(payload);
  return Ping{w.time_usec, w.seq, {w.target_system, w.target_component}};
}

ParamRequestList param_request_list(Bytes payload) {
  const auto w = decoded<mavlink_param_request_list_t, MAVLINK_MSG_ID_PARAM_REQUEST_LIST>(payload);
  return ParamRequestList{{w.target_system, w.target_component}};
}

ParamRequestRead param_request_read(Bytes payload) {
  const auto w = decoded<mavlink_param_request_read_t, MAVLINK_MSG_ID_PARAM_REQUEST_READ>(payload);
  return ParamRequestRead{
      w.param_index, {w.target_system, w.target_component}, copy_of<Text<16>>(w.param_id)};
}

ParamSet param_set(Bytes payload) {
  const auto w = decoded<mavlink_param_set_t, MAVLINK_MSG_ID_PARAM_SET>(payload);
  return ParamSet{w.param_value,
                  {w.target_system, w.target_component},
                  copy_of<Text<16>>(w.param_id),
                  w.param_type};
}

MissionRequestList mission_request_list(Bytes payload) {
  const auto w =
      decoded<mavlink_mission_request_list_t, MAVLINK_MSG_ID_MISSION_REQUEST_LIST>(payload);
  return MissionRequestList{{w.target_system, w.target_component}, w.mission_type};
}

MissionCount mission_count(Bytes payload) {
  const auto w = decoded<mavlink_mission_count_t, MAVLINK_MSG_ID_MISSION_COUNT>(payload);
  return MissionCount{w.count, {w.target_system, w.target_component}, w.mission_type};
}

MissionClearAll mission_clear_all(Bytes payload) {
  const auto w = decoded<mavlink_mission_clear_all_t, MAVLINK_MSG_ID_MISSION_CLEAR_ALL>(payload);
  return MissionClearAll{{w.target_system, w.target_component}, w.mission_type};
}

FileTransferProtocol file_transfer_protocol(Bytes payload) {
  const auto w =
      decoded<mavlink_file_transfer_protocol_t, MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL>(payload);
  return FileTransferProtocol{{w.target_system, w.target_component},
                              copy_of<std::array<std::uint8_t, 251>>(w.payload)};
}

RadioStatus radio_status(Bytes payload) {
  return RadioStatus{decoded<mavlink_radio_status_t, MAVLINK_MSG_ID_RADIO_STATUS>(payload).txbuf};
}

Statustext statustext(Bytes payload) {
  const auto w = decoded<mavlink_statustext_t, MAVLINK_MSG_ID_STATUSTEXT>(payload);
  return Statustext{w.severity, copy_of<Text<50>>(w.text), w.id, w.chunk_seq};
}

NamedValueFloat named_value_float(Bytes payload) {
  const auto w = decoded<mavlink_named_value_float_t, MAVLINK_MSG_ID_NAMED_VALUE_FLOAT>(payload);
  return NamedValueFloat{w.time_boot_ms, w.value, copy_of<Text<10>>(w.name)};
}

}  // namespace

void read_payload(Bytes payload, std::uint32_t id, Message& out) {
  switch (id) {
    case MAVLINK_MSG_ID_HEARTBEAT:
      out = heartbeat(payload);
      return;
    case MAVLINK_MSG_ID_ATTITUDE:
      out = attitude(payload);
      return;
    case MAVLINK_MSG_ID_LOCAL_POSITION_NED:
      out = local_position_ned(payload);
      return;
    case MAVLINK_MSG_ID_ODOMETRY:
      out = odometry(payload);
      return;
    case MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN:
      out = gps_global_origin(payload);
      return;
    case MAVLINK_MSG_ID_TIMESYNC:
      out = timesync(payload);
      return;
    case MAVLINK_MSG_ID_GLOBAL_POSITION_INT:
      out = global_position_int(payload);
      return;
    case MAVLINK_MSG_ID_FOLLOW_TARGET:
      out = follow_target(payload);
      return;
    case MAVLINK_MSG_ID_FORMATION_REFERENCE:
      out = formation_reference(payload);
      return;
    case MAVLINK_MSG_ID_SYSTEM_TIME:
      out = system_time(payload);
      return;
    case MAVLINK_MSG_ID_COMMAND_LONG:
      out = command_long(payload);
      return;
    case MAVLINK_MSG_ID_COMMAND_INT:
      out = command_int(payload);
      return;
    case MAVLINK_MSG_ID_COMMAND_ACK:
      out = command_ack(payload);
      return;
    case MAVLINK_MSG_ID_SET_MODE:
      out = set_mode(payload);
      return;
    case MAVLINK_MSG_ID_MANUAL_CONTROL:
      out = manual_control(payload);
      return;
    case MAVLINK_MSG_ID_PING:
      out = ping(payload);
      return;
    case MAVLINK_MSG_ID_PARAM_REQUEST_LIST:
      out = param_request_list(payload);
      return;
    case MAVLINK_MSG_ID_PARAM_REQUEST_READ:
      out = param_request_read(payload);
      return;
    case MAVLINK_MSG_ID_PARAM_SET:
      out = param_set(payload);
      return;
    case MAVLINK_MSG_ID_MISSION_REQUEST_LIST:
      out = mission_request_list(payload);
      return;
    case MAVLINK_MSG_ID_MISSION_COUNT:
      out = mission_count(payload);
      return;
    case MAVLINK_MSG_ID_MISSION_CLEAR_ALL:
      out = mission_clear_all(payload);
      return;
    case MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL:
      out = file_transfer_protocol(payload);
      return;
    case MAVLINK_MSG_ID_RADIO_STATUS:
      out = radio_status(payload);
      return;
    case MAVLINK_MSG_ID_STATUSTEXT:
      out = statustext(payload);
      return;
    case MAVLINK_MSG_ID_NAMED_VALUE_FLOAT:
      out = named_value_float(payload);
      return;
    default:
      out = std::monostate{};
  }
}

Address timesync_target(std::span<const std::uint8_t> payload) {
  const auto byte = [&](std::size_t at) {
    return at < payload.size() ? payload[at] : std::uint8_t{0};
  };
  return {byte(MAVLINK_MSG_ID_TIMESYNC_LEN), byte(MAVLINK_MSG_ID_TIMESYNC_LEN + 1)};
}

}  // namespace flotilla::link
