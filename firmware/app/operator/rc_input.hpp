// SPDX-License-Identifier: MIT
// One RC pilot's sticks and mode switch, from RC_CHANNELS or RC_CHANNELS_OVERRIDE.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "app/supervisor.hpp"

namespace flotilla::app {

/// The pilot takes over in MANUAL by the switch, or by moving a stick away from where it rested
/// when the law began to drive, so a throttle may rest at its lower end. Switching off leads to
/// HOLD. Channels as on ArduPilot Rover: 1 steers, 3 is the throttle.
class RcInput {
 public:
  RcInput() = default;

  /// Whether pulses of this component count: only one component's do until it has sent no valid
  /// ones for half a second, or reports its receiver as lost.
  bool hears(std::uint8_t component, std::int64_t now_us) const;
  /// Takes the pulses of channels 1 and up, µs; switch_channel counts from 1. False if a channel
  /// that is needed is missing or has no valid pulse, or if the throttle is that of a receiver
  /// without its transmitter.
  bool hear(std::span<const std::uint16_t> pulses_us, std::uint8_t switch_channel,
            core::State state, std::int64_t now_us, std::uint8_t component = 0);
  /// Notes the receiver's health, as reported by the component that sends its pulses: a receiver
  /// that has lost its transmitter may repeat its last pulses endlessly.
  void judge(std::uint8_t component, const link::SysStatus& status);
  bool is_lost(std::uint8_t component) const { return lost_ != 0 && lost_ == component; }

  /// The pilot has taken over, and is heard.
  bool pilots(std::int64_t now_us) const;
  std::optional<Sticks> sticks() const { return pilots_ ? std::optional(sticks_) : std::nullopt; }

  /// The pilot's pending request, MANUAL or HOLD; MANUAL again and again while the switch is on.
  std::optional<core::Request> take_request(core::State state, std::int64_t now_us);

 private:
  RcInput(std::uint8_t component, std::uint8_t lost) : lost_(lost), component_(component) {}

  Sticks sticks_, rest_;
  std::int64_t heard_us_ = 0;                           // when the last valid pulses came
  bool on_ = false, pilots_ = false, resting_ = false;  // resting_: rest_ is known and holds
  std::uint8_t lost_ = 0, component_ = 0;  // the component that has lost its transmitter; in use
  std::optional<core::Request> asks_;
};

}  // namespace flotilla::app
