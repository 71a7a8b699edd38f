// SPDX-License-Identifier: MIT
// The table of faults: scenarios, error messages, the soak and the reference page read it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace flotilla::fleet {

enum class FaultKind : std::uint8_t {
  kOwnSilent,
  kOwnFrozen,
  kOwnStuck,
  kOwnJump,
  kOwnNoisy,
  kOwnClock,
  kOwnPoorFix,
  kOwnPoorEstimate,
  kOwnImpostor,
  kOwnLateKind,
  kPilot,
  kEscSilent,
  kEscStuck,
  kEscReversed,
  kEscReboot,
  kEscVoltage,
  kBusOff,
  kFrameLoss,
  kStopSwitch,
  kRadioSilent,
  kRadioLoss,
  kByteErrors,
  kRadioLate,
  kImpostor,
  kReplay,
  kAnchored,
  kAnchoredLate,
  kCrowd,
  kAisShip,
  kOverrides,
  kClock,
  kRestart,
  kGcsSilent,
};

/// The part that fails. Failures in the world are not on a boat's wires: Fleet's caller applies
/// them.
enum class FaultOwner : std::uint8_t { kUnit, kEscs, kBus, kRadio, kVessel, kWorld };
constexpr std::array<std::string_view, 6> kOwnerNames{"navigation unit", "ESCs",   "bus",
                                                      "radio",           "vessel", "world"};

struct Range {
  double least, greatest;
};

struct FaultRow {
  FaultKind kind;
  std::string_view name;
  FaultOwner owner;
  bool leaders;                ///< a leader can have it too
  std::string_view unit;       ///< of its value; empty: it takes none
  Range allowed;               ///< values
  std::optional<Range> drawn;  ///< by a soak, with either sign if `allowed` has both; none: never
  std::string_view meaning;
};

constexpr Range kNoValue{0, 0}, kAny{-1e6, 1e6}, kPositive{0, 1e6}, kShare{0, 1};

// clang-format off
constexpr std::array kFaults = [] {
  using enum FaultKind;
  using enum FaultOwner;
  constexpr std::nullopt_t kNever = std::nullopt;
  return std::to_array<FaultRow>({
      {kOwnSilent, "own_silent", kUnit, true, "", kNoValue, kNoValue,
       "the navigation unit is off"},
      {kOwnFrozen, "own_frozen", kUnit, true, "", kNoValue, kNoValue,
       "it repeats the state of the fault's start with new time stamps"},
      {kOwnStuck, "own_stuck", kUnit, true, "", kNoValue, kNoValue,
       "it repeats the position of the fault's start and reports zero speed; heading and yaw rate "
       "stay true"},
      {kOwnJump, "own_jump", kUnit, true, "m", kAny, Range{1, 30},
       "it reports a position that far north of the true one"},
      {kOwnNoisy, "own_noisy", kWorld, false, "factor", kPositive, Range{2, 10},
       "its noise is that many times larger"},
      {kOwnClock, "own_clock", kUnit, true, "s", kAny, Range{3600, 3600},
       "its clock is that far ahead of the vessel's"},
      {kOwnPoorFix, "own_poor_fix", kUnit, false, "", kNoValue, kNoValue,
       "GPS_RAW_INT reports no fix, and a good one when the fault ends; before the fault it sends none"},
      {kOwnPoorEstimate, "own_poor_estimate", kUnit, false, "", kNoValue, kNoValue,
       "ESTIMATOR_STATUS reports an accuracy of 500 m once, then an unknown one, and a good one "
       "when the fault ends; before the fault it sends none"},
      {kOwnImpostor, "own_impostor", kUnit, false, "m", kAny, Range{20, 500},
       "a second unit on its link, same system id and a lower component id, that far north"},
      {kOwnLateKind, "own_late_kind", kUnit, true, "s", kPositive, Range{0.5, 5},
       "it also sends its state as ODOMETRY, that much later"},
      {kPilot, "pilot", kUnit, false, "share", {-1, 1}, Range{0.4, 1},
       "RC_CHANNELS with the switch (channels 5 to 16) on and the throttle at that share; "
       "afterwards both are at rest"},
      {kEscSilent, "esc_silent", kEscs, false, "", kNoValue, kNoValue,
       "they send nothing, but obey commands"},
      {kEscStuck, "esc_stuck", kEscs, false, "", kNoValue, kNoValue,
       "they keep the command of the fault's start"},
      {kEscReversed, "esc_reversed", kEscs, false, "", kNoValue, kNoValue,
       "the propellers turn the other way, and the reported speed hides it"},
      {kEscReboot, "esc_reboot", kEscs, false, "", kNoValue, kNoValue,
       "they are off, and restart at the end"},
      {kEscVoltage, "esc_voltage", kEscs, false, "V", kAny, kNever,
       "they report that battery voltage"},
      {kBusOff, "bus_off", kBus, false, "", kNoValue, kNoValue,
       "no CAN frame passes, and the host knows it"},
      {kFrameLoss, "frame_loss", kBus, false, "share", kShare, Range{0.01, 1},
       "that share of CAN frames is lost, both ways"},
      {kStopSwitch, "stop_switch", kBus, false, "", kNoValue, kNoValue,
       "a DroneCAN stop switch (Button) is pressed"},
      {kRadioSilent, "radio_silent", kRadio, true, "", kNoValue, kNoValue,
       "the radio is off, both ways"},
      {kRadioLoss, "radio_loss", kRadio, true, "share", kShare, Range{0.1, 1},
       "that share of the radio's packets is lost, both ways"},
      {kByteErrors, "byte_errors", kRadio, true, "share", kShare, Range{0.001, 0.3},
       "that share of the radio's bytes is damaged, both ways"},
      {kRadioLate, "radio_late", kRadio, true, "s", kPositive, Range{0.5, 10},
       "vessels hear each other that much later, both ways; the ground station is not affected"},
      {kImpostor, "impostor", kRadio, true, "m", kAny, Range{5, 50},
       "a second vehicle with the same system id, that far north of this one"},
      {kReplay, "replay", kRadio, true, "s", kPositive, Range{0.5, 4},
       "its messages are repeated that much later, byte for byte"},
      {kAnchored, "anchored", kRadio, false, "m", kAny, Range{4, 20},
       "another vessel is at anchor that far ahead; it reports its position but no velocity, and a "
       "second component of it sends a vehicle's HEARTBEAT"},
      {kAnchoredLate, "anchored_late", kRadio, false, "s", kPositive, Range{4, 10},
       "another vessel is at anchor 8 m ahead; its messages come that much later, and for an equal "
       "time at first also promptly"},
      {kCrowd, "crowd", kRadio, false, "vessels", {0, 60}, Range{9, 60},
       "that many other vessels are at anchor: the nearest 6 m ahead, the next ones every 5 m"},
      {kAisShip, "ais_ship", kRadio, false, "m", kAny, kNever,
       "an AIS receiver reports a ship at anchor that far ahead, every three minutes"},
      {kOverrides, "overrides", kRadio, false, "", kNoValue, kNoValue,
       "a ground station sends RC_CHANNELS_OVERRIDE with everything at rest"},
      {kClock, "clock", kVessel, true, "s", kAny, Range{3600, 3600},
       "the whole vessel's clock jumps ahead by that much, and back at the end"},
      {kRestart, "restart", kVessel, false, "", kNoValue, kNoValue,
       "the boat's process is killed; a new one starts at the end"},
      {kGcsSilent, "gcs_silent", kWorld, false, "", kNoValue, kNever,
       "its ground station is silent; needs FS_GCS_S"},
  });
}();
// clang-format on
constexpr std::size_t kFaultKinds = kFaults.size();

constexpr const FaultRow& row_of(FaultKind kind) { return kFaults[static_cast<std::size_t>(kind)]; }
static_assert(std::ranges::all_of(kFaults,
                                  [](const FaultRow& row) { return &row == &row_of(row.kind); }));

constexpr bool is_escs(FaultKind kind) { return row_of(kind).owner == FaultOwner::kEscs; }

struct Fault {
  FaultKind kind;
  double value = 0;
  std::optional<std::size_t> esc{};  ///< 0 port, 1 starboard; none: both
  std::uint64_t seed = 0;            ///< decides which data is lost or damaged
};

}  // namespace flotilla::fleet
