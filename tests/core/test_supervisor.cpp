// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <optional>

#include "core/supervisor.hpp"

namespace flotilla::core {
namespace {

/// Calls f(state, request, conditions) for all there are.
template <class F>
void for_every_situation(F f) {
  for (unsigned s = 0; s < kStates; ++s) {
    for (unsigned r = 0; r < kRequests; ++r) {
      for (unsigned c = 0; c <= kAllConditions; ++c) {
        CAPTURE(s);
        CAPTURE(r);
        CAPTURE(c);
        f(static_cast<State>(s), static_cast<Request>(r), static_cast<Conditions>(c));
      }
    }
  }
}

bool has(Conditions met, Conditions wanted) { return (met & wanted) == wanted; }

/// The rule as the header words it.
std::optional<std::size_t> first_fit(State state, Request request, Conditions met) {
  for (std::size_t i = 0; i < kTable.size(); ++i) {
    const Row& row = kTable[i];
    const bool from = ((row.from >> static_cast<unsigned>(state)) & 1U) != 0;
    const bool lacks = row.lacks == 0 || !has(met, row.lacks);
    if (from && row.request == request && has(met, row.needs) && lacks) return i;
  }
  return std::nullopt;
}

TEST_CASE("every situation is decided by the first row that fits, or nothing changes") {
  for_every_situation([](State state, Request request, Conditions met) {
    const Verdict verdict = supervise(state, request, met);
    const auto row = first_fit(state, request, met);
    CHECK(verdict.granted == row.has_value());
    CHECK(verdict.state == (row ? kTable[*row].to : state));
    if (verdict.granted) CHECK(verdict.missing == (row ? kTable[*row].lacks & ~met : 0));
    CHECK((verdict.missing & met) == 0);
  });
}

TEST_CASE("every row of the table decides some situation") {
  std::array<bool, kTable.size()> used{};
  for_every_situation([&](State state, Request request, Conditions met) {
    if (const auto row = first_fit(state, request, met)) used[*row] = true;
  });
  for (std::size_t i = 0; i < used.size(); ++i) {
    CAPTURE(i);
    CHECK(used[i]);
  }
}

TEST_CASE("the boat may push in FORMATION with all well, and never else") {
  for_every_situation([](State state, Request, Conditions met) {
    CHECK(may_drive(state, met) == (state == State::kFormation && has(met, kDrive)));
    if (may_drive(state, met)) CHECK(armed(state));
  });
  CHECK_FALSE(armed(State::kDisarmed));
  CHECK_FALSE(armed(State::kFault));
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
    if (state == State::kDisarmed && next != State::kDisarmed) {
      CHECK(request == Request::kArm);
      CHECK(next == State::kHold);
      CHECK(has(met, kOwnFresh | kPropulsion | kParametersSaved));
    }
  });
}

TEST_CASE("FORMATION is entered from HOLD, by request, with all well, and in no other way") {
  for_every_situation([](State state, Request request, Conditions met) {
    if (state != State::kFormation && supervise(state, request, met).state == State::kFormation) {
      CHECK(state == State::kHold);
      CHECK(request == Request::kFormation);
      CHECK(has(met, kDrive));
    }
  });
}

TEST_CASE("ESCs or bus lost, or another controller, while armed: FAULT; a state lost: HOLD") {
  for_every_situation([](State state, Request, Conditions met) {
    const Verdict verdict = supervise(state, Request::kNone, met);
    if (armed(state) && !has(met, kPropulsion)) {
      CHECK(verdict.state == State::kFault);
    } else if (state == State::kFormation && !has(met, kDrive)) {
      CHECK(verdict.state == State::kHold);
    } else {
      CHECK(verdict.state == state);
      CHECK_FALSE(verdict.granted);
    }
  });
}

TEST_CASE("a request that was granted is granted again and changes nothing more") {
  for_every_situation([](State state, Request request, Conditions met) {
    if (request == Request::kNone) return;
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
  CHECK(supervise(State::kFault, Request::kArm, 0).missing == 0);
}

static_assert(supervise(State::kHold, Request::kFormation, kAllConditions).granted);

}  // namespace
}  // namespace flotilla::core
