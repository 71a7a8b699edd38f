// SPDX-License-Identifier: MIT
// Messages to MAVLink 2 frames, by the generated entry points that keep their state in `status`.
// Fields that our structs lack are zero, or what the protocol calls unknown.
#pragma once

#include <flotilla/mavlink.h>

#include <algorithm>
#include <array>

#include "link/messages.hpp"

namespace flotilla::link {

/// An array into a field that has as many elements of the same type, or it does not compile.
template <class T, std::size_t kCount>
void copy(T (&field)[kCount], const std::array<T, kCount>& from) {
  std::copy(from.begin(), from.end(), field);
}

/// Writes a message into `m`, as a visitor of link::Message.
struct MavlinkWriter {
  Address self;
  mavlink_status_t& status;
  mavlink_message_t& m;

  template <class Wire, class Encode>
  void put(Encode encode, const Wire& wire) const {
    encode(self.system, self.component, &status, &m, &wire);
  }

  void operator()(std::monostate) const {}

  // mavlink_write_state.cpp
  void operator()(const Heartbeat& x) const;
  void operator()(const Attitude& x) const;
  void operator()(const LocalPositionNed& x) const;
  void operator()(const Odometry& x) const;
  void operator()(const GpsGlobalOrigin& x) const;
  void operator()(const Timesync& x) const;
  void operator()(const GlobalPositionInt& x) const;
  void operator()(const FollowTarget& x) const;
  void operator()(const SystemTime& x) const;
  void operator()(const HomePosition& x) const;
  void operator()(const NavControllerOutput& x) const;
  void operator()(const PositionTargetLocalNed& x) const;
  void operator()(const ExtendedSysState& x) const;

  // mavlink_write_requests.cpp
  void operator()(const CommandLong& x) const;
  void operator()(const CommandInt& x) const;
  void operator()(const CommandAck& x) const;
  void operator()(const SetMode& x) const;
  void operator()(const ManualControl& x) const;
  void operator()(const Ping& x) const;
  void operator()(const MessageInterval& x) const;
  void operator()(const ParamRequestList& x) const;
  void operator()(const ParamRequestRead& x) const;
  void operator()(const ParamSet& x) const;
  void operator()(const ParamValue& x) const;
  void operator()(const ParamError& x) const;
  void operator()(const MissionRequestList& x) const;
  void operator()(const MissionCount& x) const;
  void operator()(const MissionClearAll& x) const;
  void operator()(const MissionAck& x) const;
  void operator()(const FileTransferProtocol& x) const;

  // mavlink_write_health.cpp
  void operator()(const RadioStatus& x) const;
  void operator()(const Statustext& x) const;
  void operator()(const NamedValueFloat& x) const;
  void operator()(const SysStatus& x) const;
  void operator()(const AutopilotVersion& x) const;
  void operator()(const ProtocolVersion& x) const;
  void operator()(const ComponentInformationBasic& x) const;
  void operator()(const ComponentMetadata& x) const;
  void operator()(const AvailableModes& x) const;
  void operator()(const CurrentMode& x) const;
  void operator()(const MavEscInfo& x) const;
  void operator()(const MavEscStatus& x) const;
  void operator()(const BatteryStatus& x) const;
};

}  // namespace flotilla::link
