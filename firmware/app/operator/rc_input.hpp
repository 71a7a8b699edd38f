// SPDX-License-Identifier: MIT
// A pilot's transmitter, by RC_CHANNELS of an RC receiver or RC_CHANNELS_OVERRIDE.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "app/supervisor.hpp"

namespace flotilla::app {

/// The pilot takes over to MANUAL by the switch, or by moving a stick away from where it rested when
/// the law began to drive, so that a throttle may rest at its lower end; the switch turned off ends
/// in HOLD. Channels as on ArduPilot's Rover: 1 steers, 3 gives thrust.
class RcInput {
 public:
  /// Pulses of the channels from 1 on, µs; switch_channel counts from 1. The sticks, if the pilot has
  /// them; false: a channel is missing, or no pulse.
  bool hear(std::span<const std::uint16_t> pulses_us, std::uint8_t switch_channel,
            core::State state, std::int64_t now_us);
  std::optional<Sticks> sticks() const { return pilots_ ? std::optional(sticks_) : std::nullopt; }

  /// MANUAL or HOLD, if the pilot wants it now: MANUAL as long as the switch is on.
  std::optional<core::Request> take_request(core::State state, std::int64_t now_us);

 private:
  Sticks sticks_, rest_;
  std::int64_t heard_us_ = 0;
  bool on_ = false, pilots_ = false, resting_ = false;  // resting_: rest_ is known and holds
  std::optional<core::Request> asks_;
};

}  // namespace flotilla::app
