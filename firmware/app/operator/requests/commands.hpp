// SPDX-License-Identifier: MIT
// Decodes operators' commands.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>

#include "app/operator/requests/failure.hpp"
#include "app/plan/errand.hpp"
#include "app/supervisor.hpp"
#include "core/supervisor.hpp"
#include "link/mavlink/ftp_server.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// Requests that other systems may send to the boat.
using RequestMessage =
    std::variant<std::monostate, link::CommandLong, link::CommandInt, link::SetMode,
                 link::ParamRequestList, link::ParamRequestRead, link::ParamSet, link::FtpRequest,
                 link::Timesync, link::Ping, link::MissionRequestList, link::MissionCount,
                 link::MissionClearAll, link::MissionRequest, link::MissionRequestInt,
                 link::MissionItem, link::MissionItemInt, link::MissionAck, link::MissionSetCurrent,
                 link::LogRequestList, link::LogRequestData, link::LogRequestEnd,
                 link::SetPositionTargetLocalNed, link::SetPositionTargetGlobalInt>;

/// A common form of COMMAND_LONG, COMMAND_INT, SET_MODE, MISSION_SET_CURRENT, and of a
/// MISSION_ITEM_INT that is "go here".
struct Command {
  std::uint16_t id;
  std::array<double, 7> param;  ///< as received; unused ones may be NaN
  link::Address target;
  bool repeated = false;                ///< a retransmission (COMMAND_LONG.confirmation)
  bool wants_ack = true;                ///< a COMMAND_ACK answers it; not the last three above
  std::optional<std::uint8_t> frame{};  ///< of a COMMAND_INT, whose place is in degE7
};
std::optional<Command> command_of(const RequestMessage& message);

/// ArduPilot's "go here": a waypoint that is no item of a plan, answered with a MISSION_ACK.
bool is_go_here(const RequestMessage& message);

bool is_disarm(const Command& command);

/// Disarming or flight termination: obeyed from anybody.
bool is_stop(const Command& command);

/// Disarming, flight termination or HOLD: never ignored as a copy, never dropped or postponed, and
/// with a correct signature obeyed at any age.
bool stops_boat(const Command& command);
bool stops_boat(const link::Message& message);

struct MessageRequest {
  std::uint16_t id = 0;
  std::uint32_t index = 0;  ///< its meaning depends on the message; 0: all
};

struct MessageRate {
  std::uint16_t id = 0;
  std::int64_t interval_us = 0;  ///< 0: the default, −1: off
};

/// The decoded command; if it requests nothing, `result` is final.
struct DecodedCommand {
  std::uint8_t result = link::mav::kUnsupported;
  core::Request request = core::Request::kNone;
  bool save_parameters = false;
  std::optional<MotorTest> motor_test{};  ///< with Request::kTest
  bool repeated = false;
  std::optional<MessageRequest> message{};
  std::optional<MessageRate> rate{};
  std::optional<Failure> failure{};   ///< supported only by hosts that simulate
  std::optional<std::size_t> item{};  ///< of the plan, to continue from
  bool anew = false;                  ///< with `item`: no jump counts as taken
  std::optional<bool> paused{};       ///< of the plan or the errand
  std::optional<Target> target{};     ///< with Request::kGuided, or for a boat in GUIDED
  std::optional<bool> fence{};        ///< on or off
  std::string_view why{};             ///< of a refusal, for the operator

  /// Whether the command only reads: every sender may send such a command.
  bool reads_only() const { return message.has_value(); }

  /// Whether it orders the boat to drive, or where to.
  bool orders() const {
    return core::turns_propellers(core::kind_of(request)) || target || item || (paused && !*paused);
  }
};
DecodedCommand meaning_of(const Command& command);

/// The effects of a request, if it is granted.
struct Effects {
  bool stops : 1 = false;       ///< disarms, terminates, or is a HOLD that is obeyed
  bool ends : 1 = false;        ///< disarms or terminates
  bool asks_state : 1 = false;  ///< asks for a state, so it could undo an earlier stop
  bool reads : 1 = false;       ///< asks for a message
  bool overwrites : 1 = false;  ///< does not stop; a late copy of it could undo a newer request
};
/// may_command: whether the sender's HOLD is obeyed.
Effects effects_of(const RequestMessage& request, bool may_command);

}  // namespace flotilla::app
