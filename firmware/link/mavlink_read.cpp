// SPDX-License-Identifier: MIT
#include "link/mavlink_read.hpp"

#include <flotilla/mavlink.h>

#include <cstring>

namespace flotilla::link {
namespace {

template <class Wire, class Decode>
Wire decoded(const mavlink_message_t& m, Decode decode) {
  Wire wire{};
  decode(&m, &wire);
  return wire;
}

/// A text or an array of numbers, byte for byte. The generated structs are packed: no reference
/// may be bound to their members.
template <class Array>
Array copy_of(const void* wire) {
  Array out;
  std::memcpy(out.data(), wire, sizeof out);
  return out;
}

Message heartbeat(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_heartbeat_t>(m, mavlink_msg_heartbeat_decode);
  return Heartbeat{w.custom_mode, w.type, w.autopilot, w.base_mode, w.system_status};
}

Message attitude(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_attitude_t>(m, mavlink_msg_attitude_decode);
  return Attitude{w.time_boot_ms, w.roll, w.pitch, w.yaw, w.rollspeed, w.pitchspeed, w.yawspeed};
}

Message local_position_ned(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_local_position_ned_t>(m, mavlink_msg_local_position_ned_decode);
  return LocalPositionNed{w.time_boot_ms, w.x, w.y, w.z, w.vx, w.vy, w.vz};
}

Message odometry(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_odometry_t>(m, mavlink_msg_odometry_decode);
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

Message gps_global_origin(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_gps_global_origin_t>(m, mavlink_msg_gps_global_origin_decode);
  return GpsGlobalOrigin{w.latitude, w.longitude, w.altitude, w.time_usec};
}

Message timesync(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_timesync_t>(m, mavlink_msg_timesync_decode);
  const std::span payload(reinterpret_cast<const std::uint8_t*>(_MAV_PAYLOAD(&m)), m.len);
  return Timesync{w.tc1, w.ts1, timesync_target(payload)};
}

Message global_position_int(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_global_position_int_t>(m, mavlink_msg_global_position_int_decode);
  return GlobalPositionInt{w.time_boot_ms, w.lat, w.lon, w.alt, w.relative_alt,
                           w.vx,           w.vy,  w.vz,  w.hdg};
}

Message follow_target(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_follow_target_t>(m, mavlink_msg_follow_target_decode);
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

Message system_time(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_system_time_t>(m, mavlink_msg_system_time_decode);
  return SystemTime{w.time_unix_usec, w.time_boot_ms};
}

Message command_long(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_command_long_t>(m, mavlink_msg_command_long_decode);
  return CommandLong{w.command,
                     {w.param1, w.param2, w.param3, w.param4, w.param5, w.param6, w.param7},
                     {w.target_system, w.target_component},
                     w.confirmation};
}

Message command_int(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_command_int_t>(m, mavlink_msg_command_int_decode);
  return CommandInt{w.command, {w.param1, w.param2, w.param3, w.param4}, w.x,    w.y,
                    w.z,       {w.target_system, w.target_component},    w.frame};
}

Message command_ack(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_command_ack_t>(m, mavlink_msg_command_ack_decode);
  return CommandAck{w.command, w.result, {w.target_system, w.target_component}};
}

Message set_mode(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_set_mode_t>(m, mavlink_msg_set_mode_decode);
  return SetMode{w.custom_mode, w.target_system, w.base_mode};
}

Message manual_control(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_manual_control_t>(m, mavlink_msg_manual_control_decode);
  return ManualControl{w.x, w.y, w.z, w.r, w.buttons, w.target};
}

Message ping(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_ping_t>(m, mavlink_msg_ping_decode);
  return Ping{w.time_usec, w.seq, {w.target_system, w.target_component}};
}

Message param_request_list(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_param_request_list_t>(m, mavlink_msg_param_request_list_decode);
  return ParamRequestList{{w.target_system, w.target_component}};
}

Message param_request_read(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_param_request_read_t>(m, mavlink_msg_param_request_read_decode);
  return ParamRequestRead{
      w.param_index, {w.target_system, w.target_component}, copy_of<Text<16>>(w.param_id)};
}

Message param_set(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_param_set_t>(m, mavlink_msg_param_set_decode);
  return ParamSet{w.param_value,
                  {w.target_system, w.target_component},
                  copy_of<Text<16>>(w.param_id),
                  w.param_type};
}

Message mission_request_list(const mavlink_message_t& m) {
  const auto w =
      decoded<mavlink_mission_request_list_t>(m, mavlink_msg_mission_request_list_decode);
  return MissionRequestList{{w.target_system, w.target_component}, w.mission_type};
}

Message mission_count(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_mission_count_t>(m, mavlink_msg_mission_count_decode);
  return MissionCount{w.count, {w.target_system, w.target_component}, w.mission_type};
}

Message mission_clear_all(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_mission_clear_all_t>(m, mavlink_msg_mission_clear_all_decode);
  return MissionClearAll{{w.target_system, w.target_component}, w.mission_type};
}

Message file_transfer_protocol(const mavlink_message_t& m) {
  const auto w =
      decoded<mavlink_file_transfer_protocol_t>(m, mavlink_msg_file_transfer_protocol_decode);
  return FileTransferProtocol{{w.target_system, w.target_component},
                              copy_of<std::array<std::uint8_t, 251>>(w.payload)};
}

Message radio_status(const mavlink_message_t& m) {
  return RadioStatus{mavlink_msg_radio_status_get_txbuf(&m)};
}

Message statustext(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_statustext_t>(m, mavlink_msg_statustext_decode);
  return Statustext{w.severity, copy_of<Text<50>>(w.text), w.id, w.chunk_seq};
}

Message named_value_float(const mavlink_message_t& m) {
  const auto w = decoded<mavlink_named_value_float_t>(m, mavlink_msg_named_value_float_decode);
  return NamedValueFloat{w.time_boot_ms, w.value, copy_of<Text<10>>(w.name)};
}

Message read_message(const mavlink_message_t& m) {
  switch (m.msgid) {
    case MAVLINK_MSG_ID_HEARTBEAT:
      return heartbeat(m);
    case MAVLINK_MSG_ID_ATTITUDE:
      return attitude(m);
    case MAVLINK_MSG_ID_LOCAL_POSITION_NED:
      return local_position_ned(m);
    case MAVLINK_MSG_ID_ODOMETRY:
      return odometry(m);
    case MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN:
      return gps_global_origin(m);
    case MAVLINK_MSG_ID_TIMESYNC:
      return timesync(m);
    case MAVLINK_MSG_ID_GLOBAL_POSITION_INT:
      return global_position_int(m);
    case MAVLINK_MSG_ID_FOLLOW_TARGET:
      return follow_target(m);
    case MAVLINK_MSG_ID_SYSTEM_TIME:
      return system_time(m);
    case MAVLINK_MSG_ID_COMMAND_LONG:
      return command_long(m);
    case MAVLINK_MSG_ID_COMMAND_INT:
      return command_int(m);
    case MAVLINK_MSG_ID_COMMAND_ACK:
      return command_ack(m);
    case MAVLINK_MSG_ID_SET_MODE:
      return set_mode(m);
    case MAVLINK_MSG_ID_MANUAL_CONTROL:
      return manual_control(m);
    case MAVLINK_MSG_ID_PING:
      return ping(m);
    case MAVLINK_MSG_ID_PARAM_REQUEST_LIST:
      return param_request_list(m);
    case MAVLINK_MSG_ID_PARAM_REQUEST_READ:
      return param_request_read(m);
    case MAVLINK_MSG_ID_PARAM_SET:
      return param_set(m);
    case MAVLINK_MSG_ID_MISSION_REQUEST_LIST:
      return mission_request_list(m);
    case MAVLINK_MSG_ID_MISSION_COUNT:
      return mission_count(m);
    case MAVLINK_MSG_ID_MISSION_CLEAR_ALL:
      return mission_clear_all(m);
    case MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL:
      return file_transfer_protocol(m);
    case MAVLINK_MSG_ID_RADIO_STATUS:
      return radio_status(m);
    case MAVLINK_MSG_ID_STATUSTEXT:
      return statustext(m);
    case MAVLINK_MSG_ID_NAMED_VALUE_FLOAT:
      return named_value_float(m);
    default:
      return std::monostate{};
  }
}

}  // namespace

Message read_payload(std::span<const std::uint8_t> payload, std::uint32_t id) {
  mavlink_message_t m;  // the payload alone matters to the generated decoders
  m.msgid = id & 0xFFFFFFU;
  m.len = static_cast<std::uint8_t>(payload.size());
  auto* bytes = _MAV_PAYLOAD_NON_CONST(&m);
  std::memcpy(bytes, payload.data(), payload.size());
  std::memset(bytes + payload.size(), 0, MAVLINK_MAX_PAYLOAD_LEN - payload.size());
  return read_message(m);
}

Address timesync_target(std::span<const std::uint8_t> payload) {
  const auto byte = [&](std::size_t at) {
    return at < payload.size() ? payload[at] : std::uint8_t{0};
  };
  return {byte(MAVLINK_MSG_ID_TIMESYNC_LEN), byte(MAVLINK_MSG_ID_TIMESYNC_LEN + 1)};
}

}  // namespace flotilla::link
