// SPDX-License-Identifier: MIT
// Boats that are off a slot at rest: they turn to it, sail there, and turn back.
#include <algorithm>
#include <vector>

#include "core/piloted_boat.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::core {
namespace {

using testing::PilotedBoat;
using testing::Random;
using testing::Sighting;

constexpr double kH = 0.02;

/// A boat's time behind a leader at rest that heads north; `late`: in the last third.
struct Stay {
  double off = 0, late_off = 0;
  double psi = 0;
  double late_swing = 0;  ///< difference of the greatest and the least heading
  int late_starts = 0;    ///< of an approach
  bool started = false;
};

template <class S>
Stay lie(PilotedBoat<S> boat, double seconds, const testing::ProductParams<S>& params) {
  Stay out;
  double least = 1e9, greatest = -1e9;
  bool on = false;
  const int n = static_cast<int>(seconds / kH);
  for (int k = 0; k < n; ++k) {
    boat.tick(params, Sighting{}, kH);
    out.off = std::hypot(boat.hull.q[0], boat.hull.q[1]);
    out.psi = boat.hull.q[2];
    const bool starts = boat.state.approach.on && !on;
    on = boat.state.approach.on;
    out.started = out.started || starts;
    if (3 * k < 2 * n) continue;
    out.late_off = std::max(out.late_off, out.off);
    least = std::min(least, out.psi), greatest = std::max(greatest, out.psi);
    out.late_starts += starts;
  }
  out.late_swing = greatest - least;
  return out;
}

template <class S>
PilotedBoat<S> at(double north, double east, double psi, const Vec2<double>& current = {}) {
  PilotedBoat<S> boat;
  boat.hull = {{north, east, psi, 0, 0, 0}, current};
  return boat;
}

TEST_CASE_TEMPLATE("abeam of a leader at rest a boat turns, sails to its slot, and turns back", S,
                   float, double) {
  const auto params = testing::products_law<S>();
  for (const double abeam : {-30.0, -10.0, -2.0, 2.0, 10.0, 30.0}) {
    INFO(abeam, " m abeam");
    const Stay stay = lie(at<S>(0, abeam, 0), 120, params);
    CHECK(stay.late_off < 0.25);
    CHECK(std::abs(wrap_pi(stay.psi)) < 0.01);
    CHECK(stay.late_swing < 0.01);
  }
}

TEST_CASE("from any start around a leader at rest boats reach their slots and stay quietly") {
  constexpr std::uint32_t kSeed = 111;
  INFO("seed ", kSeed);
  Random random(kSeed);
  const auto params = testing::products_law<float>();
  for (int run = 0; run < 200; ++run) {
    const double north = random(-20, 20), east = random(-20, 20), psi = random.angle();
    INFO("from ", north, ", ", east, ", heading ", psi);
    const Stay stay = lie(at<float>(north, east, psi), 150, params);
    CHECK(stay.late_off < 1.5);  // a boat that starts so near may stay there
    if (stay.started) CHECK(stay.late_off < 0.5);
    CHECK(std::abs(wrap_pi(stay.psi)) < 0.01);
    CHECK(stay.late_swing < 0.01);
  }
}

TEST_CASE_TEMPLATE(
    "a boat near its slot, or with LAW_XT_DIST or LAW_KX at 0, does not start an approach", S,
    float, double) {
  auto params = testing::products_law<S>();
  for (const double abeam : {0.3, 1.0, 1.4})
    CHECK_FALSE(lie(at<S>(0, abeam, 0), 20, params).started);
  CHECK(lie(at<S>(0, 1.6, 0), 1, params).started);
  params.law.sight.Delta = S(0);
  CHECK_FALSE(lie(at<S>(0, 10, 0), 20, params).started);
  params.law.sight.Delta = S(1);
  params.law.outer.k_x = S(0);
  CHECK_FALSE(lie(at<S>(0, 10, 0), 20, params).started);
}

TEST_CASE_TEMPLATE("a boat far abeam or ahead of a slot that makes way sails across to it", S,
                   float, double) {
  const auto params = testing::products_law<S>();
  const auto leader = testing::voyage([](double) { return Tau<double>{2, 0}; }, kH, 90);
  for (const Vec2<double>& from :
       {Vec2<double>{0, 30}, Vec2<double>{15, 20}, Vec2<double>{20, 0}}) {
    INFO("from ", from.x, ", ", from.y);
    auto boat = at<S>(from.x, from.y, 0);
    int starts = 0;
    double came_s = 0;
    for (std::size_t k = 0; k < leader.size(); ++k) {
      const bool was = boat.state.approach.on;
      boat.tick(params, leader[k], kH);
      if (boat.state.approach.on && !was) ++starts;
      if (static_cast<double>(k) * kH > 5) REQUIRE_FALSE(boat.state.approach.astern);
      const double off =
          std::hypot(boat.hull.q[0] - leader[k].place.x, boat.hull.q[1] - leader[k].place.y);
      if (off > 0.2) came_s = static_cast<double>(k) * kH;
    }
    MESSAGE("there after ", came_s, " s");
    CHECK(starts <= 2);  // the leader begins at rest
    CHECK(came_s < 40);
  }
}

TEST_CASE("astern of a leader that makes way there is no approach, however far the slot") {
  const auto params = testing::products_law<double>();
  const auto leader = testing::voyage([](double) { return Tau<double>{2, 0}; }, kH, 90);
  auto boat = at<double>(-30, 3, 0);
  for (std::size_t k = 0; k < leader.size(); ++k) {
    boat.tick(params, leader[k], kH);
    if (static_cast<double>(k) * kH > 5) REQUIRE_FALSE(boat.state.approach.on);
  }
}

TEST_CASE_TEMPLATE(
    "in a current from anywhere, a boat beside a leader at rest points its bow into it", S, float,
    double) {
  const auto params = testing::products_law<S>();
  for (const Vec2<double>& current :
       {Vec2<double>{0, 0.1}, Vec2<double>{0, -0.2}, Vec2<double>{0.1, 0.1}, Vec2<double>{0.3, 0},
        Vec2<double>{0.8, 0}, Vec2<double>{0.2, 0.1}, Vec2<double>{-0.3, 0.02}}) {
    for (const double abeam : {0.0, 10.0}) {
      INFO("current ", current.x, ", ", current.y, ", from ", abeam, " m abeam");
      const Stay stay = lie(at<S>(0, abeam, 0, current), 240, params);
      CHECK(stay.late_off < 0.1);
      CHECK(stay.late_swing < 0.1);
      CHECK(stay.late_starts == 0);
      const double across = current.x * std::sin(stay.psi) - current.y * std::cos(stay.psi);
      CHECK(std::abs(across) < 0.02);
      // From exactly astern 0.3 m/s push with 1 N; these propellers' neutral band may hide 2 N.
      const bool hidden = current.x == 0.3 && abeam == 0.0;
      CHECK((current.x * std::cos(stay.psi) + current.y * std::sin(stay.psi) < 0) != hidden);
    }
  }
}

TEST_CASE("the bow's angle changes as its rate says while the boat sails to a slot at rest") {
  constexpr std::uint32_t kSeed = 112;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const ApproachParams<double> params{0.2, 1, 0.15, i % 2 == 0 ? 0 : 1.5};
    ControllerInput<double> in = testing::arbitrary_encounter<double>(random);
    in.nu_L = in.nu_L_dot = {};
    const auto angle = [&](double h, bool astern) {
      const auto then = testing::later(in, h);
      const Slot<double> slot = slot_beside(then, {});
      ApproachState<double> state{true, astern};
      const auto way = slot_way(params, slot, formation_error(then, slot), then.nu, {});
      return sight_of_way(params, state, way, 0.0, 0.0, true);
    };
    constexpr double h = 1e-4;
    const auto now = angle(0, false);
    const double slope = wrap_pi(angle(h, false).theta - angle(-h, false).theta) / (2 * h);
    const double distance = std::hypot(in.separation_n.x, in.separation_n.y);
    const double nearer = std::min(1.0, distance);  // within Δ, theta_dot is a share of the slope
    CHECK(std::abs(nearer * slope - now.theta_dot) < 1e-3 * (1 + std::abs(slope)));
    // Bow first or stern first, the boat lies along the same line.
    CHECK(std::abs(std::sin(angle(0, true).theta - now.theta)) < 1e-9);
    CHECK(std::abs(now.theta) < testing::kPi / 2 + 0.41);
  }
}

TEST_CASE("only the part of a force beyond the neutral band counts as a push") {
  const Vessel<double> vessel(16.5, 35, 8.7, 1.5, 180, 0.6, 8.1);
  const ApproachParams<double> params{0.2, 1, 0.15, 0, 2};
  const auto push = [&](double X) {
    ApproachState<double> state;
    ControllerInput<double> in;
    in.unknown.X = X;
    for (int i = 0; i < 20'000; ++i) push_forward(params, vessel, state, in, Slot<double>{}, 0.01);
    CHECK(state.push_n.y == doctest::Approx(0));
    return state.push_n.x;
  };
  CHECK(push(1.9) == doctest::Approx(0));
  CHECK(push(-1.9) == doctest::Approx(0));
  const double speed = push(-5);  // at which the drag is 3 N
  CHECK(speed == doctest::Approx(-0.522).epsilon(0.001));
  CHECK((1.5 + 8.1 * -speed) * -speed == doctest::Approx(3));
  CHECK(push(5) == doctest::Approx(-speed));
  CHECK(push(500) == doctest::Approx(1));
}

TEST_CASE("near its slot a boat turns its bow into the current, and keeps it so within metres") {
  const ApproachParams<double> params{0.2, 1, 0.15, 0};
  ApproachState<double> state{true, true};
  const auto theta = [&](double closing) {
    SlotWay<double> way;
    way.q = {-1, 0};
    way.off = {-0.1, 0};
    way.drift = 0.1;
    way.closing = closing;
    return std::abs(sight_of_way(params, state, way, 0.0, 0.0, true).theta);
  };
  CHECK(theta(0.06) == doctest::Approx(0));  // stern first still
  CHECK(theta(0.04) == doctest::Approx(testing::kPi));
  CHECK(theta(0.49) == doctest::Approx(testing::kPi));
  CHECK(theta(0.51) == doctest::Approx(0));
  CHECK(theta(0.06) == doctest::Approx(0));
}

TEST_CASE("the choice between bow first and stern first does not change for a small gain") {
  const ApproachParams<double> params{0.2, 1, 0.15, 0};
  ApproachState<double> state;
  const auto bearing = [&](double angle) {
    SlotWay<double> way;
    way.q = {std::cos(angle), std::sin(angle)};
    return sight_of_way(params, state, way, 0.0, 0.0, true).theta;
  };
  CHECK(bearing(1.5) == doctest::Approx(1.5));
  CHECK(bearing(1.9) == doctest::Approx(1.9));
  CHECK_FALSE(state.astern);
  CHECK(bearing(2.0) == doctest::Approx(2.0 - testing::kPi));
  CHECK(state.astern);
  CHECK(bearing(1.5) == doctest::Approx(1.5 - testing::kPi));
  CHECK(bearing(1.1) == doctest::Approx(1.1));
  CHECK_FALSE(state.astern);
}

TEST_CASE_TEMPLATE("without a demand the bow stays as it is, also beside a leader that turns", S,
                   float, double) {
  const ApproachParams<S> params{S(0.2), S(1), S(0.15), S(0)};
  ApproachState<S> state{true, true};
  const auto sight = sight_of_way(params, state, SlotWay<S>{}, S(0.7), S(0.3), true);
  CHECK(sight.theta == S(0.7));
  CHECK(sight.theta_dot == S(-0.3));
  CHECK(state.astern);
}

TEST_CASE("a kilometre off, at the largest gain, in Q16, nothing overflows") {
  auto params = testing::products_law<Q16>().law;
  auto doubles = testing::products_law<double>().law;
  params.outer.k_x = Q16(2);
  doubles.outer.k_x = 2;
  Random random(113);
  take_overflow<Q16>();
  for (int i = 0; i < 500; ++i) {
    ControllerInput<double> in;
    in.separation_n = {random(-999, 999), random(-999, 999)};
    in.psi = random.angle();
    ControllerInput<Q16> fixed;
    fixed.separation_n = {testing::in_scalar<Q16>(in.separation_n.x),
                          testing::in_scalar<Q16>(in.separation_n.y)};
    fixed.psi = testing::in_scalar<Q16>(in.psi);
    auto state = controller_start(in);
    auto fixed_state = controller_start(fixed);
    const auto out = controller_step(doubles, state, in, 0.01);
    const auto said = controller_step(params, fixed_state, fixed, Q16(0.01));
    REQUIRE(state.approach.on);
    REQUIRE(fixed_state.approach.on);
    const double theta = testing::number_of(said.sight.theta);
    if (state.approach.astern == fixed_state.approach.astern) {
      CHECK(std::abs(theta - out.sight.theta) < 1e-3);
    }
  }
  CHECK_FALSE(take_overflow<Q16>());
}

}  // namespace
}  // namespace flotilla::core
