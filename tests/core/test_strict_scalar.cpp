// SPDX-License-Identifier: MIT
// All of core with a scalar that can do nothing but what core's contract promises.
#include "core/closed_loop.hpp"
#include "core/dead_reckoning.hpp"
#include "core/manual.hpp"
#include "core/strict_scalar.hpp"
#include "core/supervisor.hpp"
#include "core/thrust_curve.hpp"
#include "core/track.hpp"

namespace flotilla::core {

using testing::Strict;

template struct Vec2<Strict>;
template struct Nu<Strict>;
template struct Tau<Strict>;
template struct Error<Strict>;
template struct Vessel<Strict>;
template struct Encounter<Strict>;
template struct FormationError<Strict>;
template struct VirtualVelocityParams<Strict>;
template struct VirtualVelocityState<Strict>;
template struct VirtualVelocity<Strict>;
template struct PdPlusParams<Strict>;
template struct AllocationParams<Strict>;
template struct Thrust<Strict>;
template struct Allocation<Strict>;
template struct ThrustCurveParams<Strict>;
template struct TrackParams<Strict>;
template struct TrackState<Strict>;
template struct Motion<Strict>;
template struct ControllerParams<Strict>;
template struct ControllerState<Strict>;
template struct ControllerOutput<Strict>;

template Strict clamp(Strict, Strict, Strict);
template Strict smaller(Strict, Strict);
template Strict wrap_pi(Strict);
template Vec2<Strict> to_north_east(Strict, const Vec2<Strict>&);
template Vec2<Strict> to_body(Strict, const Vec2<Strict>&);
template FormationError<Strict> formation_error(const Encounter<Strict>&, const Vec2<Strict>&);
template VirtualVelocity<Strict> virtual_velocity(const VirtualVelocityParams<Strict>&,
                                                  VirtualVelocityState<Strict>&,
                                                  const Encounter<Strict>&,
                                                  const FormationError<Strict>&);
template void virtual_sway_forward(const Vessel<Strict>&, VirtualVelocityState<Strict>&, Strict);
template Tau<Strict> pd_plus(const PdPlusParams<Strict>&, const Vessel<Strict>&,
                             const VirtualVelocity<Strict>&, const Nu<Strict>&);
template Tau<Strict> wrench_of(const AllocationParams<Strict>&, const Thrust<Strict>&);
template Allocation<Strict> allocate(const AllocationParams<Strict>&, const Tau<Strict>&);
template Tau<Strict> stick_wrench(const AllocationParams<Strict>&, Strict, Strict);
template Thrust<Strict> test_thrust(const AllocationParams<Strict>&, Propeller, Strict);
template Strict thrust_from_command(const ThrustCurveParams<Strict>&, Strict);
template Strict command_from_thrust(const ThrustCurveParams<Strict>&, Strict);
template Strict limit_slew(Strict, Strict, Strict, Strict);
template void track_update(const TrackParams<Strict>&, TrackState<Strict>&,
                           const TrackMessage<Strict>&);
template void track_resume(const TrackParams<Strict>&, TrackState<Strict>&,
                           const TrackMessage<Strict>&);
template Motion<Strict> reckon_step(const Vessel<Strict>&, const Reckoning<Strict>&,
                                    const Tau<Strict>&, Strict);
template void reckon_forward(const Vessel<Strict>&, Reckoning<Strict>&, const Tau<Strict>&, Strict);
template void reckon_from(const ReckoningParams<Strict>&, const Vessel<Strict>&, Reckoning<Strict>&,
                          const Fix<Strict>&, const Tau<Strict>&);
template Motion<Strict> moment_before(Motion<Strict>, Strict);
template Motion<Strict> track_forward(const TrackState<Strict>&, Strict);
template ControllerState<Strict> controller_start(const Encounter<Strict>&);
template ControllerOutput<Strict> controller_step(const ControllerParams<Strict>&,
                                                  ControllerState<Strict>&,
                                                  const Encounter<Strict>&, Strict);

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
      CHECK(strict.wanted.nu_star.v.value() == out.wanted.nu_star.v);
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
  const auto number = [](Strict x) { return x.value(); };
  const Error<double> e = testing::sail<Strict>(world, state, 100, testing::s_curve, number);
  CHECK(std::hypot(e.x, e.y, e.psi) < 0.02);
  MESSAGE("values from ", Strict::seen.least, " to ", Strict::seen.greatest);
  CHECK_FALSE(Strict::seen.saw_nan);
  CHECK(Strict::seen.magnitude <= 100);  // half of it is the propellers' 50 N, twice
  CHECK(Strict::seen.magnitude > 10);
}

}  // namespace
}  // namespace flotilla::core
