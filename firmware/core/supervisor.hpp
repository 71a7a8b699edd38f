// SPDX-License-Identifier: MIT
// Decides when the boat may drive: conditions and an operator's request → ordered table → state.
//
// The first matching row wins. A row matches when all of this is true:
//   from:   the state is one of these
//   the request is the row's
//   needs:  all of these conditions are met
//   lacks:  empty, or at least one of these is not met
//   on:     empty, or contains the reaction that the operator chose for what is lost
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
  kGuided,     ///< the same, to the target of an operator or a script
  kLoiter,     ///< the same, until the boat stops; it waits there
  kReturn,     ///< the same, home or to a rally point; the boat waits there
};
constexpr std::size_t kStates = 11;

enum class Request : std::uint8_t {
  kNone,
  kDisarm,
  kArm,
  kHold,
  kManual,
  kFormation,
  kTest,
  kTerminate,
  kAuto,
  kGuided,
  kLoiter,
  kReturn
};
constexpr std::size_t kRequests = 12;

/// The effect of a request on the propellers.
enum class RequestKind : std::uint8_t {
  kNone,    ///< nothing
  kStops,   ///< stops them
  kArms,    ///< lets them turn later
  kByHand,  ///< turns them by the sticks
  kDrives,  ///< turns them without a pilot
};

constexpr RequestKind kind_of(Request request) {
  switch (request) {
    case Request::kNone:
      return RequestKind::kNone;
    case Request::kDisarm:
    case Request::kHold:
    case Request::kTerminate:
      return RequestKind::kStops;
    case Request::kArm:
      return RequestKind::kArms;
    case Request::kManual:
      return RequestKind::kByHand;
    case Request::kFormation:
    case Request::kTest:
    case Request::kAuto:
    case Request::kGuided:
    case Request::kLoiter:
    case Request::kReturn:
      break;
  }
  return RequestKind::kDrives;
}

/// Whether a request lets the propellers turn at once.
constexpr bool turns_propellers(RequestKind kind) {
  return kind == RequestKind::kByHand || kind == RequestKind::kDrives;
}

/// Reactions to a loss, the most careful first.
enum class Reaction : std::uint8_t {
  kHold,
  kLoiter,
  kReturn,
  kCoast,   ///< after it, Choices::coast_end decides
  kManual,  ///< if sticks are fresh, else HOLD
  kNone,    ///< nothing is lost
};
constexpr std::size_t kReactions = 6;

/// A set of conditions; a set bit means that all is well.
using Conditions = std::uint64_t;
constexpr Conditions kOwnFresh = 1U << 0U;         ///< own state is younger than its limit
constexpr Conditions kLeaderFresh = 1U << 1U;      ///< the same of the leader's; both origins known
constexpr Conditions kEscsOnline = 1U << 2U;       ///< both ESCs report good health
constexpr Conditions kBusUp = 1U << 3U;            ///< the CAN interface is up and not bus-off
constexpr Conditions kSoleController = 1U << 4U;   ///< no other node commands or arms ESCs
constexpr Conditions kParametersSaved = 1U << 5U;  ///< stored data were read, or saved since
constexpr Conditions kSticksFresh = 1U << 6U;      ///< a pilot's sticks are younger than 0.5 s
constexpr Conditions kTestRunning = 1U << 7U;      ///< a requested motor test has not ended
constexpr Conditions kOwnLive = 1U << 8U;          ///< own state is not frozen
constexpr Conditions kOwnSteady = 1U << 9U;        ///< own state does not jump
constexpr Conditions kLeaderLive = 1U << 10U;      ///< leader's state is not frozen
constexpr Conditions kLeaderSteady = 1U << 11U;    ///< one vessel sends it, no jump under the law
constexpr Conditions kBoatAnswers = 1U << 12U;     ///< the boat responds to its thrust
constexpr Conditions kEscsObey = 1U << 13U;        ///< no ESC spins while commanded to stop
constexpr Conditions kGcsHeard = 1U << 14U;        ///< a ground station is heard, or not required
constexpr Conditions kBatteryGood = 1U << 15U;     ///< ESC voltage above its limit, or none is set
constexpr Conditions kInsideFence = 1U << 16U;     ///< inside both fences, can stop in stored one
constexpr Conditions kClear = 1U << 17U;           ///< no vessel is nearer than FS_SEP_M
constexpr Conditions kCoastRunning = 1U << 18U;    ///< COAST has time left, relative place known
constexpr Conditions kInRange = 1U << 19U;         ///< the scalar has not overflowed
constexpr Conditions kOnStation = 1U << 20U;       ///< in slot, closing up, or not under the law
constexpr Conditions kOwnPrompt = 1U << 21U;       ///< own state's latency is tolerable for the law
constexpr Conditions kLeadersEnd = 1U << 22U;      ///< the chain of leaders does not return to us
constexpr Conditions kSlotSound = 1U << 23U;       ///< the slot is free, without sailing astern
constexpr Conditions kOwnTimed = 1U << 24U;        ///< age of own state is known, or no state
constexpr Conditions kLeaderTimed = 1U << 25U;     ///< the same of the leader's state
constexpr Conditions kOwnGood = 1U << 26U;         ///< the boat's unit reports no poor estimate
constexpr Conditions kSoleVessel = 1U << 27U;      ///< no other vessel uses the boat's system id
constexpr Conditions kSticksCentred = 1U << 28U;   ///< at neutral, or were once in this MANUAL
constexpr Conditions kLeaderNear = 1U << 29U;      ///< the followed vessel is within FORM_DIST_MAX
constexpr Conditions kPlanReady = 1U << 30U;       ///< a stored plan begins near, within the fence
constexpr Conditions kHomeNear = 1U << 31U;        ///< the place to return to is known and near
constexpr Conditions kLocated = Conditions{1} << 32U;   ///< own global position is known
constexpr Conditions kGainsFit = Conditions{1} << 33U;  ///< the law's gains fit hull and propellers
constexpr unsigned kConditionCount = 34;

constexpr Conditions kPropulsion = kEscsOnline | kBusUp | kSoleController | kEscsObey;
/// If one of these is not met, the boat might not obey commands and needs an inspection.
constexpr Conditions kSound = kPropulsion | kInRange;
constexpr Conditions kOwn = kOwnFresh | kOwnLive | kOwnSteady;
constexpr Conditions kLeader =
    kLeaderFresh | kLeaderTimed | kLeaderNear | kLeaderLive | kLeaderSteady;
/// A boat that leaves its slot counts as one that has lost its leader.
constexpr Conditions kFollows = kLeader | kOnStation;
constexpr Conditions kLimits = kBatteryGood | kInsideFence;
/// The operator chooses the reaction to the loss of each of these.
constexpr Conditions kLosses = kFollows | kGcsHeard | kLimits;
/// Without these the boat has no valid place in the formation tree.
constexpr Conditions kPlace = kLeadersEnd | kSlotSound;
/// The law needs these, whatever the boat follows.
constexpr Conditions kSteers =
    kOwn | kOwnTimed | kOwnGood | kOwnPrompt | kSoleVessel | kBoatAnswers | kSound;
constexpr Conditions kByLaw = kSteers | kPlace;
constexpr Conditions kDrive = kByLaw | kLosses;
constexpr Conditions kFormationBegins = kDrive | kClear;
constexpr Conditions kCoastDrive = kByLaw | kLimits | kCoastRunning;
// LOITER and RTL need neither a ground station nor the limits, whose loss may have led to them.
constexpr Conditions kLoiterDrive = kSteers | kLocated | kOnStation;
constexpr Conditions kLoiterBegins = kLoiterDrive | kLimits;
constexpr Conditions kReturnDrive = kLoiterDrive | kHomeNear;
constexpr Conditions kReturnBegins = kReturnDrive | kClear;
constexpr Conditions kGuidedDrive = kLoiterDrive | kLimits | kGcsHeard;
constexpr Conditions kGuidedBegins = kGuidedDrive | kClear;
constexpr Conditions kAutoDrive = kGuidedDrive | kPlanReady;
constexpr Conditions kAutoBegins = kAutoDrive | kClear;
// Needs no own state, so that a boat that has lost its navigation can be driven home.
constexpr Conditions kManualBegins = kSticksFresh | kSound;
constexpr Conditions kManualDrive = kManualBegins | kSticksCentred;
// Arming needs no own state either, and ignores battery and fence.
constexpr Conditions kArming = kSound | kSoleVessel | kGcsHeard | kParametersSaved | kGainsFit;
constexpr Conditions kTestDrive = kTestRunning | kSound;
constexpr Conditions kAllConditions = (Conditions{1} << kConditionCount) - 1;

using States = std::uint16_t;
using Reactions = std::uint8_t;

/// The set of these states.
template <class... Any>
constexpr States in(Any... states) {
  return static_cast<States>(((1U << static_cast<unsigned>(states)) | ...));
}
/// The set of these reactions.
template <class... Any>
constexpr Reactions by(Any... reactions) {
  return static_cast<Reactions>(((1U << static_cast<unsigned>(reactions)) | ...));
}
constexpr States kAnyState = (1U << kStates) - 1U;
constexpr States kFollowing = in(State::kFormation, State::kCoast);
constexpr States kAlone = in(State::kAuto, State::kGuided, State::kLoiter, State::kReturn);
constexpr States kLawDrives = kFollowing | kAlone;
constexpr States kArmed = in(State::kHold, State::kManual, State::kTest) | kLawDrives;
/// In these states a ground station must be heard and the limits be kept.
constexpr States kBound = kFollowing | in(State::kAuto, State::kGuided);
/// Operators may change between these states.
constexpr States kChosen = (kArmed & ~in(State::kTest, State::kCoast));

struct Row {
  States from;
  Request request;
  Conditions needs;
  Conditions lacks;
  State to;
  Reactions on = 0;  ///< the row needs one of these reactions; 0: any, or none
};

inline constexpr std::array<Row, 47> kTable{{
    {kAnyState, Request::kDisarm, 0, 0, State::kDisarmed},
    {kAnyState, Request::kTerminate, 0, 0, State::kFault},
    // Automatic transitions. None leaves FAULT or leads from HOLD to motion; COAST ends by itself.
    {kArmed, Request::kNone, 0, kSound, State::kFault},
    {in(State::kManual), Request::kNone, 0, kSticksFresh, State::kHold},
    {in(State::kTest), Request::kNone, 0, kTestRunning, State::kHold},
    {kFollowing, Request::kNone, 0, kByLaw, State::kHold},
    {kAlone, Request::kNone, 0, kLoiterDrive, State::kHold},
    {in(State::kAuto), Request::kNone, 0, kPlanReady, State::kHold},
    {in(State::kReturn), Request::kNone, 0, kHomeNear, State::kHold},
    // Losses, each with the reaction that its operator chose.
    {in(State::kCoast), Request::kNone, kLoiterDrive, kCoastRunning, State::kLoiter,
     by(Reaction::kLoiter)},
    {in(State::kCoast), Request::kNone, kReturnDrive, kCoastRunning, State::kReturn,
     by(Reaction::kReturn)},
    {in(State::kCoast), Request::kNone, 0, kCoastRunning, State::kHold,
     by(Reaction::kHold, Reaction::kLoiter, Reaction::kReturn)},
    {kBound, Request::kNone, kLoiterDrive, kLosses, State::kLoiter, by(Reaction::kLoiter)},
    {kBound | in(State::kLoiter), Request::kNone, kReturnDrive, kLosses, State::kReturn,
     by(Reaction::kReturn)},
    {in(State::kFormation), Request::kNone, 0, kFollows | kGcsHeard, State::kCoast,
     by(Reaction::kCoast)},
    {in(State::kFormation), Request::kNone, kSticksFresh, kFollows | kGcsHeard, State::kManual,
     by(Reaction::kManual)},
    {kBound, Request::kNone, 0, kLosses, State::kHold,
     by(Reaction::kHold, Reaction::kLoiter, Reaction::kReturn, Reaction::kManual)},
    {in(State::kLoiter), Request::kNone, 0, kLimits, State::kHold,
     by(Reaction::kHold, Reaction::kReturn)},
    {in(State::kCoast), Request::kNone, kLosses, 0, State::kFormation},
    // Requests. A boat that can neither sail its plan nor follow a leader is armed nevertheless;
    // the second kArm row reports the unmet conditions of FORMATION.
    {in(State::kDisarmed), Request::kArm, kArming | kAutoBegins, 0, State::kHold},
    {in(State::kDisarmed), Request::kArm, kArming, kFormationBegins, State::kHold},
    {in(State::kDisarmed), Request::kArm, kArming, 0, State::kHold},
    {kArmed, Request::kHold, 0, 0, State::kHold},
    {in(State::kHold) | kLawDrives, Request::kManual, kManualBegins, 0, State::kManual},
    {kChosen & ~in(State::kFormation), Request::kFormation, kFormationBegins, 0, State::kFormation},
    {(kChosen & ~in(State::kAuto)) | in(State::kCoast), Request::kAuto, kAutoBegins, 0,
     State::kAuto},
    {(kChosen & ~in(State::kGuided)) | in(State::kCoast), Request::kGuided, kGuidedBegins, 0,
     State::kGuided},
    {(kChosen & ~in(State::kLoiter)) | in(State::kCoast), Request::kLoiter, kLoiterBegins, 0,
     State::kLoiter},
    {(kChosen & ~in(State::kReturn)) | in(State::kCoast), Request::kReturn, kReturnBegins, 0,
     State::kReturn},
    {in(State::kHold), Request::kTest, kTestDrive, 0, State::kTest},
    // Requests for the present state are granted: senders repeat a command whose answer was lost.
    {in(State::kDisarmed), Request::kHold, 0, 0, State::kDisarmed},
    {in(State::kHold), Request::kArm, 0, 0, State::kHold},
    {in(State::kManual), Request::kArm, 0, 0, State::kManual},
    {in(State::kFormation), Request::kArm, 0, 0, State::kFormation},
    {in(State::kCoast), Request::kArm, 0, 0, State::kCoast},
    {in(State::kTest), Request::kArm, 0, 0, State::kTest},
    {in(State::kAuto), Request::kArm, 0, 0, State::kAuto},
    {in(State::kGuided), Request::kArm, 0, 0, State::kGuided},
    {in(State::kLoiter), Request::kArm, 0, 0, State::kLoiter},
    {in(State::kReturn), Request::kArm, 0, 0, State::kReturn},
    {in(State::kManual), Request::kManual, 0, 0, State::kManual},
    {in(State::kFormation), Request::kFormation, 0, 0, State::kFormation},
    {in(State::kCoast), Request::kFormation, 0, 0, State::kCoast},
    {in(State::kAuto), Request::kAuto, 0, 0, State::kAuto},
    {in(State::kGuided), Request::kGuided, 0, 0, State::kGuided},
    {in(State::kLoiter), Request::kLoiter, 0, 0, State::kLoiter},
    {in(State::kReturn), Request::kReturn, 0, 0, State::kReturn},
}};

/// The operator's choices: FS_LEADER_ACT, FS_GCS_ACT, FS_BATT_ACT, FS_FENCE_ACT, FS_COAST_ACT.
struct Choices {
  Reaction leader = Reaction::kCoast, gcs = Reaction::kHold, battery = Reaction::kHold,
           fence = Reaction::kHold, coast_end = Reaction::kHold;
  bool operator==(const Choices&) const = default;
};

/// In these states an unmet bit of `needs` is a loss; `choice` names the reaction.
struct Loss {
  States in;
  Conditions needs;
  Reaction Choices::* choice;
};
constexpr std::array<Loss, 4> kLossTable{{
    {kFollowing, kFollows, &Choices::leader},
    {kBound, kGcsHeard, &Choices::gcs},
    {kBound | in(State::kLoiter), kBatteryGood, &Choices::battery},
    {kBound | in(State::kLoiter), kInsideFence, &Choices::fence},
}};

/// A reaction, and the lost conditions that lead to it.
struct Response {
  Reaction reaction = Reaction::kNone;
  Conditions lost = 0;
};

/// Applies a choice. Only a boat behind a leader can coast, or hand over to fresh sticks by itself;
/// a boat in COAST coasts on.
constexpr Response effect_of(const Choices& choices, Reaction choice, State state, Conditions met,
                             Conditions lost) {
  using enum Reaction;
  if (choice == kManual && (met & kSticksFresh) == 0) choice = kHold;
  if (choice != kCoast && choice != kManual) return {choice, lost};
  if ((kFollowing & in(state)) == 0) return {kHold, lost};
  if (state != State::kCoast) return {choice, lost};
  if ((met & kCoastRunning) != 0) return {kCoast, lost};
  return {choices.coast_end, kCoastRunning};
}

/// The most careful of the reactions to the conditions that are lost in this state.
constexpr Response response_to(const Choices& choices, State state, Conditions met) {
  Response out;
  for (const Loss& loss : kLossTable) {
    const Conditions lost = (loss.in & in(state)) != 0 ? loss.needs & ~met : 0;
    if (lost == 0) continue;
    const Response next = effect_of(choices, choices.*loss.choice, state, met, lost);
    if (next.reaction == out.reaction) out.lost |= next.lost;
    if (next.reaction < out.reaction) out = next;
  }
  return out;
}

struct Verdict {
  State state;
  bool granted;  ///< a row matched; for Request::kNone: an automatic transition
  /// After a refused request: the unmet conditions, none if no row allows it in this state. After
  /// an automatic transition: the conditions whose loss caused it. After arming: those that
  /// FORMATION still lacks.
  Conditions missing;
};

/// For each request, the part of the table from its first row to its last.
inline constexpr auto kRowsOf = [] {
  std::array<std::span<const Row>, kRequests> rows;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto is = [r](const Row& row) { return static_cast<std::size_t>(row.request) == r; };
    const auto first = std::ranges::find_if(kTable, is);
    const auto last = std::find_if(kTable.rbegin(), kTable.rend(), is).base();
    rows[r] = {first, last};
  }
  return rows;
}();

constexpr Verdict supervise(State state, Request request, Conditions met,
                            const Response& response = {}) {
  Conditions missing = 0;
  for (const Row& row : kRowsOf[static_cast<std::size_t>(request)]) {
    if ((row.from & in(state)) == 0 || row.request != request) continue;
    if (row.on != 0 && (row.on & by(response.reaction)) == 0) continue;
    const Conditions unmet = row.needs & ~met;
    const bool lacking = row.lacks == 0 || (row.lacks & ~met) != 0;
    const Conditions lost = row.on != 0 ? response.lost : row.lacks & ~met;
    if (unmet == 0 && lacking) return {row.to, true, lost};
    missing = unmet;  // in the end those of the last row, which needs least
  }
  return {state, false, request == Request::kNone ? Conditions{0} : missing};
}

constexpr bool armed(State state) { return (kArmed & in(state)) != 0; }
constexpr bool sails_alone(State state) { return (kAlone & in(state)) != 0; }
constexpr bool follows(State state) { return (kFollowing & in(state)) != 0; }
constexpr bool law_drives(State state) { return (kLawDrives & in(state)) != 0; }

/// Whether thrust is allowed; checked again after allocation.
constexpr bool may_drive(State state, Conditions met) {
  const auto all_of = [met](Conditions desired) { return (met & desired) == desired; };
  return (state == State::kManual && all_of(kManualDrive)) ||
         (state == State::kFormation && all_of(kDrive)) ||
         (state == State::kCoast && all_of(kCoastDrive)) ||
         (state == State::kAuto && all_of(kAutoDrive)) ||
         (state == State::kGuided && all_of(kGuidedDrive)) ||
         (state == State::kLoiter && all_of(kLoiterDrive)) ||
         (state == State::kReturn && all_of(kReturnDrive)) ||
         (state == State::kTest && all_of(kTestDrive));
}

}  // namespace flotilla::core
