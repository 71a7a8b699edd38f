// SPDX-License-Identifier: MIT
#include "core/closed_loop.hpp"
#include "core/controller.hpp"

namespace flotilla::core {
namespace {

using testing::ClosedLoop;
using testing::Random;

TEST_CASE_TEMPLATE("a step is error, virtual velocity, wrench and thrusts in this order", S, float,
                   double) {
  Random random(22);
  const ControllerParams<S> params = testing::papers_controller<S>();
  const ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
  ControllerState<S> state = controller_start(in);
  CHECK(state.outer.v_star == in.nu_L.v);  // v*(0) = v_L(0)
  VirtualVelocityState<S> outer = state.outer;
  const ControllerOutput<S> out = controller_step(params, state, in, S(0));
  const auto error = testing::papers_error(in, params.slot.d);
  const auto desired = testing::papers_velocity(params.outer, outer, in, params.slot.d);
  const Tau<S> tau = pd_plus(params.inner, params.vessel, desired, in.nu);
  CHECK(out.error.e.y == error.e.y);
  CHECK(out.desired.nu_star.v == in.nu_L.v);
  CHECK(out.tau.X == tau.X);
  CHECK(out.tau.N == tau.N);
  CHECK(out.allocation.thrust.port == allocate(params.propellers, tau).thrust.port);
  CHECK(state.outer.r_star_held == desired.nu_star.r);
}

TEST_CASE("v* follows from the step's final request: limited, and clear of other vessels") {
  constexpr std::uint32_t kSeed = 27;
  INFO("seed ", kSeed);
  Random random(kSeed);
  ControllerParams<double> params = testing::papers_controller<double>();
  params.outer.u_max = params.outer.r_max = 0.5;
  params.separation.least = 2;
  int yields = 0, limited = 0;
  for (int i = 0; i < 500; ++i) {
    const auto in = testing::arbitrary_encounter<double>(random);
    Traffic<double> traffic;
    traffic.vessels[0] = {{random(-5, 5), random(-5, 5)}, {}, 0, true};
    traffic.count = static_cast<std::size_t>(i % 2);
    ControllerState<double> state = controller_start(in);
    const auto out = controller_step(params, state, in, 0.0, &traffic);
    REQUIRE(state.outer.u_star_held == out.desired.nu_star.u);
    REQUIRE(state.outer.r_star_held == out.desired.nu_star.r);
    yields += out.separation.yielding;
    limited += out.limits() != 0;
  }
  CHECK(yields > 50);
  CHECK(limited > 50);
}

TEST_CASE("a slot that moves in the shape: a boat that faces away goes with it while it turns") {
  ControllerParams<double> params = testing::papers_controller<double>();
  ControllerInput<double> in;  // in its slot, bow astern
  in.psi = 3;
  in.nu = {-0.8, 0, 0};
  in.nu_L = {0.8, 0, 0};
  const auto u_star = [&] {
    ControllerState<double> state = controller_start(in);
    return controller_step(params, state, in, 0.0).desired.nu_star;
  };
  CHECK(u_star().u == doctest::Approx(0.8));
  params.slot.moves = true;
  CHECK(u_star().u == doctest::Approx(0.8 * std::cos(3.0)));
  CHECK(u_star().r < 0);
  in.psi = 0;
  CHECK(u_star().u == doctest::Approx(0.8));
}

TEST_CASE("in a current u* is relative to the water, and its derivative is its slope") {
  constexpr std::uint32_t kSeed = 25;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const auto in = testing::arbitrary_encounter<double>(random);
    const Vec2<double> c_n = {random(-0.5, 0.5), random(-0.5, 0.5)};
    const auto star = [&](double h) {
      const auto then = testing::later(in, h);
      VirtualVelocityState<double> state;
      const auto desired = testing::papers_velocity({0.2, 0.2}, state, then, {});
      return through_water(desired, to_body(then.psi, c_n), then.nu.r);
    };
    constexpr double h = 1e-4;
    const double slope = (star(h).nu_star.u - star(-h).nu_star.u) / (2 * h);
    CHECK(std::abs(slope - star(0).u_star_dot) < 1e-5);
  }
}

TEST_CASE("uniformly moving water does not affect boats that turn together") {
  constexpr std::uint32_t kSeed = 26;
  INFO("seed ", kSeed);
  Random random(kSeed);
  ControllerParams<double> params = testing::papers_controller<double>();
  for (int i = 0; i < 500; ++i) {
    auto still = testing::arbitrary_encounter<double>(random);
    still.psi_L = still.psi;
    still.nu_L.r = still.nu.r;
    ControllerInput<double> moving = still;
    moving.current_n = {random(-0.5, 0.5), random(-0.5, 0.5)};
    const Vec2<double> c = to_body(still.psi, moving.current_n);
    moving.nu = {still.nu.u + c.x, still.nu.v + c.y, still.nu.r};
    moving.nu_L = {still.nu_L.u + c.x, still.nu_L.v + c.y, still.nu_L.r};
    moving.nu_L_dot.u = still.nu_L_dot.u + still.nu.r * c.y;
    ControllerState<double> state = controller_start(still), other = controller_start(moving);
    CHECK(other.outer.v_star == testing::approx(state.outer.v_star));
    for (const double dt : {0.0, 0.01, 0.05}) {
      const Tau<double> tau = controller_step(params, state, still, dt).tau;
      const Tau<double> same = controller_step(params, other, moving, dt).tau;
      CHECK(same.X == testing::approx(tau.X, 500));
      CHECK(same.N == testing::approx(tau.N, 500));
    }
  }
}

TEST_CASE_TEMPLATE(
    "the virtual sway and the slot's sway start at the leader's sway through the water", S, float,
    double) {
  constexpr std::uint32_t kSeed = 27;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 200; ++i) {
    auto in = testing::arbitrary_encounter<S>(random);
    CHECK(controller_start(in).outer.v_star == in.nu_L.v);
    const double to = random.angle(), speed = random(0, 1);
    in.current_n = {S(speed * std::cos(to)), S(speed * std::sin(to))};
    const double v_w = double(in.nu_L.v) - speed * std::sin(to - double(in.psi_L));
    ControllerState<S> state = controller_start(in);
    CHECK(state.outer.v_star == testing::approx(S(v_w), 5));
    CHECK(state.slot.v_w == state.outer.v_star);
    const auto out = controller_step(testing::papers_controller<S>(), state, in, S(0));
    CHECK(out.desired.nu_star.v == testing::approx(S(v_w), 5));
  }
}

TEST_CASE_TEMPLATE("the paper's first boat reaches its slot behind the S-curve within 100 s", S,
                   float, double) {
  ClosedLoop world;
  ControllerState<S> state;
  Error<double> e = testing::sail<S>(world, state, 20, testing::s_curve);
  CHECK(std::abs(std::hypot(e.x, e.y, e.psi) - 0.72) < 0.02);  // DESIGN.md, section 2, fact 1
  e = testing::sail<S>(world, state, 100, testing::s_curve);
  CHECK(std::hypot(e.x, e.y, e.psi) < 0.02);
}

TEST_CASE_TEMPLATE("a leader on a circle is followed, and when it stops the boat stops beside it",
                   S, float, double) {
  const auto circle_then_stop = [](double t) {
    return t < 200 ? Tau<double>{2, 0.15} : Tau<double>{0, 0};
  };
  ClosedLoop world;
  ControllerState<S> state;
  const Error<double> sailing = testing::sail<S>(world, state, 200, circle_then_stop);
  CHECK(std::hypot(sailing.x, sailing.y, sailing.psi) < 0.02);
  CHECK(std::abs(world.boat.q[3]) > 0.4);
  const Error<double> stopped = testing::sail<S>(world, state, 300, circle_then_stop);
  CHECK(std::hypot(stopped.x, stopped.y, stopped.psi) < 0.02);
  for (std::size_t i = 3; i < 6; ++i) CHECK(std::abs(world.boat.q[i]) < 1e-3);
}

TEST_CASE_TEMPLATE("from any start, in float and double, the error stays finite and below 60 m", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 23;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 20; ++run) {
    ClosedLoop world;
    world.boat.q = {random(-30, 30), random(-30, 30), random.angle(), random(-2, 2), 0,
                    random(-1, 1)};
    ControllerState<S> state;
    const Error<double> e = testing::sail<S>(world, state, 60, testing::s_curve);
    CHECK(std::isfinite(e.x + e.y + e.psi));
    CHECK(std::hypot(e.x, e.y) < 60);
  }
}

}  // namespace
}  // namespace flotilla::core
