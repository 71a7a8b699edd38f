// SPDX-License-Identifier: MIT
// When the boat may push: condition bits and an operator's request → one ordered table → state.
//
// The first row that fits wins. A row fits when the state is one of `from`, the request is the
// row's, every condition in `needs` is met and, where `lacks` is not empty, one of those is not.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace flotilla::core {

enum class State : std::uint8_t {
  kDisarmed,   ///< no thrust, ESCs told to stay disarmed
  kHold,       ///< armed, no thrust
  kManual,     ///< armed, the sticks drive
  kFormation,  ///< armed, the law drives
  kTest,       ///< armed, one propeller turns: bounded, for seconds
  kFault,      ///< no thrust, ESCs told to disarm; left by disarming only
};
constexpr std::size_t kStates = 6;

enum class Request : std::uint8_t {
  kNone,
  kDisarm,
  kArm,
  kHold,
  kManual,
  kFormation,
  kTest,
  kTerminate
};
constexpr std::size_t kRequests = 8;

/// A set of conditions; each is true when all is well.
using Conditions = std::uint16_t;
constexpr Conditions kOwnFresh = 1;         ///< own state is younger than its limit
constexpr Conditions kLeaderFresh = 2;      ///< leader's state is, and both local origins are known
constexpr Conditions kEscsOnline = 4;       ///< both ESCs report, healthy
constexpr Conditions kBusUp = 8;            ///< the CAN interface is up and not bus-off
constexpr Conditions kSoleController = 16;  ///< nobody else on the bus commands or arms ESCs
constexpr Conditions kParametersSaved = 32;  ///< they are the operator's, not a fall to defaults
constexpr Conditions kSticksFresh = 64;      ///< MANUAL_CONTROL is younger than 0.5 s
constexpr Conditions kTestRunning = 128;     ///< a motor test was asked for and is not over
constexpr unsigned kConditionCount = 8;

constexpr Conditions kPropulsion = kEscsOnline | kBusUp | kSoleController;
constexpr Conditions kDrive = kOwnFresh | kLeaderFresh | kPropulsion;
// No own state: a boat that lost its navigation can be driven home.
constexpr Conditions kManualDrive = kSticksFresh | kPropulsion;
constexpr Conditions kArming = kOwnFresh | kPropulsion | kParametersSaved;
constexpr Conditions kTestDrive = kTestRunning | kPropulsion;
constexpr Conditions kAllConditions = kDrive | kManualDrive | kTestDrive | kParametersSaved;

/// The set of those states.
template <class... States>
constexpr std::uint8_t in(States... states) {
  return static_cast<std::uint8_t>(((1U << static_cast<unsigned>(states)) | ...));
}
constexpr std::uint8_t kAnyState = (1U << kStates) - 1U;
constexpr std::uint8_t kArmed = in(State::kHold, State::kManual, State::kFormation, State::kTest);

struct Row {
  std::uint8_t from;
  Request request;
  Conditions needs;
  Conditions lacks;
  State to;
};

constexpr std::array<Row, 18> kTable{{
    {kAnyState, Request::kDisarm, 0, 0, State::kDisarmed},
    {kAnyState, Request::kTerminate, 0, 0, State::kFault},
    {kArmed, Request::kNone, 0, kPropulsion, State::kFault},
    {in(State::kManual), Request::kNone, 0, kSticksFresh, State::kHold},
    {in(State::kFormation), Request::kNone, 0, kOwnFresh | kLeaderFresh, State::kHold},
    {in(State::kTest), Request::kNone, 0, kTestRunning, State::kHold},
    {in(State::kDisarmed), Request::kArm, kArming, 0, State::kHold},
    {kArmed, Request::kHold, 0, 0, State::kHold},
    {in(State::kHold, State::kFormation), Request::kManual, kManualDrive, 0, State::kManual},
    {in(State::kHold, State::kManual), Request::kFormation, kDrive, 0, State::kFormation},
    {in(State::kHold), Request::kTest, kTestDrive, 0, State::kTest},
    // Asking for what already is: granted, because commands are repeated when an answer is lost.
    {in(State::kDisarmed), Request::kHold, 0, 0, State::kDisarmed},
    {in(State::kHold), Request::kArm, 0, 0, State::kHold},
    {in(State::kManual), Request::kArm, 0, 0, State::kManual},
    {in(State::kFormation), Request::kArm, 0, 0, State::kFormation},
    {in(State::kTest), Request::kArm, 0, 0, State::kTest},
    {in(State::kManual), Request::kManual, 0, 0, State::kManual},
    {in(State::kFormation), Request::kFormation, 0, 0, State::kFormation},
}};

struct Verdict {
  State state;
  bool granted;  ///< a row fitted; always false for Request::kNone when nothing changes
  /// Refused for want of these, none where the state itself forbids it; or what was lost, where the
  /// boat changed its state by itself.
  Conditions missing;
};

constexpr Verdict supervise(State state, Request request, Conditions met) {
  Conditions missing = 0;
  for (const Row& row : kTable) {
    if ((row.from & in(state)) == 0 || row.request != request) continue;
    const auto unmet = static_cast<Conditions>(row.needs & ~met);
    const bool lacking = row.lacks == 0 || (row.lacks & ~met) != 0;
    if (unmet == 0 && lacking) return {row.to, true, static_cast<Conditions>(row.lacks & ~met)};
    missing |= unmet;
  }
  return {state, false, missing};
}

constexpr bool armed(State state) { return (kArmed & in(state)) != 0; }

/// Whether thrust is allowed; the propellers' path asks again, after allocation.
constexpr bool may_drive(State state, Conditions met) {
  const auto all_of = [met](Conditions wanted) { return (met & wanted) == wanted; };
  return (state == State::kManual && all_of(kManualDrive)) ||
         (state == State::kFormation && all_of(kDrive)) ||
         (state == State::kTest && all_of(kTestDrive));
}

}  // namespace flotilla::core
