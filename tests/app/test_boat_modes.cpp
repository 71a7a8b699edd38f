// SPDX-License-Identifier: MIT
// A boat driven by sticks, by a motor test, or behind a leader with a different clock.
#include <doctest/doctest.h>

#include <cstring>

#include "app/harbour.hpp"

namespace flotilla::app {
namespace {

using core::State;
namespace mav = link::mav;

template <class S>
using Harbour = testing::Harbour<S>;

/// A tick with the sticks held.
template <class S>
void step_with_sticks(Harbour<S>& h, std::int16_t surge, std::int16_t yaw) {
  h.tell(h.operator_, link::ManualControl{surge, 0, 0, yaw, 0, 1});
  h.step();
}

TEST_CASE_TEMPLATE("in MANUAL the sticks drive, and without them both propellers stop", S, float,
                   double) {
  Harbour<S> h;
  h.sail(2);
  h.arm();
  h.step();
  for (int k = 0; k < 30; ++k) step_with_sticks(h, 500, 0);
  h.mode(mode::kManual);
  for (int k = 0; k < 60; ++k) step_with_sticks(h, 500, 0);
  CHECK(h.boat.state() == State::kManual);
  CHECK(h.stopped());  // the sticks have not been at neutral yet
  step_with_sticks(h, 0, 0);
  for (int k = 0; k < 60; ++k) step_with_sticks(h, 500, 0);
  CHECK(h.raw.cmd[0] > 3000);
  CHECK(h.raw.cmd[0] == h.raw.cmd[1]);
  for (int k = 0; k < 60; ++k) step_with_sticks(h, 0, 1000);
  CHECK(h.raw.cmd[0] > 1000);  // to starboard
  CHECK(h.raw.cmd[1] == -h.raw.cmd[0]);
  h.sail(0.52);
  CHECK(h.boat.state() == State::kHold);
  CHECK(h.stopped());
}

TEST_CASE_TEMPLATE(
    "a motor test turns only the requested propeller, and stops after the requested time", S, float,
    double) {
  for (const bool stbd : {false, true}) {
    Harbour<S> h;
    h.sail(2);
    h.arm();
    h.sail(0.5);
    h.tell(h.operator_,
           link::CommandLong{mav::kCmdDoMotorTest, {stbd ? 2.0F : 1.0F, 0, 10, 1}, {1, 1}, 0});
    h.sail(0.5);
    CHECK(h.boat.state() == State::kTest);
    CHECK(h.raw.cmd[stbd ? 1 : 0] == doctest::Approx(819).epsilon(0.01));
    CHECK(h.raw.cmd[stbd ? 0 : 1] == 0);
    h.sail(0.6);
    CHECK(h.boat.state() == State::kHold);
    CHECK(h.stopped());
  }
}

TEST_CASE_TEMPLATE("a leader that answers TIMESYNC is known more precisely", S, float, double) {
  Harbour<S> h;
  h.cast_off();
  const double before_m = h.boat.snapshot().leader_uncertainty_m.value();
  bool asked = false;
  for (int k = 0; k < 500; ++k) {
    h.step();
    for (const auto& request : h.template all<link::Timesync>()) {
      if (request.tc1 != 0) continue;
      asked = true;
      h.tell(h.leader, link::Timesync{(h.now_us + h.leader_clock_us) * 1000, request.ts1, {1, 1}});
    }
  }
  CHECK(asked);
  CHECK(h.boat.snapshot().leader_uncertainty_m.value() <= before_m);
  CHECK(h.pushes());
}

TEST_CASE_TEMPLATE("ODOMETRY in a frame without north is refused, and the operator is informed", S,
                   float, double) {
  Harbour<S> h;
  h.sail(1);
  link::Odometry odometry = Harbour<S>::state(h.now_us, 0, 0);
  odometry.frame_id = mav::kFrameBodyFrd;
  h.tell(h.navigation, odometry);
  h.step();
  CHECK(h.says("ODOMETRY refused"));
  CHECK(h.boat.snapshot().counters.mavlink_bad_frame == 1);
}

TEST_CASE_TEMPLATE("a propeller that turns the other way gets the opposite sign", S, float,
                   double) {
  Harbour<S> h(Parameters{.THR_PORT_DIR = -1});
  h.cast_off();
  CHECK(h.raw.cmd[0] < 0);
  CHECK(h.raw.cmd[1] > 0);
  CHECK(h.boat.snapshot().thrust_N.port > 0);
}

TEST_CASE_TEMPLATE("a boat refuses to follow itself", S, float, double) {
  Harbour<S> h;
  h.sail(2);
  link::ParamSet leader{1, {1, 1}, {}, mav::kParamReal32};
  std::strncpy(leader.param_id.data(), "FORM_LEADER", leader.param_id.size());
  h.tell(h.operator_, leader);
  h.step();
  CHECK(h.boat.parameters().FORM_LEADER == 100);
}

}  // namespace
}  // namespace flotilla::app
