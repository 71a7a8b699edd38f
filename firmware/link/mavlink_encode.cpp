// SPDX-License-Identifier: MIT
#include "link/mavlink_encode.hpp"

#include <flotilla/mavlink.h>

#include <algorithm>

namespace flotilla::link {
namespace {

/// Packs each message with the generated entry points that keep their state in `status`.
struct Packer {
  Address self;
  mavlink_status_t& status;
  mavlink_message_t& m;

  template <class Wire, class Encode>
  void put(Encode encode, const Wire& wire) const {
    encode(self.system, self.component, &status, &m, &wire);
  }

  template <class Unpacked>
  void operator()(const Unpacked&) const {
    m.len = 0;
  }
  void operator()(const std::monostate&) const {}
  void operator()(const Heartbeat& h) const {
    mavlink_heartbeat_t w{};
    w.custom_mode = h.custom_mode;
    w.type = h.type;
    w.autopilot = h.autopilot;
    w.base_mode = h.base_mode;
    w.system_status = h.system_status;
    w.mavlink_version = 3;
    put(mavlink_msg_heartbeat_encode_status, w);
  }
  void operator()(const Attitude& a) const {
    put(mavlink_msg_attitude_encode_status,
        mavlink_attitude_t{a.time_boot_ms, a.roll, a.pitch, a.yaw, a.rollspeed, a.pitchspeed,
                           a.yawspeed});
  }
  void operator()(const LocalPositionNed& p) const {
    put(mavlink_msg_local_position_ned_encode_status,
        mavlink_local_position_ned_t{p.time_boot_ms, p.x, p.y, p.z, p.vx, p.vy, p.vz});
  }
  void operator()(const Odometry& o) const {
    mavlink_odometry_t w{};
    w.time_usec = o.time_usec;
    w.x = o.x, w.y = o.y, w.z = o.z;
    std::copy(o.q.begin(), o.q.end(), w.q);
    w.vx = o.vx, w.vy = o.vy, w.vz = o.vz;
    w.rollspeed = o.rollspeed, w.pitchspeed = o.pitchspeed, w.yawspeed = o.yawspeed;
    w.frame_id = o.frame_id;
    w.child_frame_id = o.child_frame_id;
    put(mavlink_msg_odometry_encode_status, w);
  }
  void operator()(const GpsGlobalOrigin& g) const {
    mavlink_gps_global_origin_t w{};
    w.latitude = g.latitude;
    w.longitude = g.longitude;
    w.altitude = g.altitude;
    w.time_usec = g.time_usec;
    put(mavlink_msg_gps_global_origin_encode_status, w);
  }
  void operator()(const Timesync& t) const {
    mavlink_timesync_t w{};
    w.tc1 = t.tc1;
    w.ts1 = t.ts1;
    put(mavlink_msg_timesync_encode_status, w);
  }
  void operator()(const CommandLong& c) const {
    put(mavlink_msg_command_long_encode_status,
        mavlink_command_long_t{c.param[0], c.param[1], c.param[2], c.param[3], c.param[4],
                               c.param[5], c.param[6], c.command, c.target.system,
                               c.target.component, c.confirmation});
  }
  void operator()(const CommandAck& a) const {
    mavlink_command_ack_t w{};
    w.command = a.command;
    w.result = a.result;
    w.progress = 255;  // not used
    w.target_system = a.target.system;
    w.target_component = a.target.component;
    put(mavlink_msg_command_ack_encode_status, w);
  }
  void operator()(const NamedValueFloat& n) const {
    mavlink_named_value_float_t w{};
    w.time_boot_ms = n.time_boot_ms;
    w.value = n.value;
    std::copy(n.name.begin(), n.name.end(), w.name);
    put(mavlink_msg_named_value_float_encode_status, w);
  }
  void operator()(const Statustext& t) const {
    mavlink_statustext_t w{};
    w.severity = t.severity;
    std::copy(t.text.begin(), t.text.end(), w.text);
    put(mavlink_msg_statustext_encode_status, w);
  }
};

}  // namespace

std::size_t MavlinkEncoder::encode(const Message& message, std::span<std::uint8_t> out) {
  if (std::holds_alternative<std::monostate>(message)) return 0;
  mavlink_status_t status{};
  status.current_tx_seq = sequence_;
  mavlink_message_t m;
  std::visit(Packer{self_, status, m}, message);
  const std::size_t length = MAVLINK_NUM_NON_PAYLOAD_BYTES + std::size_t{m.len};
  if (length > out.size()) return 0;
  sequence_ = status.current_tx_seq;
  return mavlink_msg_to_send_buffer(out.data(), &m);
}

}  // namespace flotilla::link
