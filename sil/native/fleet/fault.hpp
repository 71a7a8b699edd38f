// SPDX-License-Identifier: MIT
// The faults around a boat, by name.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace flotilla::fleet {

enum class FaultKind : std::uint8_t {
  kOwnSilent,    ///< the navigation unit is off
  kOwnFrozen,    ///< it repeats its state from the fault's start, with new stamps
  kOwnJump,      ///< it reports a position `value` m farther north
  kOwnClock,     ///< its clock runs `value` s ahead of the vessel's
  kEscSilent,    ///< sends nothing, but obeys commands
  kEscStuck,     ///< keeps the command of the fault's start, whatever it receives
  kEscReversed,  ///< turns the other way, and reports that it does not
  kEscReboot,    ///< is off, and restarts at the end
  kEscVoltage,   ///< reports a battery of `value` V
  kBusOff,       ///< no CAN frame passes, and the host knows it
  kFrameLoss,    ///< this share of CAN frames is lost, both ways
  kRadioSilent,  ///< the radio is off, both ways
  kRadioLoss,    ///< this share of chunks is lost, both ways
  kByteErrors,   ///< this share of the radio's bytes is damaged, both ways
  kImpostor,     ///< a second vehicle with the same system id, `value` m north of this one
  kReplay,       ///< messages sent since the fault's start are repeated `value` s later
  kClock,        ///< the whole vessel's clock jumps by `value` s, and back at the end
  kRestart,      ///< the boat's process is killed; a new one starts at the end
};
constexpr std::size_t kFaultKinds = 18;
constexpr std::array<std::string_view, kFaultKinds> kFaultNames{
    "own_silent",   "own_frozen",  "own_jump",    "own_clock", "esc_silent", "esc_stuck",
    "esc_reversed", "esc_reboot",  "esc_voltage", "bus_off",   "frame_loss", "radio_silent",
    "radio_loss",   "byte_errors", "impostor",    "replay",    "clock",      "restart"};

/// Whether only boats can have it; a leader has only a unit and a radio.
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
  std::optional<std::size_t> esc{};  ///< 0 port, 1 starboard; none: both
  std::uint64_t seed = 0;            ///< decides which data is lost or damaged
};

}  // namespace flotilla::fleet
