// SPDX-License-Identifier: MIT
// What an operator's command means.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "app/operator/failure.hpp"
#include "app/supervisor.hpp"
#include "core/supervisor.hpp"
#include "link/mavlink/ftp_server.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// What others may ask of the boat.
using RequestMessage =
    std::variant<std::monostate, link::CommandLong, link::CommandInt, link::SetMode,
                 link::ParamRequestList, link::ParamRequestRead, link::ParamSet, link::FtpRequest,
                 link::Timesync, link::Ping, link::MissionRequestList, link::MissionCount,
                 link::MissionClearAll>;

/// COMMAND_LONG, COMMAND_INT or SET_MODE in one form. No command of ours has a position, so the
/// frame of a COMMAND_INT says nothing.
struct Command {
  std::uint16_t id;
  std::array<double, 7> param;  ///< as they came; unused ones may be NaN
  link::Address target;
  bool repeated = false;  ///< for want of an answer (COMMAND_LONG.confirmation)
  bool wants_ack = true;  ///< SET_MODE is a message: nobody waits for an answer
};
std::optional<Command> command_of(const RequestMessage& message);

bool is_disarm(const Command& command);

/// Disarming or flight termination.
bool is_stop(const Command& command);

struct MessageRequest {
  std::uint16_t id = 0;
  std::uint32_t index = 0;  ///< meaning depends on the message; 0: all
};

struct MessageRate {
  std::uint16_t id = 0;
  std::int64_t interval_us = 0;  ///< 0: the default, −1: off
};

/// What a command asks; where that is nothing, the result is final already.
struct Asked {
  std::uint8_t result = link::mav::kUnsupported;
  core::Request request = core::Request::kNone;
  bool save_parameters = false;
  std::optional<MotorTest> motor_test{};  ///< with Request::kTest
  bool repeated = false;
  std::optional<MessageRequest> message{};
  std::optional<MessageRate> rate{};
  std::optional<Failure> failure{};  ///< supported where the host says so

  /// Changes nothing that others see: anybody may.
  bool reads_only() const { return message.has_value(); }
};
Asked meaning_of(const Command& command);

/// The supervisor's request for a mode number; nothing where there is no such mode.
std::optional<core::Request> request_of_mode(double custom_mode);

}  // namespace flotilla::app
