// SPDX-License-Identifier: MIT
// A boat in fixed point whose numbers exceed their range: it stops, and requires an inspection.
#include <doctest/doctest.h>

#include "app/harbour.hpp"

namespace flotilla::app {
namespace {

using core::Q16;
using core::State;
using testing::Harbour;

constexpr auto kSentence = "numeric overflow in the control law";

/// Gains of a ship, and 30 m to go: the law needs more newtons than Q16 can represent.
Parameters eager() {
  Parameters p;
  p.LAW_KDU = 10'000;
  p.LAW_U_MAX = 20;
  return p;
}

/// Ticks for a second: whether the boat gave thrust, and whether it reported why not.
template <class S>
std::pair<bool, bool> watch(Harbour<S>& h) {
  bool pushed = false, said = false;
  for (int i = 0; i < 100; ++i) {
    h.step();
    pushed = pushed || !h.stopped();
    said = said || h.says(kSentence);
  }
  return {pushed, said};
}

TEST_CASE("a wrench beyond the scalar's range: no thrust, not even once, and FAULT") {
  Harbour<Q16> h(eager());
  h.leader_north_m = 30;
  h.sail(2);
  h.arm();
  h.step();
  CHECK(h.boat.state() == State::kHold);
  h.mode(6);
  const auto [pushed, said] = watch(h);
  CHECK_FALSE(pushed);
  CHECK(said);
  CHECK(h.boat.state() == State::kFault);
  CHECK(h.arming == 0);
}

TEST_CASE("disarming leaves FAULT; the boat arms and sails again, where its numbers fit") {
  Harbour<Q16> h(eager());
  h.leader_north_m = 30;
  h.cast_off();
  REQUIRE(h.boat.state() == State::kFault);
  h.mode(6);
  h.arm();
  h.sail(1);
  CHECK(h.boat.state() == State::kFault);
  h.disarm();
  h.sail(1);
  CHECK(h.boat.state() == State::kDisarmed);
  CHECK((h.boat.conditions() & core::kInRange) != 0);
  h.leader_north_m = 0.5F;
  h.cast_off();
  CHECK(h.boat.state() == State::kFormation);
  CHECK(h.pushes());
}

TEST_CASE_TEMPLATE("a boat in floating point is driven where Q16 has no room", S, float, double) {
  Harbour<S> h(eager());
  h.leader_north_m = 30;
  h.cast_off();
  CHECK(h.boat.state() == State::kFormation);
  CHECK(h.pushes());
  CHECK((h.boat.conditions() & core::kInRange) != 0);
}

TEST_CASE("a leader reported 40 km away is not believed: it is lost, and the boat coasts") {
  Harbour<Q16> h;
  h.cast_off();
  REQUIRE(h.boat.state() == State::kFormation);
  REQUIRE(h.pushes());
  h.leader_north_m = 40'000;
  const auto [pushed, said] = watch(h);
  CHECK_FALSE(said);
  CHECK(h.boat.state() == State::kCoast);
}

TEST_CASE("no ship that AIS can report, and no impossible one, stops a boat in fixed point") {
  Harbour<Q16> h;
  h.cast_off();
  for (const std::int32_t north_degE7 : {3'000, 40'000'000}) {
    link::AisVessel ship{};
    ship.MMSI = 211'000'001;
    ship.lat = 410'000'000 + north_degE7;
    ship.lon = 20'000'000;
    ship.flags = link::mav::kAisCourse | link::mav::kAisSpeed | link::mav::kAisDimensions;
    ship.COG = 35'999;
    ship.velocity = 5000;
    ship.dimension_bow = 65'535;
    ship.dimension_port = 255;
    h.tell(h.operator_, ship);
    h.sail(0.5);
    CHECK(h.boat.state() != State::kFault);
    CHECK((h.boat.conditions() & core::kInRange) != 0);
  }
}

TEST_CASE("a leader reported at 400 m/s is not believed: it is lost, and the boat at most coasts") {
  Harbour<Q16> h;
  h.cast_off();
  h.leader_talks = false;
  const auto before = h.raw.cmd;
  for (int i = 0; i < 300; ++i) {
    h.tell(h.leader, Harbour<Q16>::state(h.now_us + h.leader_clock_us, 0.5F, 400));
    h.step();
    CHECK(std::abs(h.raw.cmd[0]) <= std::max(std::abs(before[0]), std::abs(before[1])) + 8191);
    CHECK(h.boat.state() != State::kFault);
  }
  CHECK(h.boat.state() == State::kCoast);
}

TEST_CASE("Q16 cannot sail a ship of 40 t: it stays DISARMED and reports why") {
  Parameters p;
  p.VES_M11 = 40'000;
  Harbour<Q16> h(p);
  h.sail(2);
  CHECK((h.boat.conditions() & core::kInRange) == 0);
  h.arm();
  const auto [pushed, said] = watch(h);
  CHECK_FALSE(pushed);
  CHECK(said);
  CHECK(h.boat.state() == State::kDisarmed);
  Harbour<float> same(p);
  same.cast_off();
  CHECK(same.boat.state() == State::kFormation);
}

TEST_CASE("a boat's overflow does not affect another boat on the same thread") {
  Harbour<Q16> wild(eager()), calm;
  wild.leader_north_m = 30;
  for (Harbour<Q16>* h : {&wild, &calm}) h->sail(2);
  for (Harbour<Q16>* h : {&wild, &calm}) h->arm();
  for (Harbour<Q16>* h : {&wild, &calm}) h->step();
  for (Harbour<Q16>* h : {&wild, &calm}) h->mode(6);
  for (int i = 0; i < 100; ++i) {
    for (Harbour<Q16>* h : {&wild, &calm}) h->step();
  }
  CHECK(wild.boat.state() == State::kFault);
  CHECK(calm.boat.state() == State::kFormation);
}

TEST_CASE("hours of silence in HOLD cause no overflow") {
  Harbour<Q16> h;
  h.sail(2);
  h.arm();
  h.sail(1);
  REQUIRE(h.boat.state() == State::kHold);
  h.leader_talks = false;
  h.now_us += 36'000'000'000;
  h.sail(2);
  h.leader_talks = true;
  h.sail(3);
  CHECK((h.boat.conditions() & core::kInRange) != 0);
  CHECK(h.boat.state() != State::kDisarmed);
}

}  // namespace
}  // namespace flotilla::app
