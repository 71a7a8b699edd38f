// SPDX-License-Identifier: MIT
// What operators ask for, and what they get as an answer.
#include "link/mavlink_write.hpp"

namespace flotilla::link {

void MavlinkWriter::operator()(const CommandLong& x) const {
  put(mavlink_msg_command_long_encode_status,
      mavlink_command_long_t{x.param[0], x.param[1], x.param[2], x.param[3], x.param[4], x.param[5],
                             x.param[6], x.command, x.target.system, x.target.component,
                             x.confirmation});
}

void MavlinkWriter::operator()(const CommandInt& x) const {
  mavlink_command_int_t w{};
  w.param1 = x.param[0], w.param2 = x.param[1], w.param3 = x.param[2], w.param4 = x.param[3];
  w.x = x.x, w.y = x.y, w.z = x.z;
  w.command = x.command;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  w.frame = x.frame;
  put(mavlink_msg_command_int_encode_status, w);
}

void MavlinkWriter::operator()(const CommandAck& x) const {
  mavlink_command_ack_t w{};
  w.command = x.command;
  w.result = x.result;
  w.progress = 255;  // not used
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  put(mavlink_msg_command_ack_encode_status, w);
}

void MavlinkWriter::operator()(const SetMode& x) const {
  put(mavlink_msg_set_mode_encode_status,
      mavlink_set_mode_t{x.custom_mode, x.target_system, x.base_mode});
}

void MavlinkWriter::operator()(const ManualControl& x) const {
  mavlink_manual_control_t w{};
  w.x = x.x, w.y = x.y, w.z = x.z, w.r = x.r;
  w.buttons = x.buttons;
  w.target = x.target_system;
  put(mavlink_msg_manual_control_encode_status, w);
}

void MavlinkWriter::operator()(const Ping& x) const {
  put(mavlink_msg_ping_encode_status,
      mavlink_ping_t{x.time_usec, x.seq, x.target.system, x.target.component});
}

void MavlinkWriter::operator()(const MessageInterval& x) const {
  put(mavlink_msg_message_interval_encode_status,
      mavlink_message_interval_t{x.interval_us, x.message_id});
}

void MavlinkWriter::operator()(const ParamRequestList& x) const {
  put(mavlink_msg_param_request_list_encode_status,
      mavlink_param_request_list_t{x.target.system, x.target.component});
}

void MavlinkWriter::operator()(const ParamRequestRead& x) const {
  mavlink_param_request_read_t w{};
  w.param_index = x.param_index;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.param_id, x.param_id);
  put(mavlink_msg_param_request_read_encode_status, w);
}

void MavlinkWriter::operator()(const ParamSet& x) const {
  mavlink_param_set_t w{};
  w.param_value = x.param_value;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.param_id, x.param_id);
  w.param_type = x.param_type;
  put(mavlink_msg_param_set_encode_status, w);
}

void MavlinkWriter::operator()(const ParamValue& x) const {
  mavlink_param_value_t w{};
  w.param_value = x.param_value;
  w.param_count = x.param_count;
  w.param_index = x.param_index;
  copy(w.param_id, x.param_id);
  w.param_type = x.param_type;
  put(mavlink_msg_param_value_encode_status, w);
}

void MavlinkWriter::operator()(const ParamError& x) const {
  mavlink_param_error_t w{};
  w.param_index = x.param_index;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.param_id, x.param_id);
  w.error = x.error;
  put(mavlink_msg_param_error_encode_status, w);
}

void MavlinkWriter::operator()(const MissionRequestList& x) const {
  put(mavlink_msg_mission_request_list_encode_status,
      mavlink_mission_request_list_t{x.target.system, x.target.component, x.mission_type});
}

void MavlinkWriter::operator()(const MissionCount& x) const {
  mavlink_mission_count_t w{};
  w.count = x.count;
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  w.mission_type = x.mission_type;
  put(mavlink_msg_mission_count_encode_status, w);
}

void MavlinkWriter::operator()(const MissionClearAll& x) const {
  put(mavlink_msg_mission_clear_all_encode_status,
      mavlink_mission_clear_all_t{x.target.system, x.target.component, x.mission_type});
}

void MavlinkWriter::operator()(const MissionAck& x) const {
  mavlink_mission_ack_t w{};
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  w.type = x.type;
  w.mission_type = x.mission_type;
  put(mavlink_msg_mission_ack_encode_status, w);
}

void MavlinkWriter::operator()(const FileTransferProtocol& x) const {
  mavlink_file_transfer_protocol_t w{};
  w.target_system = x.target.system;
  w.target_component = x.target.component;
  copy(w.payload, x.payload);
  put(mavlink_msg_file_transfer_protocol_encode_status, w);
}

}  // namespace flotilla::link
