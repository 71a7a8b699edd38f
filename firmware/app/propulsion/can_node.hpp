// SPDX-License-Identifier: MIT
// The boat's node on its CAN bus: receives the ESCs' status, sends their commands.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "app/schedule.hpp"
#include "link/dronecan/messages.hpp"
#include "link/dronecan/node_id_server.hpp"

namespace flotilla::app {

/// Frames of one tick, in sending order; a transfer that does not fit is dropped whole.
struct CanOutput {
  std::array<link::CanFrame, 64> frames{};
  std::size_t count = 0;
};

class CanNode {
 public:
  struct Identity {
    std::uint8_t node;
    std::uint8_t system;  ///< MAVLink system id, part of the unique id
  };

  /// early_us: half a control period, so that jitter of the loop does not skip a turn to send.
  CanNode(Identity identity, std::int64_t early_us)
      : identity_(identity),
        node_ids_(identity.node),
        arming_due_(100'000, early_us),
        status_due_(1'000'000, early_us) {}

  void on_frame(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now_us,
                link::Counters& counters);

  /// The ESC's status came within the limit, from a single node, which is operational and OK.
  bool esc_online(std::uint8_t index, std::int64_t now_us, std::int64_t limit_us) const;

  /// For at least a second, neither ESC has driven its propeller while commanded to stop. A
  /// windmilling propeller is given time to come to rest, and may keep turning if its ESC draws no
  /// current.
  bool escs_obey(std::uint8_t port, std::uint8_t stbd, std::int64_t now_us) const;

  /// The ESC's last status; nothing after 3 s of silence.
  std::optional<link::EscStatus> esc_status(std::uint8_t index, std::int64_t now_us) const;

  /// The ESC's propeller is at rest. Never true of an ESC that has not measured a rotation.
  bool rests(std::uint8_t index) const;

  /// Another node has commanded or armed ESCs within the last two seconds.
  bool foreign_controller(std::int64_t now_us) const;

  /// A stop switch on the bus is pressed: a Button in the last 0.5 s, or a SafetyState other than
  /// "off" in the last 2 s. Once a safety switch was heard, 2 s without "off" count as pressed,
  /// too: its wire may be cut.
  bool stop_pressed(std::int64_t now_us) const;

  /// The node ids assigned; the host saves them across restarts.
  link::NodeIdServer& node_ids() { return node_ids_; }

  /// One control tick: both propellers in one RawCommand, ArmingStatus, NodeStatus, answers.
  void send(const link::RawCommand& command, bool armed, std::int64_t now_us,
            link::Counters& counters, CanOutput& out);

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::int64_t kLongAgo_us = 500'000;
  static constexpr std::uint16_t kMinute_ms = 60'000;

  struct Esc {
    std::int64_t heard_us = kNever;
    std::int64_t claimed_us = kNever;  ///< last status from a second node
    link::EscStatus status{};
    std::uint8_t node = 0;
    bool driven = false;            ///< commanded to turn since the last status
    bool measures_current = false;  ///< has once
    bool measures_rpm = false;      ///< has once
    // Durations up to the last status, ms, at most kMinute_ms:
    std::uint16_t zeros_ms = 0;   ///< commanded to stop
    std::uint16_t drives_ms = 0;  ///< driving although commanded to stop
    std::uint16_t turns_ms = 0;   ///< turning fast, and maybe driven, although commanded to stop
    std::uint16_t obeyed_ms = kMinute_ms;
  };
  struct SafetySwitch {
    std::uint8_t node = 0;  ///< 0: a free entry
    std::int64_t off_us = kNever;
  };
  /// Kept small: there are 128 of them.
  struct Node {
    std::int64_t heard_us = kNever;
    std::uint32_t uptime_sec = 0;
    std::uint32_t since_reboot_us : 31 = kLongAgo_us;  ///< at heard_us, at most kLongAgo_us
    std::uint32_t is_well : 1 = 0;                     ///< operational and OK
  };
  struct PendingRequest {
    std::uint8_t node;
    std::uint8_t priority;
    std::uint8_t transfer_id;
  };

  template <class Message>
  void send(const Message& message, const link::DataType& type, std::uint8_t priority,
            std::uint8_t& transfer_id, link::Counters& counters, CanOutput& out);
  template <class Message>
  void put(const Message& message, const link::Route& route, const link::DataType& type,
           std::uint8_t transfer_id, link::Counters& counters, CanOutput& out);
  void take(const link::Route& route, std::span<const std::uint8_t> data, std::int64_t now_us,
            link::Counters& counters);
  void take_safety_state(std::uint8_t node, const link::SafetyState& state, std::int64_t now_us);
  void take_node_status(std::uint8_t node, const link::NodeStatus& status, std::int64_t now_us);
  static void judge(Esc& esc, std::int64_t since_us);
  void take_esc_status(std::uint8_t node, const link::EscStatus& status, std::int64_t now_us);
  void answer(const PendingRequest& request, std::int64_t now_us, link::Counters& counters,
              CanOutput& out);

  Identity identity_;
  link::TransferReceiver receiver_;
  std::array<Esc, std::tuple_size_v<decltype(link::RawCommand::cmd)>> escs_{};  // by ESC index
  std::array<Node, 128> nodes_{};
  std::array<PendingRequest, 4> pending_{};
  std::size_t pending_count_ = 0;
  link::NodeIdServer node_ids_;
  std::optional<link::Allocation> allocation_;
  std::optional<std::int64_t> foreign_us_;
  std::int64_t button_us_ = kNever;
  std::int64_t safety_on_us_ = kNever;
  std::array<SafetySwitch, 3> switches_{};  // heard once; their silence counts as pressed
  std::optional<std::int64_t> started_us_;
  Schedule arming_due_;
  Schedule status_due_;
  bool armed_ = false;
  std::uint8_t command_id_ = 0;
  std::uint8_t arming_id_ = 0;
  std::uint8_t status_id_ = 0;
  std::uint8_t allocation_id_ = 0;
};

}  // namespace flotilla::app
