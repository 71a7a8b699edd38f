// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <map>
#include <vector>

#include "core/supervisor.hpp"

namespace flotilla::core {
namespace {

constexpr unsigned kBits = 23;  // conditions and choices

/// Conditions that no row tells apart: what holds of one holds of all.
std::vector<Conditions> classes() {
  std::map<std::vector<bool>, Conditions> found;
  for (unsigned bit = 0; bit < kBits; ++bit) {
    std::vector<bool> role;
    const auto note = [&](Conditions set) { role.push_back((set >> bit & 1U) != 0); };
    for (const Row& row : kTable) {
      note(row.needs);
      note(row.lacks);
    }
    for (const Conditions set : {kManualDrive, kDrive, kCoastDrive, kTestDrive}) note(set);
    found[role] |= 1U << bit;
  }
  std::vector<Conditions> out;
  for (const auto& [role, set] : found) out.push_back(set);
  return out;
}

/// Calls f(state, request, conditions) for all there are.
template <class F>
void for_every_situation(F f) {
  const std::vector<Conditions> of = classes();
  for (unsigned s = 0; s < kStates; ++s) {
    for (unsigned r = 0; r < kRequests; ++r) {
      for (unsigned c = 0; c >> of.size() == 0; ++c) {
        Conditions met = 0;
        for (std::size_t i = 0; i < of.size(); ++i) met |= (c >> i & 1U) != 0 ? of[i] : 0;
        f(static_cast<State>(s), static_cast<Request>(r), met);
      }
    }
  }
}

bool has(Conditions met, Conditions wanted) { return (met & wanted) == wanted; }

/// What an operator reads in DESIGN.md, section 6; knows nothing of the table.
struct Expected {
  State state;
  bool granted;
};

Expected by_itself(State state, bool propulsion, Conditions met) {
  const bool is_armed = state != State::kDisarmed && state != State::kFault;
  if (is_armed && !propulsion) return {State::kFault, true};
  if (state == State::kFormation && (!has(met, kOwnFresh) || !has(met, kLeaderFresh))) {
    return {State::kHold, true};
  }
  if (state == State::kManual && !has(met, kSticksFresh)) return {State::kHold, true};
  if (state == State::kTest && !has(met, kTestRunning)) return {State::kHold, true};
  return {state, false};
}

Expected when_armed_and_asked(State state, Request request, bool propulsion, Conditions met) {
  if (request == Request::kArm) return {state, true};
  if (request == Request::kHold) return {State::kHold, true};
  if (request == Request::kManual) {
    if (state == State::kManual) return {state, true};
    if (state != State::kTest && propulsion && has(met, kSticksFresh)) {
      return {State::kManual, true};
    }
  }
  if (request == Request::kFormation) {
    if (state == State::kFormation) return {state, true};
    if (state != State::kTest && propulsion && has(met, kOwnFresh) && has(met, kLeaderFresh)) {
      return {State::kFormation, true};
    }
  }
  if (request == Request::kTest && state == State::kHold) {
    if (propulsion && has(met, kTestRunning)) return {State::kTest, true};
  }
  return {state, false};
}

Expected specified(State state, Request request, Conditions met) {
  const bool propulsion = has(met, kEscsOnline) && has(met, kBusUp) && has(met, kSoleController);
  if (request == Request::kDisarm) return {State::kDisarmed, true};
  if (request == Request::kTerminate) return {State::kFault, true};
  if (request == Request::kNone) return by_itself(state, propulsion, met);
  if (state == State::kFault) return {state, false};
  if (state != State::kDisarmed) return when_armed_and_asked(state, request, propulsion, met);
  if (request == Request::kHold) return {state, true};
  const bool fit = propulsion && has(met, kOwnFresh) && has(met, kParametersSaved);
  if (request == Request::kArm && fit) return {State::kHold, true};
  return {state, false};
}

TEST_CASE("every state, request and set of conditions ends where the specification says") {
  for_every_situation([](State state, Request request, Conditions met) {
    const Expected expected = specified(state, request, met);
    const Verdict verdict = supervise(state, request, met);
    CHECK(verdict.state == expected.state);
    CHECK(verdict.granted == expected.granted);
    CHECK((verdict.missing & met) == 0);
  });
}

TEST_CASE("every row of the table decides some situation") {
  std::array<bool, kTable.size()> used{};
  for_every_situation([&](State state, Request request, Conditions met) {
    for (std::size_t i = 0; i < kTable.size(); ++i) {
      const Row& row = kTable[i];
      const bool from = ((row.from >> static_cast<unsigned>(state)) & 1U) != 0;
      const bool lacks = row.lacks == 0 || !has(met, row.lacks);
      if (!from || row.request != request || !has(met, row.needs) || !lacks) continue;
      used[i] = true;
      break;
    }
  });
  for (std::size_t i = 0; i < used.size(); ++i) {
    CAPTURE(i);
    CHECK(used[i]);
  }
}

TEST_CASE("the boat may push in MANUAL, FORMATION and TEST, each with its conditions, never else") {
  constexpr Conditions kBothEscsOurs = kEscsOnline | kBusUp | kSoleController;
  for_every_situation([](State state, Request, Conditions met) {
    bool fit = has(met, kBothEscsOurs);
    if (state == State::kManual) {
      fit = fit && has(met, kSticksFresh);
    } else if (state == State::kFormation) {
      fit = fit && has(met, kOwnFresh | kLeaderFresh);
    } else if (state == State::kTest) {
      fit = fit && has(met, kTestRunning);
    } else {
      fit = false;
    }
    CHECK(may_drive(state, met) == fit);
    if (fit) CHECK(armed(state));
  });
  CHECK(armed(State::kHold));
  CHECK_FALSE(armed(State::kDisarmed));
  CHECK_FALSE(armed(State::kFault));
}

TEST_CASE("a boat that stays or comes into a state that pushes may push at once") {
  for_every_situation([](State state, Request request, Conditions met) {
    const State own = supervise(state, Request::kNone, met).state;  // as each tick begins
    const State next = supervise(own, request, met).state;
    const bool pushes = next == State::kManual || next == State::kFormation || next == State::kTest;
    if (pushes) CHECK(may_drive(next, met));
  });
}

TEST_CASE("disarming always works") {
  for_every_situation([](State state, Request, Conditions met) {
    const Verdict verdict = supervise(state, Request::kDisarm, met);
    CHECK(verdict.granted);
    CHECK(verdict.state == State::kDisarmed);
  });
}

TEST_CASE("FAULT is left by disarming only; arming needs own state, propulsion, saved parameters") {
  for_every_situation([](State state, Request request, Conditions met) {
    const State next = supervise(state, request, met).state;
    if (state == State::kFault && next != State::kFault) CHECK(request == Request::kDisarm);
    if (state == State::kDisarmed && armed(next)) {
      CHECK(request == Request::kArm);
      CHECK(next == State::kHold);
      CHECK(has(met, kOwnFresh | kPropulsion | kParametersSaved));
    }
  });
}

TEST_CASE("the flight is terminated from any state, and only disarming ends that") {
  for_every_situation([](State state, Request request, Conditions met) {
    const Verdict verdict = supervise(state, Request::kTerminate, met);
    CHECK(verdict.granted);
    CHECK(verdict.state == State::kFault);
    const Verdict after = supervise(verdict.state, request, met);
    CHECK(after.state == (request == Request::kDisarm ? State::kDisarmed : State::kFault));
  });
}

TEST_CASE("a state that pushes is entered by its own request, and TEST from HOLD only") {
  for_every_situation([](State state, Request request, Conditions met) {
    const State next = supervise(state, request, met).state;
    if (next == state) return;
    if (next == State::kManual) {
      CHECK(request == Request::kManual);
      CHECK((state == State::kHold || state == State::kFormation));
    } else if (next == State::kFormation) {
      CHECK(request == Request::kFormation);
      CHECK((state == State::kHold || state == State::kManual));
    } else if (next == State::kTest) {
      CHECK(request == Request::kTest);
      CHECK(state == State::kHold);
    }
  });
}

TEST_CASE("a boat that lost its navigation and its leader can be driven home") {
  constexpr Conditions kBlind = kEscsOnline | kBusUp | kSoleController | kSticksFresh;
  const State held = supervise(State::kFormation, Request::kNone, kBlind).state;
  CHECK(held == State::kHold);
  CHECK(supervise(held, Request::kManual, kBlind).state == State::kManual);
  CHECK(supervise(State::kManual, Request::kNone, kBlind).state == State::kManual);
  CHECK(may_drive(State::kManual, kBlind));
}

TEST_CASE("what the boat lost is named when it stops by itself") {
  const auto lost = [](State state, Conditions unmet) {
    return supervise(state, Request::kNone, static_cast<Conditions>(kAllConditions & ~unmet))
        .missing;
  };
  CHECK(lost(State::kManual, kSticksFresh | kOwnFresh) == kSticksFresh);
  CHECK(lost(State::kFormation, kLeaderFresh | kSticksFresh) == kLeaderFresh);
  CHECK(lost(State::kTest, kTestRunning | kOwnFresh) == kTestRunning);
  CHECK(lost(State::kHold, kBusUp | kOwnFresh) == kBusUp);
}

TEST_CASE("a request that was granted is granted again, but for a test, and changes nothing more") {
  for_every_situation([](State state, Request request, Conditions met) {
    if (request == Request::kNone || request == Request::kTest) return;
    const Verdict first = supervise(state, request, met);
    const Verdict again = supervise(first.state, request, met);
    CHECK(again.state == first.state);
    CHECK(again.granted == first.granted);
  });
}

TEST_CASE("a refusal for want of conditions names exactly those, and meeting them is enough") {
  for_every_situation([](State state, Request request, Conditions met) {
    const Verdict refused = supervise(state, request, met);
    if (refused.granted || refused.missing == 0) return;
    const auto completed = static_cast<Conditions>(met | refused.missing);
    CHECK(supervise(state, request, completed).granted);
  });
  CHECK(supervise(State::kDisarmed, Request::kArm, kLeaderFresh).missing ==
        (kOwnFresh | kPropulsion | kParametersSaved));
  CHECK(supervise(State::kHold, Request::kManual, 0).missing == (kPropulsion | kSticksFresh));
  CHECK(supervise(State::kHold, Request::kTest, kPropulsion).missing == kTestRunning);
  CHECK(supervise(State::kFault, Request::kArm, 0).missing == 0);
  CHECK(supervise(State::kFormation, Request::kTest, 0).missing == 0);
}

static_assert(supervise(State::kHold, Request::kFormation, kAllConditions).granted);

}  // namespace
}  // namespace flotilla::core
