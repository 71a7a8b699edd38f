// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <vector>

#include "core/every_situation.hpp"

namespace flotilla::core {
namespace {

/// The specification as an operator understands the boat; it is independent of the table.
struct World {
  bool own, place, located, home, leader, station, plan, sound, alone, gcs, limits, clear, saved,
      sticks, centred, test, coasts;

  explicit World(Conditions met)
      : own(has(met, kOwnFresh | kOwnLive | kOwnSteady | kOwnTimed | kOwnGood | kOwnPrompt |
                         kBoatAnswers)),
        place(has(met, kLeadersEnd | kSlotSound)),
        located(has(met, kLocated)),
        home(has(met, kHomeNear)),
        leader(has(met, kLeaderFresh | kLeaderTimed | kLeaderNear | kLeaderLive | kLeaderSteady)),
        station(has(met, kOnStation)),
        plan(has(met, kPlanReady)),
        sound(has(met, kEscsOnline | kBusUp | kSoleController | kEscsObey | kInRange)),
        alone(has(met, kSoleVessel)),
        gcs(has(met, kGcsHeard)),
        limits(has(met, kBatteryGood | kInsideFence)),
        clear(has(met, kClear)),
        saved(has(met, kParametersSaved | kGainsFit)),
        sticks(has(met, kSticksFresh)),
        centred(has(met, kSticksCentred)),
        test(has(met, kTestRunning)),
        coasts(has(met, kCoastRunning)) {}

  bool steers() const { return own && sound && alone; }
  bool law() const { return steers() && place; }
  bool follows() const { return leader && station; }
  bool formation() const { return law() && limits && follows() && gcs; }
  bool waits() const { return steers() && located && station; }
  bool returns() const { return waits() && home; }
  bool guided() const { return waits() && limits && gcs; }
  bool sails() const { return guided() && plan; }
};

/// Where the reaction to a loss leads, if the boat is fit for that.
State after_loss(State state, const World& is, Reaction reaction) {
  switch (reaction) {
    case Reaction::kNone:
      return state == State::kCoast ? State::kFormation : state;
    case Reaction::kHold:
      return State::kHold;
    case Reaction::kLoiter:
      return is.waits() ? State::kLoiter : State::kHold;
    case Reaction::kReturn:
      return is.returns() ? State::kReturn : State::kHold;
    case Reaction::kCoast:
      return State::kCoast;
    case Reaction::kManual:
      return is.sticks ? State::kManual : State::kHold;
  }
  return state;
}

State by_itself(State state, Conditions met, Reaction reaction) {
  const World is(met);
  if (state == State::kDisarmed || state == State::kFault) return state;
  if (!is.sound) return State::kFault;
  if (state == State::kManual) return is.sticks ? state : State::kHold;
  if (state == State::kTest) return is.test ? state : State::kHold;
  if (state == State::kHold) return state;
  if (state == State::kReturn) return is.returns() ? state : State::kHold;
  if (state == State::kFormation || state == State::kCoast) {
    return is.law() ? after_loss(state, is, reaction) : State::kHold;
  }
  if (!is.waits() || (state == State::kAuto && !is.plan)) return State::kHold;
  return after_loss(state, is, reaction);
}

struct Expected {
  State state;
  bool granted;
};

Expected when_armed_and_asked(State state, Request request, Conditions met) {
  const World is(met);
  const bool by_law = state == State::kFormation || state == State::kCoast;
  const auto changed = [state](State to, bool fit) {
    const bool goes = state == to || (state != State::kTest && fit);
    return Expected{goes ? to : state, goes};
  };
  switch (request) {
    case Request::kArm:
      return {state, true};
    case Request::kHold:
      return {State::kHold, true};
    case Request::kManual:
      if (state == State::kManual) return {state, true};
      if (state != State::kTest && is.sound && is.sticks) return {State::kManual, true};
      return {state, false};
    case Request::kAuto:
      return changed(State::kAuto, is.sails() && is.clear);
    case Request::kGuided:
      return changed(State::kGuided, is.guided() && is.clear);
    case Request::kLoiter:
      return changed(State::kLoiter, is.waits() && is.limits);
    case Request::kReturn:
      return changed(State::kReturn, is.returns() && is.clear);
    case Request::kFormation:
      if (by_law) return {state, true};
      if (state != State::kTest && is.formation() && is.clear) return {State::kFormation, true};
      return {state, false};
    default:
      if (state == State::kHold && is.sound && is.test) return {State::kTest, true};
      return {state, false};
  }
}

Expected specified(State state, Request request, Conditions met, Reaction reaction) {
  const World is(met);
  if (request == Request::kDisarm) return {State::kDisarmed, true};
  if (request == Request::kTerminate) return {State::kFault, true};
  if (request == Request::kNone) {
    const State next = by_itself(state, met, reaction);
    return {next, next != state};
  }
  if (state == State::kFault) return {state, false};
  if (state != State::kDisarmed) return when_armed_and_asked(state, request, met);
  if (request == Request::kHold) return {state, true};
  // The boat can be driven home regardless of navigation, battery, fence and leader.
  const bool fit = is.sound && is.alone && is.gcs && is.saved;
  if (request == Request::kArm && fit) return {State::kHold, true};
  return {state, false};
}

TEST_CASE("every state, request and set of conditions leads to the specified state") {
  std::uint64_t situations = 0;
  for_every_situation([&](State state, Request request, Conditions met, Reaction reaction) {
    const Expected expected = specified(state, request, met, reaction);
    const Verdict verdict = supervise(state, request, met, {reaction});
    ++situations;
    const bool right = verdict.state == expected.state && verdict.granted == expected.granted;
    if (right && (verdict.missing & met) == 0) return;
    CAPTURE(static_cast<int>(state));
    CAPTURE(static_cast<int>(request));
    CAPTURE(met);
    CAPTURE(static_cast<int>(reaction));
    FAIL_CHECK(static_cast<int>(verdict.state), " for ", static_cast<int>(expected.state));
  });
  CHECK(situations > (std::uint64_t{kStates * kRequests} << classes().size()));
  MESSAGE(situations, " situations");
}

TEST_CASE("conditions of one kind count separately: one unmet is as bad as all") {
  const Conditions all = kAllConditions;
  unsigned compared = 0;
  for (const Conditions kind : classes()) {
    for (unsigned bit = 0; bit < kConditionCount; ++bit) {
      if ((kind >> bit & 1U) == 0 || std::popcount(kind) == 1) continue;
      ++compared;
      for (unsigned s = 0; s < kStates; ++s) {
        for (unsigned r = 0; r < kRequests; ++r) {
          const auto state = static_cast<State>(s);
          const auto request = static_cast<Request>(r);
          for (unsigned on = 0; on < kReactions; ++on) {
            const auto reaction = static_cast<Reaction>(on);
            CHECK(supervise(state, request, all & ~(Conditions{1} << bit), {reaction}).state ==
                  supervise(state, request, all & ~kind, {reaction}).state);
          }
        }
        CHECK(may_drive(static_cast<State>(s), all & ~(Conditions{1} << bit)) ==
              may_drive(static_cast<State>(s), all & ~kind));
      }
    }
  }
  CHECK(compared > 3);
}

TEST_CASE("every row of the table decides some situation") {
  std::array<bool, kTable.size()> used{};
  for_every_situation([&](State state, Request request, Conditions met, Reaction reaction) {
    for (std::size_t i = 0; i < kTable.size(); ++i) {
      const Row& row = kTable[i];
      const bool from = ((row.from >> static_cast<unsigned>(state)) & 1U) != 0;
      const bool lacks = row.lacks == 0 || !has(met, row.lacks);
      const bool on = row.on == 0 || (row.on & by(reaction)) != 0;
      if (!from || row.request != request || !has(met, row.needs) || !lacks || !on) continue;
      used[i] = true;
      break;
    }
  });
  for (std::size_t i = 0; i < used.size(); ++i) {
    CAPTURE(i);
    CHECK(used[i]);
  }
}

TEST_CASE("the boat may push in eight states, under each state's own conditions, and in no other") {
  std::uint64_t wrong = 0;
  for_every_situation([&](State state, Request, Conditions met, Reaction) {
    const World is(met);
    const bool fit =
        (state == State::kManual && is.sound && is.sticks && is.centred) ||
        (state == State::kFormation && is.formation()) ||
        (state == State::kCoast && is.law() && is.limits && is.coasts) ||
        (state == State::kAuto && is.sails()) || (state == State::kGuided && is.guided()) ||
        (state == State::kLoiter && is.waits()) || (state == State::kReturn && is.returns()) ||
        (state == State::kTest && is.sound && is.test);
    if (may_drive(state, met) != fit || (fit && !armed(state))) ++wrong;
  });
  CHECK(wrong == 0);
  CHECK(armed(State::kHold));
  CHECK_FALSE(armed(State::kDisarmed));
  CHECK_FALSE(armed(State::kFault));
}

TEST_CASE("a boat that enters or keeps a state with thrust may push at once") {
  std::uint64_t wrong = 0;
  for_every_situation([&](State state, Request request, Conditions met, Reaction reaction) {
    const State next = supervise(state, request, met, {reaction}).state;
    if (request != Request::kNone && next == state) return;  // looked at without a request
    // COAST has just begun where the boat comes into it. In MANUAL it waits for the sticks.
    const Conditions begun = state == State::kCoast ? met : met | kCoastRunning;
    const Conditions now = next == State::kManual ? begun | kSticksCentred : begun;
    const bool pushes = next == State::kManual || law_drives(next) || next == State::kTest;
    if (pushes && !may_drive(next, now)) ++wrong;
  });
  CHECK(wrong == 0);
}

TEST_CASE("a granted request, except for a motor test, is granted again and changes nothing more") {
  std::uint64_t wrong = 0;
  for_every_situation([&](State state, Request request, Conditions met, Reaction) {
    if (request == Request::kNone || request == Request::kTest) return;
    const Verdict first = supervise(state, request, met);
    const Verdict again = supervise(first.state, request, met);
    if (again.state != first.state || again.granted != first.granted) ++wrong;
  });
  CHECK(wrong == 0);
}

TEST_CASE("a refusal names exactly the unmet conditions, and meeting them is enough") {
  std::uint64_t wrong = 0;
  for_every_situation([&](State state, Request request, Conditions met, Reaction) {
    const Verdict refused = supervise(state, request, met);
    if (refused.granted || refused.missing == 0) return;
    if (!supervise(state, request, met | refused.missing).granted) ++wrong;
  });
  CHECK(wrong == 0);
  CHECK(supervise(State::kDisarmed, Request::kArm, kLeaderFresh).missing == kArming);
  CHECK(supervise(State::kHold, Request::kManual, 0).missing == (kSound | kSticksFresh));
  CHECK(supervise(State::kHold, Request::kTest, kSound).missing == kTestRunning);
  CHECK(supervise(State::kFault, Request::kArm, 0).missing == 0);
  CHECK(supervise(State::kFormation, Request::kTest, 0).missing == 0);
  CHECK(supervise(State::kCoast, Request::kNone, kCoastDrive).missing == 0);
}

TEST_CASE("the lost condition is named when the boat changes its state automatically") {
  const auto lost = [](State state, Conditions unmet) {
    const Conditions met = kAllConditions & ~unmet;
    return supervise(state, Request::kNone, met, response_to(Choices{}, state, met));
  };
  CHECK(lost(State::kManual, kSticksFresh | kOwnFresh).missing == kSticksFresh);
  CHECK(lost(State::kFormation, kLeaderLive | kSticksFresh).missing == kLeaderLive);
  CHECK(lost(State::kFormation, kLeaderLive | kSticksFresh).state == State::kCoast);
  CHECK(lost(State::kFormation, kOnStation).state == State::kCoast);
  CHECK(lost(State::kFormation, kOnStation).missing == kOnStation);
  CHECK(lost(State::kTest, kTestRunning | kOwnFresh).missing == kTestRunning);
  CHECK(lost(State::kHold, kBusUp | kOwnFresh).missing == kBusUp);
  CHECK(lost(State::kCoast, kInRange | kOwnFresh).missing == kInRange);
  CHECK(lost(State::kCoast, kInRange).state == State::kFault);
  CHECK(lost(State::kCoast, kFollows | kCoastRunning).missing == kCoastRunning);
  CHECK(lost(State::kCoast, 0).missing == 0);
}

/// The specification of the reactions: from each lost condition to the boat's response.
Reaction chosen(const Choices& choices, State state, Conditions met) {
  const World is(met);
  const bool behind = state == State::kFormation || state == State::kCoast;
  const bool needs_station = behind || state == State::kAuto || state == State::kGuided;
  const bool keeps_limits = needs_station || state == State::kLoiter;
  std::vector<Reaction> all;
  const auto add = [&](bool lost, Reaction choice) {
    if (!lost) return;
    if (choice == Reaction::kManual && !has(met, kSticksFresh)) choice = Reaction::kHold;
    const bool goes_on = choice == Reaction::kCoast || choice == Reaction::kManual;
    if (goes_on && !behind) choice = Reaction::kHold;
    if (goes_on && state == State::kCoast && choice != Reaction::kHold) {
      choice = is.coasts ? Reaction::kCoast : choices.coast_end;
    }
    all.push_back(choice);
  };
  add(behind && !is.follows(), choices.leader);
  add(needs_station && !is.gcs, choices.gcs);
  add(keeps_limits && !has(met, kBatteryGood), choices.battery);
  add(keeps_limits && !has(met, kInsideFence), choices.fence);
  using enum Reaction;
  for (const Reaction careful : {kHold, kLoiter, kReturn, kCoast, kManual}) {
    if (std::ranges::find(all, careful) != all.end()) return careful;
  }
  return kNone;
}

TEST_CASE("of several losses the one with the most careful reaction counts") {
  using enum Reaction;
  constexpr std::array kActions{kHold, kCoast, kManual, kLoiter, kReturn};
  constexpr std::array kStops{kHold, kLoiter, kReturn};
  constexpr std::array kParts{kLeaderFresh, kOnStation,    kGcsHeard,   kBatteryGood,
                              kInsideFence, kCoastRunning, kSticksFresh};
  std::uint64_t wrong = 0, compared = 0;
  const auto compare = [&](const Choices& choices) {
    for (unsigned lost = 0; lost < 1U << kParts.size(); ++lost) {
      Conditions met = kAllConditions;
      for (std::size_t i = 0; i < kParts.size(); ++i) {
        if ((lost >> i & 1U) != 0) met &= ~kParts[i];
      }
      for (unsigned s = 0; s < kStates; ++s) {
        const auto state = static_cast<State>(s);
        const Response response = response_to(choices, state, met);
        const Reaction reaction = response.reaction;
        wrong += (response.lost & met) != 0 || (response.lost == 0) != (reaction == kNone);
        wrong += reaction != chosen(choices, state, met);
        wrong += !is_possible(state, met, reaction);
        ++compared;
      }
    }
  };
  for (const Reaction leader : kActions) {
    for (const Reaction gcs : kActions) {
      for (const Reaction battery : kStops) {
        for (const Reaction fence : kStops) {
          for (const Reaction end : kStops) compare({leader, gcs, battery, fence, end});
        }
      }
    }
  }
  CHECK(wrong == 0);
  CHECK(compared == 5 * 5 * 3 * 3 * 3 * 128 * kStates);
}

TEST_CASE("a boat that lost its navigation and its leader can be driven home") {
  constexpr Conditions kBlind = kSound | kSticksFresh | kSticksCentred;
  const State held = supervise(State::kFormation, Request::kNone, kBlind).state;
  CHECK(held == State::kHold);
  CHECK(supervise(held, Request::kManual, kBlind).state == State::kManual);
  CHECK(supervise(State::kManual, Request::kNone, kBlind).state == State::kManual);
  CHECK(may_drive(State::kManual, kBlind));
}

TEST_CASE("the conditions missing for FORMATION are named when a boat is armed without it") {
  std::uint64_t wrong = 0;
  for_every_situation([&](State state, Request request, Conditions met, Reaction) {
    const Verdict armed = supervise(state, request, met);
    if (request == Request::kNone || !armed.granted) return;
    const bool arms = state == State::kDisarmed && armed.state == State::kHold;
    // A boat that can sail its plan lacks nothing.
    const Conditions lacked = supervise(State::kHold, Request::kFormation, met).missing;
    const Conditions refused =
        supervise(State::kHold, Request::kAuto, met).granted ? Conditions{0} : lacked;
    if (armed.missing != (arms ? refused : 0)) ++wrong;
  });
  CHECK(wrong == 0);
}

TEST_CASE("after a FAULT a boat with a low battery, lost and out of its fence can be driven home") {
  constexpr Conditions kStranded = kArming | kSticksFresh | kSticksCentred;
  CHECK(supervise(State::kManual, Request::kNone, kStranded & ~kEscsOnline).state == State::kFault);
  CHECK(supervise(State::kFault, Request::kDisarm, kStranded).state == State::kDisarmed);
  CHECK(supervise(State::kDisarmed, Request::kArm, kStranded).state == State::kHold);
  CHECK_FALSE(supervise(State::kHold, Request::kFormation, kStranded).granted);
  CHECK(supervise(State::kHold, Request::kManual, kStranded).state == State::kManual);
  CHECK(may_drive(State::kManual, kStranded));
}

static_assert(supervise(State::kHold, Request::kFormation, kAllConditions).granted);
static_assert(supervise(State::kHold, Request::kAuto, kAllConditions).granted);

}  // namespace
}  // namespace flotilla::core
