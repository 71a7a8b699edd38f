// SPDX-License-Identifier: MIT
#include "core/closed_loop.hpp"
#include "core/controller.hpp"

namespace flotilla::core {
namespace {

using testing::ClosedLoop;
using testing::Random;

const auto kNumber = [](auto x) { return testing::number_of(x); };

TEST_CASE_TEMPLATE("a step is error, virtual velocity, wrench and thrusts in this order", S, float,
                   double) {
  Random random(22);
  const ControllerParams<S> params = testing::papers_controller<S>();
  const Encounter<S> in = testing::arbitrary_encounter<S>(random);
  ControllerState<S> state = controller_start(in);
  CHECK(state.outer.v_star == in.nu_L.v);  // v*(0) = v_L(0)
  VirtualVelocityState<S> outer = state.outer;
  const ControllerOutput<S> out = controller_step(params, state, in, S(0));
  const auto error = formation_error(in, params.d);
  const auto wanted = virtual_velocity(params.outer, outer, in, error);
  const Tau<S> tau = pd_plus(params.inner, params.vessel, wanted, in.nu);
  CHECK(out.error.e.y == error.e.y);
  CHECK(out.wanted.nu_star.v == in.nu_L.v);
  CHECK(out.tau.X == tau.X);
  CHECK(out.tau.N == tau.N);
  CHECK(out.allocation.thrust.port == allocate(params.propellers, tau).thrust.port);
  CHECK(state.outer.r_star_held == wanted.nu_star.r);
}

TEST_CASE_TEMPLATE("the paper's first boat reaches its slot behind the S-curve within 100 s", S,
                   float, double) {
  ClosedLoop world;
  ControllerState<S> state;
  Error<double> e = testing::sail<S>(world, state, 20, testing::s_curve, kNumber);
  CHECK(std::abs(std::hypot(e.x, e.y, e.psi) - 0.72) < 0.02);  // DESIGN.md, section 2, fact 1
  e = testing::sail<S>(world, state, 100, testing::s_curve, kNumber);
  CHECK(std::hypot(e.x, e.y, e.psi) < 0.02);
}

TEST_CASE_TEMPLATE("a leader on a circle is followed, and when it stops the boat stops beside it",
                   S, float, double) {
  const auto circle_then_stop = [](double t) {
    return t < 200 ? Tau<double>{2, 0.15} : Tau<double>{0, 0};
  };
  ClosedLoop world;
  ControllerState<S> state;
  const Error<double> sailing = testing::sail<S>(world, state, 200, circle_then_stop, kNumber);
  CHECK(std::hypot(sailing.x, sailing.y, sailing.psi) < 0.02);
  CHECK(std::abs(world.boat.q[3]) > 0.4);
  const Error<double> stopped = testing::sail<S>(world, state, 300, circle_then_stop, kNumber);
  CHECK(std::hypot(stopped.x, stopped.y, stopped.psi) < 0.02);
  for (std::size_t i = 3; i < 6; ++i) CHECK(std::abs(world.boat.q[i]) < 1e-3);
}

TEST_CASE_TEMPLATE("in float and from any start the boat never leaves the numbers", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 23;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 20; ++run) {
    ClosedLoop world;
    world.boat.q = {random(-30, 30), random(-30, 30), random.angle(), random(-2, 2), 0,
                    random(-1, 1)};
    ControllerState<S> state;
    const Error<double> e = testing::sail<S>(world, state, 60, testing::s_curve, kNumber);
    CHECK(std::isfinite(e.x + e.y + e.psi));
    CHECK(std::hypot(e.x, e.y) < 60);
  }
}

}  // namespace
}  // namespace flotilla::core
