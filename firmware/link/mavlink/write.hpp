// SPDX-License-Identifier: MIT
// Messages to MAVLink 2 frames. The generated structs define the layout; frames are assembled here,
// since the generated code copies every payload three times and computes its CRC bit by bit. Fields
// that our structs lack are zero, or the protocol's value for unknown.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/mavlink/entries.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::link {

/// Copies an array into a field of the same type and length; others do not compile.
template <class T, std::size_t kCount>
void copy(T (&field)[kCount], const std::array<T, kCount>& from) {
  std::copy(from.begin(), from.end(), field);
}

/// A visitor of link::Message that writes it as a frame. Each call returns the frame's length
/// without the signature block, or 0 where `out` is too short for both.
struct MavlinkWriter {
  Address self;
  std::uint8_t sequence;
  bool is_signed;
  std::span<std::uint8_t> out;

  template <std::uint32_t kId, class Wire>
  std::size_t put(const Wire& wire) const {
    return frame(kId, mavlink_entry(kId)->crc_extra,
                 {reinterpret_cast<const std::uint8_t*>(&wire), mavlink_size<kId, Wire>()});
  }

  std::size_t frame(std::uint32_t id, std::uint8_t crc_extra,
                    std::span<const std::uint8_t> payload) const;

  std::size_t operator()(std::monostate) const { return 0; }

  // write_state.cpp
  std::size_t operator()(const Heartbeat& x) const;
  std::size_t operator()(const Attitude& x) const;
  std::size_t operator()(const LocalPositionNed& x) const;
  std::size_t operator()(const Odometry& x) const;
  std::size_t operator()(const GpsGlobalOrigin& x) const;
  std::size_t operator()(const Timesync& x) const;
  std::size_t operator()(const GlobalPositionInt& x) const;
  std::size_t operator()(const FollowTarget& x) const;
  std::size_t operator()(const FormationReference& x) const;
  std::size_t operator()(const SystemTime& x) const;
  std::size_t operator()(const HomePosition& x) const;
  std::size_t operator()(const NavControllerOutput& x) const;
  std::size_t operator()(const PositionTargetLocalNed& x) const;
  std::size_t operator()(const ExtendedSysState& x) const;

  // write_requests.cpp
  std::size_t operator()(const CommandLong& x) const;
  std::size_t operator()(const CommandInt& x) const;
  std::size_t operator()(const CommandAck& x) const;
  std::size_t operator()(const SetMode& x) const;
  std::size_t operator()(const ManualControl& x) const;
  std::size_t operator()(const Ping& x) const;
  std::size_t operator()(const MessageInterval& x) const;
  std::size_t operator()(const ParamRequestList& x) const;
  std::size_t operator()(const ParamRequestRead& x) const;
  std::size_t operator()(const ParamSet& x) const;
  std::size_t operator()(const ParamValue& x) const;
  std::size_t operator()(const ParamError& x) const;
  std::size_t operator()(const MissionRequestList& x) const;
  std::size_t operator()(const MissionCount& x) const;
  std::size_t operator()(const MissionClearAll& x) const;
  std::size_t operator()(const MissionAck& x) const;
  std::size_t operator()(const FileTransferProtocol& x) const;

  // write_health.cpp
  std::size_t operator()(const RadioStatus& x) const;
  std::size_t operator()(const Statustext& x) const;
  std::size_t operator()(const NamedValueFloat& x) const;
  std::size_t operator()(const SysStatus& x) const;
  std::size_t operator()(const AutopilotVersion& x) const;
  std::size_t operator()(const ProtocolVersion& x) const;
  std::size_t operator()(const ComponentInformationBasic& x) const;
  std::size_t operator()(const ComponentMetadata& x) const;
  std::size_t operator()(const AvailableModes& x) const;
  std::size_t operator()(const CurrentMode& x) const;
  std::size_t operator()(const MavEscInfo& x) const;
  std::size_t operator()(const MavEscStatus& x) const;
  std::size_t operator()(const BatteryStatus& x) const;
};

}  // namespace flotilla::link
