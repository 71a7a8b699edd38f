// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "app/supervisor.hpp"

namespace flotilla::app {
namespace {

using core::Request;
using core::State;

constexpr link::Address kFirst{255, 190}, kSecond{254, 190};
constexpr Sticks kNeutral{0, 0}, kFull{1, 0};

/// Ticks of 10 ms of a boat with sound propellers, without the conditions in `lost`.
struct Helm {
  Supervisor supervisor;
  std::int64_t now_us = 1'000'000;
  core::Conditions lost = core::kSticksFresh | core::kSticksCentred | core::kTestRunning;

  core::Conditions met() const {
    return (core::kAllConditions & ~lost) | supervisor.conditions(now_us);
  }
  State tick(Request request = Request::kNone) {
    now_us += 10'000;
    static_cast<void>(supervisor.apply_conditions(met(), now_us));
    if (request != Request::kNone) static_cast<void>(supervisor.request(request, now_us));
    return supervisor.state();
  }
  State hear(const Sticks& sticks, Request request = Request::kNone, link::Address from = kFirst) {
    supervisor.take_sticks(sticks, from, now_us + 5'000);
    return tick(request);
  }
  State hear_for(int ticks, const Sticks& sticks, link::Address from = kFirst) {
    for (int i = 0; i < ticks; ++i) hear(sticks, Request::kNone, from);
    return supervisor.state();
  }
  bool pushes() const { return supervisor.may_drive(met(), now_us); }

  /// Armed, and the ESCs have received zeros.
  Helm() {
    tick(Request::kArm);
    for (int i = 0; i < 30; ++i) tick();
  }
};

TEST_CASE("sticks at neutral when MANUAL is requested: they drive at once") {
  Helm helm;
  CHECK(helm.hear({0.1, -0.1}, Request::kManual) == State::kManual);
  CHECK(helm.pushes());
  helm.hear(kFull);
  CHECK(helm.pushes());
}

TEST_CASE(
    "sticks off neutral when MANUAL is requested: no thrust until they have been at neutral") {
  for (const Sticks off : {kFull, Sticks{-1, 0}, Sticks{0.11, 0}, Sticks{0, 0.11}, Sticks{0, -1}}) {
    Helm helm;
    CHECK(helm.hear(off, Request::kManual) == State::kManual);
    CHECK_FALSE(helm.pushes());
    CHECK(helm.hear_for(200, off) == State::kManual);
    CHECK_FALSE(helm.pushes());
    helm.hear(kNeutral);
    helm.hear(off);
    CHECK(helm.pushes());
  }
}

TEST_CASE("sticks at neutral before the request, or in an earlier MANUAL, do not permit thrust") {
  Helm helm;
  helm.hear_for(100, kNeutral);
  helm.hear(kFull, Request::kManual);
  CHECK_FALSE(helm.pushes());
  helm.hear(kNeutral);
  helm.hear(kFull, Request::kHold);
  helm.tick(Request::kManual);
  CHECK(helm.supervisor.state() == State::kManual);
  CHECK_FALSE(helm.pushes());
}

TEST_CASE("HOLD and MANUAL in one tick restart MANUAL") {
  Helm helm;
  helm.hear(kNeutral, Request::kManual);
  helm.hear(kFull);
  CHECK(helm.pushes());
  CHECK(helm.supervisor.request(Request::kHold, helm.now_us).granted);
  CHECK(helm.supervisor.request(Request::kManual, helm.now_us).granted);
  CHECK(helm.supervisor.state() == State::kManual);
  CHECK_FALSE(helm.pushes());
}

TEST_CASE("a failsafe brings a boat into MANUAL while a pilot holds full ahead: no thrust yet") {
  for (const bool leader : {true, false}) {
    Helm helm;
    helm.supervisor.choose({.leader = core::Reaction::kManual, .gcs = core::Reaction::kManual});
    helm.hear(kFull, Request::kFormation);
    REQUIRE(helm.supervisor.state() == State::kFormation);
    CHECK(helm.pushes());
    helm.lost |= leader ? core::kLeaderFresh : core::kGcsHeard;
    CHECK(helm.hear(kFull) == State::kManual);
    CHECK_FALSE(helm.pushes());
    helm.hear(kNeutral);
    CHECK(helm.pushes());
  }
}

TEST_CASE("MANUAL requested again in MANUAL changes nothing") {
  Helm helm;
  helm.hear(kNeutral, Request::kManual);
  helm.hear(kFull, Request::kManual);
  CHECK(helm.pushes());
}

TEST_CASE("sticks fall silent and return at full ahead: HOLD, and a new MANUAL gives no thrust") {
  Helm helm;
  helm.hear(kNeutral, Request::kManual);
  helm.hear(kFull);
  for (int i = 0; i < 60; ++i) helm.tick();
  CHECK(helm.supervisor.state() == State::kHold);
  CHECK(helm.hear_for(10, kFull) == State::kHold);
  CHECK(helm.hear(kFull, Request::kManual) == State::kManual);
  CHECK_FALSE(helm.pushes());
}

TEST_CASE("half a second of silence leads to HOLD, whoever sends sticks before the tick") {
  for (const link::Address from : {kFirst, kSecond}) {
    Helm helm;
    helm.hear(kNeutral, Request::kManual);
    const std::int64_t silent_us = helm.now_us + 500'000;
    while (helm.now_us < silent_us - 10'000) helm.tick();
    CHECK(helm.supervisor.state() == State::kManual);
    helm.supervisor.take_sticks(kFull, from, helm.now_us + 9'000);
    CHECK(helm.tick() == State::kHold);
    CHECK(helm.hear(kFull, Request::kManual, from) == State::kManual);
    CHECK_FALSE(helm.pushes());
  }
}

}  // namespace
}  // namespace flotilla::app
