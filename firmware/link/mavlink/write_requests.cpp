// SPDX-License-Identifier: MIT
// Operators' requests and their answers.
#include "link/mavlink/write.hpp"

namespace flotilla::link {

std::size_t MavlinkWriter::operator()(const CommandLong& x) const {
  return put<MAVLINK_MSG_ID_COMMAND_LONG>(mavlink_command_long_t{
      x.param[0], x.param[1], x.param[2], x.param[3], x.param[4], x.param[5], x.param[6], x.command,
      x.target.system, x.target.component, x.confirmation});
}

std::size_t MavlinkWriter::operator()(const CommandInt& x) const {
  mavlink_command_int_t w{};
  w.param1 = x.param[0], w.param2 = x.param[1], w.param3 = x.param[2], w.param4 = x.param[3];
  w.x = x.x, w.y = x.y, w.z = x.z;
  w.command = x.command;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  w.frame = x.frame;
  return put<MAVLINK_MSG_ID_COMMAND_INT>(w);
}

std::size_t MavlinkWriter::operator()(const CommandAck& x) const {
  mavlink_command_ack_t w{};
  w.command = x.command;
  w.result = x.result;
  w.progress = 255;  // not used
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  return put<MAVLINK_MSG_ID_COMMAND_ACK>(w);
}

std::size_t MavlinkWriter::operator()(const SetMode& x) const {
  return put<MAVLINK_MSG_ID_SET_MODE>(
      mavlink_set_mode_t{x.custom_mode, x.target_system, x.base_mode});
}

std::size_t MavlinkWriter::operator()(const ManualControl& x) const {
  mavlink_manual_control_t w{};
  w.x = x.x, w.y = x.y, w.z = x.z, w.r = x.r;
  w.buttons = x.buttons;
  w.target = x.target_system;
  return put<MAVLINK_MSG_ID_MANUAL_CONTROL>(w);
}

std::size_t MavlinkWriter::operator()(const Ping& x) const {
  return put<MAVLINK_MSG_ID_PING>(
      mavlink_ping_t{x.time_usec, x.seq, x.target.system, x.target.component});
}

std::size_t MavlinkWriter::operator()(const MessageInterval& x) const {
  return put<MAVLINK_MSG_ID_MESSAGE_INTERVAL>(
      mavlink_message_interval_t{x.interval_us, x.message_id});
}

std::size_t MavlinkWriter::operator()(const ParamRequestList& x) const {
  return put<MAVLINK_MSG_ID_PARAM_REQUEST_LIST>(
      mavlink_param_request_list_t{x.target.system, x.target.component});
}

std::size_t MavlinkWriter::operator()(const ParamRequestRead& x) const {
  mavlink_param_request_read_t w{};
  w.param_index = x.param_index;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.param_id, x.param_id);
  return put<MAVLINK_MSG_ID_PARAM_REQUEST_READ>(w);
}

std::size_t MavlinkWriter::operator()(const ParamSet& x) const {
  mavlink_param_set_t w{};
  w.param_value = x.param_value;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.param_id, x.param_id);
  w.param_type = x.param_type;
  return put<MAVLINK_MSG_ID_PARAM_SET>(w);
}

std::size_t MavlinkWriter::operator()(const ParamValue& x) const {
  mavlink_param_value_t w{};
  w.param_value = x.param_value;
  w.param_count = x.param_count;
  w.param_index = x.param_index;
  copy(w.param_id, x.param_id);
  w.param_type = x.param_type;
  return put<MAVLINK_MSG_ID_PARAM_VALUE>(w);
}

std::size_t MavlinkWriter::operator()(const ParamError& x) const {
  mavlink_param_error_t w{};
  w.param_index = x.param_index;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.param_id, x.param_id);
  w.error = x.error;
  return put<MAVLINK_MSG_ID_PARAM_ERROR>(w);
}

std::size_t MavlinkWriter::operator()(const MissionRequestList& x) const {
  return put<MAVLINK_MSG_ID_MISSION_REQUEST_LIST>(
      mavlink_mission_request_list_t{x.target.system, x.target.component, x.mission_type});
}

std::size_t MavlinkWriter::operator()(const MissionCount& x) const {
  mavlink_mission_count_t w{};
  w.count = x.count;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  w.mission_type = x.mission_type;
  return put<MAVLINK_MSG_ID_MISSION_COUNT>(w);
}

std::size_t MavlinkWriter::operator()(const MissionClearAll& x) const {
  return put<MAVLINK_MSG_ID_MISSION_CLEAR_ALL>(
      mavlink_mission_clear_all_t{x.target.system, x.target.component, x.mission_type});
}

std::size_t MavlinkWriter::operator()(const MissionAck& x) const {
  mavlink_mission_ack_t w{};
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  w.type = x.type;
  w.mission_type = x.mission_type;
  return put<MAVLINK_MSG_ID_MISSION_ACK>(w);
}

std::size_t MavlinkWriter::operator()(const FileTransferProtocol& x) const {
  mavlink_file_transfer_protocol_t w{};
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.payload, x.payload);
  return put<MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL>(w);
}

}  // namespace flotilla::link
