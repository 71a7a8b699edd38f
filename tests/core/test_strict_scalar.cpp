// SPDX-License-Identifier: MIT
// All of core with a scalar that can do nothing but what core's contract promises.
#include "core/answer.hpp"
#include "core/coast.hpp"
#include "core/jump.hpp"
#include "core/manual.hpp"
#include "core/observer.hpp"
#include "core/piloted_boat.hpp"
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
template struct SlotParams<Strict>;
template struct Smooth<Strict>;
template struct SlotState<Strict>;
template struct Slot<Strict>;
template struct SlotVelocity<Strict>;
template struct LineOfSightParams<Strict>;
template struct LineOfSight<Strict>;
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
template struct TrackMessage<Strict>;
template struct Motion<Strict>;
template struct ObserverParams<Strict>;
template struct Given<Strict>;
template struct Observer<Strict>;
template struct Fix<Strict>;
template struct Commands<Strict>;
template struct CoastState<Strict>;
template struct OtherVessel<Strict>;
template struct Traffic<Strict>;
template struct SeparationParams<Strict>;
template struct SeparationState<Strict>;
template struct Separation<Strict>;
template struct Intent<Strict>;
template struct Way<Strict>;
template struct AnswerParams<Strict>;
template struct AnswerAxis<Strict>;
template struct AnswerState<Strict>;
template struct AnswerInput<Strict>;
template struct JumpLimits<Strict>;
template struct Leg<Strict>;
template struct Surprise<Strict>;
template struct ControllerParams<Strict>;
template struct ControllerState<Strict>;
template struct ControllerOutput<Strict>;

template Strict clamp(Strict, Strict, Strict);
template Strict smaller(Strict, Strict);
template Strict larger(Strict, Strict);
template Strict wrap_pi(Strict);
template Vec2<Strict> to_north_east(Strict, const Vec2<Strict>&);
template Vec2<Strict> to_body(Strict, const Vec2<Strict>&);
template Slot<Strict> slot_beside(const Encounter<Strict>&, const Vec2<Strict>&);
template SlotVelocity<Strict> slot_velocity(const SlotParams<Strict>&, const Encounter<Strict>&);
template void smooth(Strict, Smooth<Strict>&, Strict, Strict);
template Slot<Strict> slot_forward(const SlotParams<Strict>&, const Vessel<Strict>&,
                                   SlotState<Strict>&, const Encounter<Strict>&, Strict);
template Strict sway_beside(const Encounter<Strict>&);
template SlotState<Strict> slot_start(const Encounter<Strict>&);
template FormationError<Strict> formation_error(const Encounter<Strict>&, const Slot<Strict>&);
template Strict agreed(Strict, Strict);
template Strict steering_speed(const Vessel<Strict>&, const Slot<Strict>&, const Tau<Strict>&,
                               Strict);
template LineOfSight<Strict> line_of_sight(const LineOfSightParams<Strict>&, const Nu<Strict>&,
                                           const Slot<Strict>&, const FormationError<Strict>&,
                                           Strict);
template Strict wanted_surge(const VirtualVelocityParams<Strict>&, const Slot<Strict>&,
                             const FormationError<Strict>&);
template VirtualVelocity<Strict> virtual_velocity(const VirtualVelocityParams<Strict>&,
                                                  VirtualVelocityState<Strict>&,
                                                  const Slot<Strict>&,
                                                  const FormationError<Strict>&,
                                                  const LineOfSight<Strict>&);
template VirtualVelocity<Strict> through_water(VirtualVelocity<Strict>, const Vec2<Strict>&,
                                               Strict);
template bool keep_within(Strict, Strict, Strict&, Strict&);
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
template Motion<Strict> observer_step(const Vessel<Strict>&, const Observer<Strict>&,
                                      const Tau<Strict>&, Strict);
template Nu<Strict> bounded(const Nu<Strict>&, const Nu<Strict>&);
template void observer_carry(const Vessel<Strict>&, Observer<Strict>&, const Tau<Strict>&, Strict);
template void observer_replay(const Vessel<Strict>&, Observer<Strict>&, Strict);
template void observer_forward(const Vessel<Strict>&, Observer<Strict>&, const Tau<Strict>&,
                               Strict);
template void observer_learn(const ObserverParams<Strict>&, const Vessel<Strict>&,
                             Observer<Strict>&, const Nu<Strict>&, Strict);
template void observer_correct(const ObserverParams<Strict>&, const Vessel<Strict>&,
                               Observer<Strict>&, const Fix<Strict>&);
template Tau<Strict> unknown_wrench(const Vessel<Strict>&, const Observer<Strict>&);
template Motion<Strict> moment_before(Motion<Strict>, Strict);
template Nu<Strict> plus(const Nu<Strict>&, Strict, const Nu<Strict>&);
template Motion<Strict> track_forward(const TrackState<Strict>&, Strict);
template Strict track_uncertainty(const TrackState<Strict>&, Strict, Strict);
template CoastState<Strict> coast_start(const Motion<Strict>&);
template void coast_forward(Strict, CoastState<Strict>&, Strict);
template Commands<Strict> limited(const Commands<Strict>&, Strict);
template Strict predicted_distance(Strict, const OtherVessel<Strict>&, const Vec2<Strict>&);
template Strict stopping_speed(Strict, Strict, Strict);
template Way<Strict> way_to(Strict, const Vec2<Strict>&);
template Intent<Strict> intent_of(const VirtualVelocityParams<Strict>&, Strict, const Vec2<Strict>&,
                                  const Vec2<Strict>&);
template Separation<Strict> separate(const SeparationParams<Strict>&, Strict,
                                     SeparationState<Strict>&, const Traffic<Strict>&, Strict,
                                     const Intent<Strict>&, VirtualVelocity<Strict>&);
template void answer_axis(const AnswerParams<Strict>&, AnswerAxis<Strict>&,
                          const AnswerInput<Strict>&, Strict);
template void answer_forward(const AnswerParams<Strict>&, AnswerState<Strict>&, const Nu<Strict>&,
                             const Nu<Strict>&, const Tau<Strict>&, Strict);
template bool fails(const AnswerAxis<Strict>&, Strict, Strict);
template bool answers(const AnswerParams<Strict>&, const AnswerState<Strict>&);
template bool hardly_moves(const JumpLimits<Strict>&, const Leg<Strict>&);
template Strict beyond(Strict, Strict);
template Strict beyond(const Vec2<Strict>&, const Vec2<Strict>&);
template Surprise<Strict> surprise_of(const JumpLimits<Strict>&, const Leg<Strict>&, Strict);
template ControllerState<Strict> controller_start(const Encounter<Strict>&);
template ControllerOutput<Strict> controller_step(const ControllerParams<Strict>&,
                                                  ControllerState<Strict>&,
                                                  const Encounter<Strict>&, Strict,
                                                  const Traffic<Strict>*);

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
  const Error<double> e = testing::sail<Strict>(world, state, 100, testing::s_curve);
  CHECK(std::hypot(e.x, e.y, e.psi) < 0.02);
  MESSAGE("values from ", Strict::seen.least, " to ", Strict::seen.greatest);
  CHECK_FALSE(Strict::seen.saw_nan);
  CHECK(Strict::seen.magnitude <= 100);  // half of it is the propellers' 50 N, twice
  CHECK(Strict::seen.magnitude > 10);
}

TEST_CASE("no more is any number of the product's law, with its observer and in a current") {
  const auto leader = testing::voyage(testing::s_curve, 0.01, 60);
  testing::PilotedBoat<Strict> boat;
  boat.hull = {{1.46, 0.45, 1.33, 0, 0, 0}, {0, 0.1}};
  testing::PilotedBoat<double> same{.hull = boat.hull};
  const auto strict_params = testing::products_law<Strict>();
  const auto params = testing::products_law<double>();
  Strict::seen = {};
  Error<Strict> e;
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
