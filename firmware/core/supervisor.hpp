// SPDX-License-Identifier: MIT
// Decides when the boat may drive: conditions and an operator's request → ordered table → state.
//
// The first matching row wins. A row matches when the state is one of `from`, the request is the
// row's, every condition in `needs` is met and, unless `lacks` is empty, one in `lacks` is not.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace flotilla::core {

enum class State : std::uint8_t {
  kDisarmed,   ///< no thrust, ESCs commanded to stay disarmed
  kHold,       ///< armed, no thrust
  kManual,     ///< armed, the sticks drive
  kFormation,  ///< armed, the law drives
  kCoast,      ///< armed, the law follows a dead-reckoned leader that slows down
  kTest,       ///< armed, one propeller turns, with limited thrust, for seconds
  kFault,      ///< no thrust, ESCs commanded to disarm; only disarming leaves it
  kAuto,       ///< armed, the law drives behind the boat's own plan
};
constexpr std::size_t kStates = 8;

enum class Request : std::uint8_t {
  kNone,
  kDisarm,
  kArm,
  kHold,
  kManual,
  kFormation,
  kTest,
  kTerminate,
  kAuto
};
constexpr std::size_t kRequests = 9;

/// A set of conditions; a set bit means that all is well.
using Conditions = std::uint64_t;
constexpr Conditions kOwnFresh = 1U << 0U;         ///< own state is younger than its limit
constexpr Conditions kLeaderFresh = 1U << 1U;      ///< the same of the leader's; both origins known
constexpr Conditions kEscsOnline = 1U << 2U;       ///< both ESCs report good health
constexpr Conditions kBusUp = 1U << 3U;            ///< the CAN interface is up and not bus-off
constexpr Conditions kSoleController = 1U << 4U;   ///< no other node commands or arms ESCs
constexpr Conditions kParametersSaved = 1U << 5U;  ///< stored parameters were read, or saved since
constexpr Conditions kSticksFresh = 1U << 6U;      ///< MANUAL_CONTROL is younger than 0.5 s
constexpr Conditions kTestRunning = 1U << 7U;      ///< a requested motor test is not over
constexpr Conditions kOwnLive = 1U << 8U;          ///< own state is not frozen
constexpr Conditions kOwnSteady = 1U << 9U;        ///< own state does not jump
constexpr Conditions kLeaderLive = 1U << 10U;      ///< leader's state is not frozen
constexpr Conditions kLeaderSteady = 1U << 11U;    ///< one vessel sends it, no jump under the law
constexpr Conditions kBoatAnswers = 1U << 12U;     ///< the boat responds to its thrust
constexpr Conditions kEscsObey = 1U << 13U;        ///< no ESC spins while commanded to stop
constexpr Conditions kGcsHeard = 1U << 14U;        ///< a ground station is heard, or not required
constexpr Conditions kBatteryGood = 1U << 15U;     ///< ESC voltage above its limit, or none is set
constexpr Conditions kInsideFence = 1U << 16U;     ///< near enough to home, or no limit is set
constexpr Conditions kClear = 1U << 17U;           ///< no vessel is nearer than FS_SEP_M
constexpr Conditions kCoastRunning = 1U << 18U;    ///< COAST is not over
constexpr Conditions kInRange = 1U << 19U;         ///< the scalar has not overflowed
constexpr Conditions kOnStation = 1U << 20U;       ///< in slot, closing up, or not under the law
constexpr Conditions kOwnPrompt = 1U << 21U;       ///< own state's latency is tolerable for the law
constexpr Conditions kLeadersEnd = 1U << 22U;      ///< the chain of leaders does not lead back here
constexpr Conditions kSlotSound = 1U << 23U;       ///< the slot is free, and does not go astern
constexpr Conditions kOwnTimed = 1U << 24U;     ///< the own state's age is known, or there is none
constexpr Conditions kLeaderTimed = 1U << 25U;  ///< the same of the leader's state
constexpr Conditions kOwnGood = 1U << 26U;      ///< the own unit does not call its estimate poor
constexpr Conditions kSoleVessel = 1U << 27U;   ///< no other vessel uses the boat's system id
constexpr Conditions kSticksCentred = 1U << 28U;  ///< at neutral, or were once in this MANUAL
constexpr Conditions kLeaderNear = 1U << 29U;     ///< the followed vessel is within FORM_DIST_MAX
constexpr Conditions kPlanReady = 1U << 30U;      ///< a plan is stored, and begins near the boat
constexpr unsigned kConditionCount = 31;          ///< without the operator's choices
// The operator's choices FS_LEADER_ACT and FS_GCS_ACT; neither bit of a pair: MANUAL, else HOLD.
constexpr Conditions kLeaderLossHolds = Conditions{1} << kConditionCount;
constexpr Conditions kLeaderLossCoasts = kLeaderLossHolds << 1U;
constexpr Conditions kGcsLossHolds = kLeaderLossHolds << 2U;
constexpr Conditions kGcsLossCoasts = kLeaderLossHolds << 3U;

constexpr Conditions kPropulsion = kEscsOnline | kBusUp | kSoleController | kEscsObey;
/// Without these the boat may not obey commands and needs an inspection.
constexpr Conditions kSound = kPropulsion | kInRange;
constexpr Conditions kOwn = kOwnFresh | kOwnLive | kOwnSteady;
constexpr Conditions kLeader =
    kLeaderFresh | kLeaderTimed | kLeaderNear | kLeaderLive | kLeaderSteady;
/// A boat that leaves its slot counts as one that has lost its leader.
constexpr Conditions kFollows = kLeader | kOnStation;
constexpr Conditions kLimits = kBatteryGood | kInsideFence;
/// Without these the boat has no valid place in the formation tree.
constexpr Conditions kPlace = kLeadersEnd | kSlotSound;
/// The law needs these whatever it follows.
constexpr Conditions kSteers =
    kOwn | kOwnTimed | kOwnGood | kOwnPrompt | kSoleVessel | kBoatAnswers | kSound | kLimits;
constexpr Conditions kByLaw = kSteers | kPlace;
constexpr Conditions kDrive = kByLaw | kFollows | kGcsHeard;
constexpr Conditions kFormationBegins = kDrive | kClear;
constexpr Conditions kAutoDrive = kSteers | kPlanReady | kOnStation | kGcsHeard;
constexpr Conditions kAutoBegins = kAutoDrive | kClear;
constexpr Conditions kCoastDrive = kByLaw | kCoastRunning;
// Needs no own state, so that a boat that has lost its navigation can be driven home.
constexpr Conditions kManualBegins = kSticksFresh | kSound;
constexpr Conditions kManualDrive = kManualBegins | kSticksCentred;
// Arming needs no own state either, and ignores battery and fence.
constexpr Conditions kArming = kSound | kSoleVessel | kGcsHeard | kParametersSaved;
constexpr Conditions kTestDrive = kTestRunning | kSound;
constexpr Conditions kAllConditions = kLeaderLossHolds - 1;

/// The set of these states.
template <class... States>
constexpr std::uint8_t in(States... states) {
  return static_cast<std::uint8_t>(((1U << static_cast<unsigned>(states)) | ...));
}
constexpr std::uint8_t kAnyState = (1U << kStates) - 1U;
constexpr std::uint8_t kFollowing = in(State::kFormation, State::kCoast);
constexpr std::uint8_t kLawDrives = kFollowing | in(State::kAuto);
constexpr std::uint8_t kArmed = in(State::kHold, State::kManual, State::kTest) | kLawDrives;

struct Row {
  std::uint8_t from;
  Request request;
  Conditions needs;
  Conditions lacks;
  State to;
};

constexpr std::array<Row, 34> kTable{{
    {kAnyState, Request::kDisarm, 0, 0, State::kDisarmed},
    {kAnyState, Request::kTerminate, 0, 0, State::kFault},
    // Automatic transitions. None leaves FAULT or leads from HOLD to motion; COAST ends by itself.
    {kArmed, Request::kNone, 0, kSound, State::kFault},
    {in(State::kManual), Request::kNone, 0, kSticksFresh, State::kHold},
    {in(State::kTest), Request::kNone, 0, kTestRunning, State::kHold},
    {in(State::kAuto), Request::kNone, 0, kAutoDrive, State::kHold},
    {kFollowing, Request::kNone, 0, kByLaw, State::kHold},
    // After two losses the more careful choice counts, also if the second comes later, in COAST.
    {kFollowing, Request::kNone, kLeaderLossHolds, kFollows, State::kHold},
    {kFollowing, Request::kNone, kGcsLossHolds, kGcsHeard, State::kHold},
    {in(State::kFormation), Request::kNone, kLeaderLossCoasts, kFollows, State::kCoast},
    {in(State::kFormation), Request::kNone, kGcsLossCoasts, kGcsHeard, State::kCoast},
    {in(State::kFormation), Request::kNone, kSticksFresh, kFollows | kGcsHeard, State::kManual},
    {in(State::kFormation), Request::kNone, 0, kFollows | kGcsHeard, State::kHold},
    {in(State::kCoast), Request::kNone, kFollows | kGcsHeard, 0, State::kFormation},
    {in(State::kCoast), Request::kNone, 0, kCoastRunning, State::kHold},
    // Requests. A boat that can neither sail its plan nor follow a leader is armed for MANUAL only;
    // the second kArm row reports what FORMATION lacks.
    {in(State::kDisarmed), Request::kArm, kArming | kAutoBegins, 0, State::kHold},
    {in(State::kDisarmed), Request::kArm, kArming, kFormationBegins, State::kHold},
    {in(State::kDisarmed), Request::kArm, kArming, 0, State::kHold},
    {kArmed, Request::kHold, 0, 0, State::kHold},
    {in(State::kHold) | kLawDrives, Request::kManual, kManualBegins, 0, State::kManual},
    {in(State::kHold, State::kManual, State::kAuto), Request::kFormation, kFormationBegins, 0,
     State::kFormation},
    {in(State::kHold, State::kManual) | kFollowing, Request::kAuto, kAutoBegins, 0, State::kAuto},
    {in(State::kHold), Request::kTest, kTestDrive, 0, State::kTest},
    // Requests for the present state: granted, as senders repeat a command whose answer is lost.
    {in(State::kDisarmed), Request::kHold, 0, 0, State::kDisarmed},
    {in(State::kHold), Request::kArm, 0, 0, State::kHold},
    {in(State::kManual), Request::kArm, 0, 0, State::kManual},
    {in(State::kFormation), Request::kArm, 0, 0, State::kFormation},
    {in(State::kCoast), Request::kArm, 0, 0, State::kCoast},
    {in(State::kTest), Request::kArm, 0, 0, State::kTest},
    {in(State::kAuto), Request::kArm, 0, 0, State::kAuto},
    {in(State::kManual), Request::kManual, 0, 0, State::kManual},
    {in(State::kFormation), Request::kFormation, 0, 0, State::kFormation},
    {in(State::kCoast), Request::kFormation, 0, 0, State::kCoast},
    {in(State::kAuto), Request::kAuto, 0, 0, State::kAuto},
}};

struct Verdict {
  State state;
  bool granted;  ///< a row matched; for Request::kNone: an automatic transition
  /// After a refused request: the unmet conditions, none if no row allows it in this state. After
  /// an automatic transition: the conditions whose loss caused it. After arming: those that
  /// FORMATION still lacks.
  Conditions missing;
};

/// From the first row of a request to its last one.
constexpr std::span<const Row> rows_of(Request request) {
  constexpr auto kRows = [] {
    std::array<std::span<const Row>, kRequests> rows;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const auto is = [r](const Row& row) { return static_cast<std::size_t>(row.request) == r; };
      const auto first = std::ranges::find_if(kTable, is);
      const auto last = std::find_if(kTable.rbegin(), kTable.rend(), is).base();
      rows[r] = {first, last};
    }
    return rows;
  }();
  return kRows[static_cast<std::size_t>(request)];
}

constexpr Verdict supervise(State state, Request request, Conditions met) {
  Conditions missing = 0;
  for (const Row& row : rows_of(request)) {
    if ((row.from & in(state)) == 0 || row.request != request) continue;
    const Conditions unmet = row.needs & ~met;
    const bool lacking = row.lacks == 0 || (row.lacks & ~met) != 0;
    if (unmet == 0 && lacking) return {row.to, true, row.lacks & ~met};
    missing = unmet;  // of the row that asks least: the last
  }
  return {state, false, request == Request::kNone ? Conditions{0} : missing};
}

constexpr bool armed(State state) { return (kArmed & in(state)) != 0; }
constexpr bool follows(State state) { return (kFollowing & in(state)) != 0; }
constexpr bool law_drives(State state) { return (kLawDrives & in(state)) != 0; }

/// Whether thrust is allowed; checked again after allocation.
constexpr bool may_drive(State state, Conditions met) {
  const auto all_of = [met](Conditions desired) { return (met & desired) == desired; };
  return (state == State::kManual && all_of(kManualDrive)) ||
         (state == State::kFormation && all_of(kDrive)) ||
         (state == State::kCoast && all_of(kCoastDrive)) ||
         (state == State::kAuto && all_of(kAutoDrive)) ||
         (state == State::kTest && all_of(kTestDrive));
}

}  // namespace flotilla::core
