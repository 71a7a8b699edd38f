// SPDX-License-Identifier: MIT
// One RC pilot's sticks and mode switch, from RC_CHANNELS or RC_CHANNELS_OVERRIDE.
#pragma once

#include <algorithm>
#include <array>
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

  /// Whether this sender's pulses are used. One sender is kept until it sends no valid pulses for
  /// 0.5 s or reports its receiver as lost. A sender is a component for RC_CHANNELS, a system for
  /// RC_CHANNELS_OVERRIDE.
  bool hears(std::uint8_t sender, std::int64_t now_us) const;
  /// Takes the pulses of channels 1 and up, µs; switch_channel counts from 1. False if a channel
  /// that is needed is missing or has no valid pulse, or if the throttle is that of a receiver
  /// without its transmitter.
  bool hear(std::span<const std::uint16_t> pulses_us, std::uint8_t switch_channel,
            core::State state, std::int64_t now_us, std::uint8_t sender = 0);
  /// Notes the receiver's health, as reported by the component that sends its pulses: a receiver
  /// that has lost its transmitter may repeat its last pulses endlessly.
  void judge(std::uint8_t component, const link::SysStatus& status);
  bool is_lost(std::uint8_t component) const {
    return component != 0 && std::ranges::count(lost_.components, component) != 0;
  }

  /// The pilot has taken over, and is heard.
  bool pilots(std::int64_t now_us) const;
  /// The pilot's switch is on.
  bool holds(std::int64_t now_us) const { return on_ && is_heard(now_us); }
  /// The pilot has taken over, and a stick is off neutral.
  bool steers(std::int64_t now_us) const { return pilots(now_us) && !neutral_; }
  std::optional<Sticks> sticks() const { return pilots_ ? std::optional(sticks_) : std::nullopt; }

  /// The pilot's pending request, MANUAL or HOLD. While the switch is on: MANUAL again and again; a
  /// motor test ends with HOLD first.
  std::optional<core::Request> take_request(core::State state, std::int64_t now_us);

 private:
  /// The last components that have lost their transmitters; 0: none.
  struct Lost {
    std::array<std::uint8_t, 4> components{};
    std::uint8_t next = 0;  ///< where the next one is noted
  };

  bool is_heard(std::int64_t now_us) const;

  RcInput(std::uint8_t sender, const Lost& lost) : lost_(lost), sender_(sender) {}

  Sticks sticks_, rest_;
  std::int64_t heard_us_ = 0;                           // when the last valid pulses came
  bool on_ = false, pilots_ = false, resting_ = false;  // resting_: rest_ is known and holds
  bool neutral_ = false;
  Lost lost_;
  std::uint8_t sender_ = 0;  // in use
  std::optional<core::Request> asks_;
};

}  // namespace flotilla::app
