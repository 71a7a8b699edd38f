// SPDX-License-Identifier: MIT
// The boat's node on its CAN bus: what the ESCs report, what they are told.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/schedule.hpp"
#include "link/dronecan_messages.hpp"

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
    std::uint8_t system;  ///< MAVLink system id, shown in the unique id
  };

  explicit CanNode(Identity identity) : identity_(identity) {}

  void on_frame(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now_us,
                link::Counters& counters);

  /// That ESC's status came within the limit, from a node whose NodeStatus is recent and OK.
  bool esc_online(std::uint8_t index, std::int64_t now_us, std::int64_t limit_us) const;

  /// One control tick: both propellers in one RawCommand, ArmingStatus, NodeStatus, answers.
  void send(const link::RawCommand& command, bool armed, std::int64_t now_us,
            link::Counters& counters, CanOutput& out);

 private:
  struct Esc {
    std::optional<std::int64_t> heard_us;
    std::uint8_t node = 0;
  };
  struct Node {
    std::optional<std::int64_t> heard_us;
    std::uint8_t health = 0;
  };
  struct Question {
    std::uint8_t node;
    std::uint8_t priority;
    std::uint8_t transfer_id;
  };

  template <class Message>
  void send(const Message& message, const link::DataType& type, std::uint8_t priority,
            std::uint8_t& transfer_id, link::Counters& counters, CanOutput& out);
  void answer(std::int64_t now_us, link::Counters& counters, CanOutput& out);

  Identity identity_;
  link::TransferReceiver receiver_;
  std::array<Esc, 32> escs_{};
  std::array<Node, 128> nodes_{};
  std::optional<Question> question_;
  std::optional<std::int64_t> started_us_;
  Schedule arming_due_{100'000};
  Schedule status_due_{1'000'000};
  bool armed_ = false;
  std::uint8_t command_id_ = 0;
  std::uint8_t arming_id_ = 0;
  std::uint8_t status_id_ = 0;
};

}  // namespace flotilla::app
