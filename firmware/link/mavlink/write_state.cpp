// SPDX-License-Identifier: MIT
// Messages about a vessel's motion.
#include <cstring>
#include <limits>

#include "link/mavlink/write.hpp"

namespace flotilla::link {
namespace {

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

}  // namespace

std::size_t MavlinkWriter::operator()(const Heartbeat& x) const {
  mavlink_heartbeat_t w{};
  w.custom_mode = x.custom_mode;
  w.type = x.type;
  w.autopilot = x.autopilot;
  w.base_mode = x.base_mode;
  w.system_status = x.system_status;
  w.mavlink_version = 3;
  return put<MAVLINK_MSG_ID_HEARTBEAT>(w);
}

std::size_t MavlinkWriter::operator()(const Attitude& x) const {
  return put<MAVLINK_MSG_ID_ATTITUDE>(mavlink_attitude_t{x.time_boot_ms, x.roll, x.pitch, x.yaw,
                                                         x.rollspeed, x.pitchspeed, x.yawspeed});
}

std::size_t MavlinkWriter::operator()(const LocalPositionNed& x) const {
  return put<MAVLINK_MSG_ID_LOCAL_POSITION_NED>(
      mavlink_local_position_ned_t{x.time_boot_ms, x.x, x.y, x.z, x.vx, x.vy, x.vz});
}

std::size_t MavlinkWriter::operator()(const Odometry& x) const {
  mavlink_odometry_t w{};
  w.time_usec = x.time_usec;
  w.x = x.x, w.y = x.y, w.z = x.z;
  copy(w.q, x.q);
  w.vx = x.vx, w.vy = x.vy, w.vz = x.vz;
  w.rollspeed = x.rollspeed, w.pitchspeed = x.pitchspeed, w.yawspeed = x.yawspeed;
  w.pose_covariance[0] = kUnknown;
  w.velocity_covariance[0] = kUnknown;
  w.frame_id = x.frame_id;
  w.child_frame_id = x.child_frame_id;
  w.reset_counter = x.reset_counter;
  w.quality = x.quality;
  w.estimator_type = MAV_ESTIMATOR_TYPE_AUTOPILOT;
  return put<MAVLINK_MSG_ID_ODOMETRY>(w);
}

std::size_t MavlinkWriter::operator()(const GpsGlobalOrigin& x) const {
  mavlink_gps_global_origin_t w{};
  w.latitude = x.latitude;
  w.longitude = x.longitude;
  w.altitude = x.altitude;
  w.time_usec = x.time_usec;
  return put<MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN>(w);
}

std::size_t MavlinkWriter::operator()(const Timesync& x) const {
  const mavlink_timesync_t w{x.tc1, x.ts1};
  // the generated code lacks the target's two bytes
  std::array<std::uint8_t, sizeof w + 2> payload{};
  std::memcpy(payload.data(), &w, sizeof w);
  payload[sizeof w] = x.target.system;
  payload[sizeof w + 1] = x.target.component;
  return frame(MAVLINK_MSG_ID_TIMESYNC, MAVLINK_MSG_ID_TIMESYNC_CRC, payload);
}

std::size_t MavlinkWriter::operator()(const GlobalPositionInt& x) const {
  return put<MAVLINK_MSG_ID_GLOBAL_POSITION_INT>(mavlink_global_position_int_t{
      x.time_boot_ms, x.lat, x.lon, x.alt, x.relative_alt, x.vx, x.vy, x.vz, x.hdg});
}

std::size_t MavlinkWriter::operator()(const FollowTarget& x) const {
  mavlink_follow_target_t w{};
  w.timestamp = x.timestamp;
  w.lat = x.lat;
  w.lon = x.lon;
  w.alt = x.alt;
  copy(w.vel, x.vel);
  copy(w.acc, x.acc);
  copy(w.attitude_q, x.q);
  copy(w.rates, x.rates);
  w.est_capabilities = x.est_capabilities;
  return put<MAVLINK_MSG_ID_FOLLOW_TARGET>(w);
}

std::size_t MavlinkWriter::operator()(const FormationReference& x) const {
  mavlink_formation_reference_t w{};
  w.time_boot_ms = x.time_boot_ms;
  w.age_ms = x.age_ms;
  w.sequence = x.sequence;
  w.root = x.root, w.maker = x.maker;
  w.flags = x.flags;
  const ReferenceMotion& m = x.motion;
  w.latitude = m.latitude, w.longitude = m.longitude;
  w.north = m.north, w.east = m.east;
  w.heading = m.heading;
  w.u = m.nu[0], w.v = m.nu[1], w.r = m.nu[2];
  w.u_dot = m.nu_dot[0], w.v_dot = m.nu_dot[1], w.r_dot = m.nu_dot[2];
  w.r_ddot = m.r_ddot;
  w.offset_north = x.offset_n[0], w.offset_east = x.offset_n[1];
  copy(w.path, x.path);
  w.offset_ahead = x.offset_b[0], w.offset_starboard = x.offset_b[1];
  return put<MAVLINK_MSG_ID_FORMATION_REFERENCE>(w);
}

std::size_t MavlinkWriter::operator()(const SystemTime& x) const {
  return put<MAVLINK_MSG_ID_SYSTEM_TIME>(mavlink_system_time_t{x.time_unix_usec, x.time_boot_ms});
}

std::size_t MavlinkWriter::operator()(const HomePosition& x) const {
  mavlink_home_position_t w{};
  w.latitude = x.latitude;
  w.longitude = x.longitude;
  w.altitude = x.altitude;
  w.x = x.x, w.y = x.y, w.z = x.z;
  static_assert(sizeof w.q == sizeof x.q);
  std::memcpy(w.q, x.q.data(), sizeof w.q);  // packed: no reference may bind to it
  w.time_usec = x.time_usec;
  return put<MAVLINK_MSG_ID_HOME_POSITION>(w);
}

std::size_t MavlinkWriter::operator()(const NavControllerOutput& x) const {
  mavlink_nav_controller_output_t w{};
  w.xtrack_error = x.xtrack_error;
  w.nav_bearing = x.nav_bearing;
  w.target_bearing = x.target_bearing;
  w.wp_dist = x.wp_dist;
  return put<MAVLINK_MSG_ID_NAV_CONTROLLER_OUTPUT>(w);
}

std::size_t MavlinkWriter::operator()(const PositionTargetLocalNed& x) const {
  mavlink_position_target_local_ned_t w{};
  w.time_boot_ms = x.time_boot_ms;
  w.x = x.x, w.y = x.y, w.z = x.z;
  w.vx = x.vx, w.vy = x.vy, w.vz = x.vz;
  w.yaw = x.yaw, w.yaw_rate = x.yaw_rate;
  w.type_mask = x.type_mask;
  w.coordinate_frame = x.coordinate_frame;
  return put<MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED>(w);
}

std::size_t MavlinkWriter::operator()(const ExtendedSysState& x) const {
  return put<MAVLINK_MSG_ID_EXTENDED_SYS_STATE>(
      mavlink_extended_sys_state_t{x.vtol_state, x.landed_state});
}

}  // namespace flotilla::link
