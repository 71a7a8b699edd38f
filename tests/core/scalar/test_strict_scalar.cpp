// SPDX-License-Identifier: MIT
// All of core with a scalar that can do nothing but what core's contract promises.
#include "core/coast.hpp"
#include "core/estimation/observer.hpp"
#include "core/estimation/plausibility.hpp"
#include "core/estimation/thrust_response.hpp"
#include "core/estimation/track.hpp"
#include "core/fence.hpp"
#include "core/future.hpp"
#include "core/manual.hpp"
#include "core/piloted_boat.hpp"
#include "core/reference.hpp"
#include "core/route.hpp"
#include "core/station.hpp"
#include "core/strict_scalar.hpp"
#include "core/supervisor.hpp"
#include "core/thrust_curve.hpp"

namespace flotilla::core {

using testing::Strict;

#define SCALAR Strict
#include "core/every_template.inc"
#undef SCALAR

namespace {

static_assert(!std::is_convertible_v<double, Strict> && !std::is_convertible_v<int, Strict>);
static_assert(!std::is_convertible_v<Strict, double> && !std::is_constructible_v<double, Strict>);
static_assert(!std::is_constructible_v<Strict, float> && !std::is_constructible_v<Strict, bool>);

TEST_CASE("one control step in strict scalars is that in doubles, to the last bit") {
  constexpr std::uint32_t kSeed = 24;
  INFO("seed ", kSeed);
  testing::Random random(kSeed), same(kSeed);
  for (int i = 0; i < 200; ++i) {
    const auto strict_in = testing::arbitrary_encounter<Strict>(random);
    const auto in = testing::arbitrary_encounter<double>(same);
    auto strict_state = controller_start(strict_in);
    auto state = controller_start(in);
    for (const double dt : {0.0, 0.01}) {
      const auto strict = controller_step(testing::papers_controller<Strict>(), strict_state,
                                          strict_in, Strict(dt));
      const auto out = controller_step(testing::papers_controller<double>(), state, in, dt);
      CHECK(strict.error.e.x.value() == out.error.e.x);
      CHECK(strict.desired.nu_star.v.value() == out.desired.nu_star.v);
      CHECK(strict.tau.X.value() == out.tau.X);
      CHECK(strict.tau.N.value() == out.tau.N);
      CHECK(strict.allocation.thrust.port.value() == out.allocation.thrust.port);
      CHECK(strict.allocation.thrust.stbd.value() == out.allocation.thrust.stbd);
    }
  }
}

TEST_CASE("sailing the paper's S-curve, no number of the law is greater than 100") {
  testing::ClosedLoop world;
  ControllerState<Strict> state;
  Strict::seen = {};
  const Error<double> e = testing::sail<Strict>(world, state, 100, testing::s_curve);
  CHECK(std::hypot(e.x, e.y, e.psi) < 0.02);
  MESSAGE("values from ", Strict::seen.least, " to ", Strict::seen.greatest);
  CHECK_FALSE(Strict::seen.saw_nan);
  CHECK(Strict::seen.magnitude <= 100);  // half of it is the propellers' 50 N, twice
  CHECK(Strict::seen.magnitude > 10);
}

TEST_CASE("no number of the product's law, with observer and current, is greater than 100") {
  const auto leader = testing::voyage(testing::s_curve, 0.01, 60);
  testing::PilotedBoat<Strict> boat;
  boat.hull = {{1.46, 0.45, 1.33, 0, 0, 0}, {0, 0.1}};
  testing::PilotedBoat<double> same{.hull = boat.hull};
  const auto strict_params = testing::products_law<Strict>();
  const auto params = testing::products_law<double>();
  Strict::seen = {};
  Error<Strict> e;
  REQUIRE(leader.size() >= 6000);
  for (const auto& seen : leader) {
    e = boat.tick(strict_params, seen, 0.01).error.e;
    same.tick(params, seen, 0.01);
    REQUIRE(boat.hull.q == same.hull.q);  // to the last bit
  }
  CHECK(std::hypot(e.x.value(), e.y.value()) < 0.05);
  MESSAGE("values from ", Strict::seen.least, " to ", Strict::seen.greatest);
  CHECK_FALSE(Strict::seen.saw_nan);
  CHECK(Strict::seen.magnitude <= 100);
  CHECK(Strict::seen.magnitude > 10);
}

}  // namespace
}  // namespace flotilla::core
