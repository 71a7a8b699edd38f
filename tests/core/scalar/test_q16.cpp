// SPDX-License-Identifier: MIT
// All of core in fixed point: it compiles, sails as in double, and reports overflow.
#include "core/coast.hpp"
#include "core/estimation/plausibility.hpp"
#include "core/estimation/thrust_response.hpp"
#include "core/estimation/track.hpp"
#include "core/fence.hpp"
#include "core/future.hpp"
#include "core/manual.hpp"
#include "core/piloted_boat.hpp"
#include "core/reference.hpp"
#include "core/route.hpp"
#include "core/scalar/overflow.hpp"
#include "core/station.hpp"
#include "core/supervisor.hpp"
#include "core/thrust_curve.hpp"

namespace flotilla::core {

#define SCALAR Q16
#include "core/every_template.inc"
#undef SCALAR

namespace {

using testing::in_scalar;
using testing::number_of;

bool within_propellers(const Thrust<Q16>& thrust, Q16 most) {
  const auto fits = [most](Q16 x) { return -most <= x && x <= most; };
  return fits(thrust.port) && fits(thrust.stbd);
}

TEST_CASE(
    "sailing the paper's S-curve in Q16, the boat is within a millimetre of that in doubles") {
  testing::ClosedLoop fixed, same;
  ControllerState<Q16> fixed_state;
  ControllerState<double> state;
  take_overflow<Q16>();
  for (int second = 1; second <= 100; ++second) {
    testing::sail(fixed, fixed_state, second, testing::s_curve);
    testing::sail(same, state, second, testing::s_curve);
    const auto &a = fixed.boat.q, &b = same.boat.q;
    CHECK(std::hypot(a[0] - b[0], a[1] - b[1]) < 0.001);
  }
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE("a boat with its observer, in a current, sails in Q16 as it does in doubles") {
  const auto leader = testing::voyage(testing::s_curve, 0.01, 60);
  testing::PilotedBoat<Q16> boat;
  boat.hull = {{1.46, 0.45, 1.33, 0, 0, 0}, {0, 0.1}};
  testing::PilotedBoat<double> same{.hull = boat.hull};
  const auto fixed_params = testing::products_law<Q16>();
  const auto params = testing::products_law<double>();
  take_overflow<Q16>();
  double worst = 0;
  for (const auto& seen : leader) {
    boat.tick(fixed_params, seen, 0.01);
    same.tick(params, seen, 0.01);
    const auto &a = boat.hull.q, &b = same.hull.q;
    worst = std::max(worst, std::hypot(a[0] - b[0], a[1] - b[1]));
  }
  MESSAGE("farthest from the boat in doubles: ", worst, " m");
  CHECK(worst < 0.005);
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE(
    "one step from anywhere within a kilometre overflows nothing and gives thrust as in doubles") {
  constexpr std::uint32_t kSeed = 816;
  INFO("seed ", kSeed);
  testing::Random random(kSeed), same(kSeed);
  const auto fixed_params = testing::products_law<Q16>().law;
  const auto params = testing::products_law<double>().law;
  take_overflow<Q16>();
  for (int i = 0; i < 1000; ++i) {
    auto fixed_in = testing::arbitrary_encounter<Q16>(random);
    auto in = testing::arbitrary_encounter<double>(same);
    const double scale = i % 2 == 0 ? 1 : 30;
    in.separation_n = {scale * in.separation_n.x, scale * in.separation_n.y};
    fixed_in.separation_n = {in_scalar<Q16>(in.separation_n.x), in_scalar<Q16>(in.separation_n.y)};
    auto fixed_state = controller_start(fixed_in);
    auto state = controller_start(in);
    const auto fixed = controller_step(fixed_params, fixed_state, fixed_in, Q16(0.01));
    const auto out = controller_step(params, state, in, 0.01);
    CHECK(within_propellers(fixed.allocation.thrust, Q16(20)));
    CHECK(std::abs(number_of(fixed.tau.X) - out.tau.X) < 0.01 * (1 + std::abs(out.tau.X)));
    CHECK(std::abs(number_of(fixed.tau.N) - out.tau.N) < 0.01 * (1 + std::abs(out.tau.N)));
  }
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE(
    "at 40 km and 400 m/s the law reports an overflow, and thrust saturates without wrapping") {
  ControllerParams<Q16> params = testing::papers_controller<Q16>();
  ControllerInput<Q16> in;
  in.separation_n = {Q16(-40000), Q16(0)};
  in.nu_L.u = Q16(400);
  auto state = controller_start(in);
  take_overflow<Q16>();
  const auto out = controller_step(params, state, in, Q16(0.01));
  CHECK(take_overflow<Q16>());
  CHECK(out.allocation.thrust.port == Q16(50));  // all ahead: saturated, of the right sign
  CHECK(out.allocation.thrust.stbd == Q16(50));
}

TEST_CASE("vessels hundreds of metres away overflow nothing") {
  constexpr std::uint32_t kSeed = 817;
  INFO("seed ", kSeed);
  testing::Random random(kSeed);
  auto params = testing::products_law<Q16>().law;
  params.separation.least = Q16(2);
  ControllerState<Q16> state;
  take_overflow<Q16>();
  for (int i = 0; i < 1000; ++i) {
    const double far = i % 2 == 0 ? 10 : 4000;
    Traffic<Q16> traffic;
    traffic.count = 3;
    for (std::size_t k = 0; k < traffic.count; ++k) {
      traffic.vessels[k] = {{in_scalar<Q16>(random(-far, far)), in_scalar<Q16>(random(-far, far))},
                            {in_scalar<Q16>(random(-5, 5)), in_scalar<Q16>(random(-5, 5))},
                            in_scalar<Q16>(random(0, 5)),
                            k != 0,
                            k == 2};
    }
    const auto out = controller_step(params, state, testing::arbitrary_encounter<Q16>(random),
                                     Q16(0.01), &traffic);
    REQUIRE(within_propellers(out.allocation.thrust, Q16(20)));
  }
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE("full sticks on the strongest boat overflow nothing and request the same as in doubles") {
  const AllocationParams<Q16> strongest{Q16(5), Q16(500), Q16(500)};
  take_overflow<Q16>();
  for (const int s : {-10, -1, 1, 10}) {
    const Tau<Q16> tau = stick_wrench(strongest, Q16(s), Q16(-s));
    CHECK(tau.X == Q16(s < 0 ? -1000 : 1000));
    CHECK(tau.N == Q16(s < 0 ? 5000 : -5000));
    const auto thrust = test_thrust(strongest, Propeller::kPort, Q16(s));
    CHECK(std::abs(number_of(thrust.port) - (s < 0 ? -100 : 100)) < 0.002);  // 500 N of ½ LSB
  }
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE("a propeller's command goes from end to end at the slew rate, never beyond") {
  const Q16 full = Q16(8191);
  take_overflow<Q16>();
  for (const int rate : {1, 5, 20, 150, 1000}) {
    for (const Q16 end : {full, -full}) {
      Q16 command = -end;
      for (int k = 1; command != end; ++k) {
        REQUIRE(k <= 202);
        command = limit_slew(command, end, Q16(rate), Q16(0.01), full);
        REQUIRE(abs(command) <= full);
        const double gone = std::min(2.0, k * rate * 0.01) * 8191;
        CHECK(std::abs(std::abs(number_of(command) + number_of(end)) - gone) < 0.01 * gone);
      }
    }
  }
  CHECK_FALSE(take_overflow<Q16>());
}

}  // namespace
}  // namespace flotilla::core
