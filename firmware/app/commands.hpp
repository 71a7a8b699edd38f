// SPDX-License-Identifier: MIT
// What an operator asks for by COMMAND_LONG, kept until the tick that answers it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "app/parameters.hpp"
#include "core/supervisor.hpp"
#include "link/counters.hpp"
#include "link/messages.hpp"

namespace flotilla::app {

struct PendingCommand {
  std::size_t link = 0;
  link::Address from{};
  link::CommandLong command{};
};

/// Commands of one tick, first come first served; one too many is counted, its sender repeats it.
/// A disarm is never one too many.
class CommandQueue {
 public:
  void push(const PendingCommand& pending, link::Counters& counters);
  std::span<const PendingCommand> pending() const { return {queue_.data(), count_}; }
  void clear() { count_ = 0; }

 private:
  std::array<PendingCommand, 8> queue_{};
  std::size_t count_ = 0;
};

/// What a command asks of the supervisor; where that is nothing, the answer is final already.
struct Asked {
  core::Request request = core::Request::kNone;
  std::uint8_t result = link::mav::kUnsupported;
  bool save_parameters = false;
};
Asked meaning_of(const PendingCommand& pending, const Parameters& parameters);

/// Whether a command is addressed to this component.
bool addressed_to(const link::CommandLong& command, const Parameters& parameters);

}  // namespace flotilla::app
