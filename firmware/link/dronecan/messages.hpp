// SPDX-License-Identifier: MIT
// DroneCAN messages as plain structs with the DSDL's names, and their payload bytes.
// Source: DSDL of PyPI dronecan 1.0.27; DroneCAN specification, chapter 3.5 "Data serialization".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "link/dronecan/transfer.hpp"

namespace flotilla::link {

/// uavcan.equipment.esc.RawCommand: −8192 … 8191, positive ahead, 0 stops; index in cmd: ESC index.
struct RawCommand {
  static constexpr DataType kType{TransferKind::kMessage, 1030, 0x217F5C87D7EC951DULL};
  std::uint8_t count = 0;
  std::array<std::int16_t, 20> cmd{};
};

/// uavcan.equipment.esc.RPMCommand: not sent by this firmware.
struct RpmCommand {
  static constexpr DataType kType{TransferKind::kMessage, 1031, 0xCE0F9F621CF7E70BULL};
};

/// uavcan.equipment.safety.ArmingStatus: 0 disarmed, 255 fully armed.
struct ArmingStatus {
  static constexpr DataType kType{TransferKind::kMessage, 1100, 0x8700F375556A8003ULL};
  std::uint8_t status = 0;
};

/// ardupilot.indication.SafetyState: state of a safety switch; 255 (off) lets motors turn.
struct SafetyState {
  static constexpr DataType kType{TransferKind::kMessage, 20000, 0xE965701A95A1A6A1ULL};
  static constexpr std::uint8_t kOff = 255;
  std::uint8_t status = 0;
};

/// ardupilot.indication.Button: sent while the button is pressed.
struct Button {
  static constexpr DataType kType{TransferKind::kMessage, 20001, 0x0645A46EFBA7466EULL};
  static constexpr std::uint8_t kSafety = 1;
  std::uint8_t button = 0;
};

/// uavcan.protocol.NodeStatus
struct NodeStatus {
  static constexpr DataType kType{TransferKind::kMessage, 341, 0x0F0868D0C1A7C6F1ULL};
  std::uint32_t uptime_sec = 0;
  std::uint8_t health = 0;  ///< 0 OK, 1 warning, 2 error, 3 critical
  std::uint8_t mode = 0;    ///< 0 operational, 1 initialization, 2 maintenance, 3 update, 7 offline
  std::uint8_t sub_mode = 0;
  std::uint16_t vendor_specific_status_code = 0;
};

/// uavcan.equipment.esc.Status; values unknown to the ESC are NaN.
struct EscStatus {
  static constexpr DataType kType{TransferKind::kMessage, 1034, 0xA9AF28AEA2FBB254ULL};
  std::uint32_t error_count = 0;
  float voltage = 0;      ///< V
  float current = 0;      ///< A
  float temperature = 0;  ///< K
  std::int32_t rpm = 0;
  std::uint8_t power_rating_pct = 0;
  std::uint8_t esc_index = 0;
};

/// uavcan.protocol.dynamic_node_id.Allocation; a request's node_id is the preferred one, 0: any.
struct Allocation {
  static constexpr DataType kType{TransferKind::kMessage, 1, 0x0B2A812620A11D40ULL};
  std::uint8_t node_id = 0;
  bool first_part = false;
  std::uint8_t size = 0;  ///< bytes of unique_id in this message
  std::array<std::uint8_t, 16> unique_id{};
};

/// uavcan.protocol.GetNodeInfo, response; the request has no fields.
struct NodeInfo {
  static constexpr DataType kRequest{TransferKind::kRequest, 1, 0xEE468A8121C46A9EULL};
  static constexpr DataType kResponse{TransferKind::kResponse, 1, 0xEE468A8121C46A9EULL};
  NodeStatus status;
  std::uint8_t software_major = 0;
  std::uint8_t software_minor = 0;
  std::uint32_t vcs_commit = 0;  ///< 0: unknown
  std::uint8_t hardware_major = 0;
  std::uint8_t hardware_minor = 0;
  std::array<std::uint8_t, 16> unique_id{};
  std::string_view name;  ///< at most 80 characters
};

constexpr std::size_t kLongestPayload = 128;
using Payload = std::array<std::uint8_t, kLongestPayload>;

/// Each writes the payload and returns its length. Values beyond a field's range saturate.
std::size_t write_payload(const RawCommand& message, Payload& out);
std::size_t write_payload(const ArmingStatus& message, Payload& out);
std::size_t write_payload(const NodeStatus& message, Payload& out);
std::size_t write_payload(const EscStatus& message, Payload& out);
std::size_t write_payload(const NodeInfo& message, Payload& out);
std::size_t write_payload(const Allocation& message, Payload& out);

/// Each returns nullopt if the payload is too short for its type.
std::optional<RawCommand> read_raw_command(std::span<const std::uint8_t> payload);
std::optional<ArmingStatus> read_arming_status(std::span<const std::uint8_t> payload);
std::optional<SafetyState> read_safety_state(std::span<const std::uint8_t> payload);
std::optional<Button> read_button(std::span<const std::uint8_t> payload);
std::optional<NodeStatus> read_node_status(std::span<const std::uint8_t> payload);
std::optional<EscStatus> read_esc_status(std::span<const std::uint8_t> payload);
std::optional<Allocation> read_allocation(std::span<const std::uint8_t> payload);

}  // namespace flotilla::link
