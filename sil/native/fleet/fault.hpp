// SPDX-License-Identifier: MIT
// What can go wrong around a boat, by name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace flotilla::fleet {

enum class FaultKind : std::uint8_t {
  kOwnSilent,    ///< the navigation unit is off
  kOwnFrozen,    ///< it says what it said at the beginning, with new stamps
  kOwnJump,      ///< it says a place `value` m farther north
  kOwnClock,     ///< its clock is `value` s ahead of the vessel's
  kEscSilent,    ///< says nothing, and does as it is told
  kEscStuck,     ///< turns as it did at the beginning, whatever it is told
  kEscReversed,  ///< turns the other way, and says that it does not
  kEscReboot,    ///< is off, and starts anew at the end
  kEscVoltage,   ///< says that its battery has `value` V
  kBusOff,       ///< no CAN frame passes, and the host knows
  kFrameLoss,    ///< that share of the CAN frames is lost, both ways
  kRadioSilent,  ///< the radio is off, both ways
  kRadioLoss,    ///< that share of the chunks is lost, both ways
  kByteErrors,   ///< that share of the radio's bytes is damaged, both ways
  kImpostor,     ///< a second vehicle with the same system id, `value` m north of this one
  kReplay,       ///< what was said since the beginning is said again `value` s later
  kClock,        ///< the whole vessel's clock jumps by `value` s, and back at the end
  kRestart,      ///< the boat's process is killed; at the end there is a new one
};
constexpr std::size_t kFaultKinds = 18;
constexpr std::array<std::string_view, kFaultKinds> kFaultNames{
    "own_silent",   "own_frozen",  "own_jump",    "own_clock", "esc_silent", "esc_stuck",
    "esc_reversed", "esc_reboot",  "esc_voltage", "bus_off",   "frame_loss", "radio_silent",
    "radio_loss",   "byte_errors", "impostor",    "replay",    "clock",      "restart"};

/// Whether only a boat can have it; a leader is no more than a unit and a radio.
constexpr bool is_boats(FaultKind kind) {
  using enum FaultKind;
  return (kind >= kEscSilent && kind <= kFrameLoss) || kind == kRestart;
}
constexpr bool is_escs(FaultKind kind) {
  return kind >= FaultKind::kEscSilent && kind <= FaultKind::kEscVoltage;
}
constexpr bool is_share(FaultKind kind) {
  using enum FaultKind;
  return kind == kFrameLoss || kind == kRadioLoss || kind == kByteErrors;
}

struct Fault {
  FaultKind kind;
  double value = 0;
  std::optional<std::size_t> esc{};  ///< 0 port, 1 starboard; both
  std::uint64_t seed = 0;            ///< of what is lost or damaged
};

}  // namespace flotilla::fleet
