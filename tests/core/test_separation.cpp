// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/sailor.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::kMin;
using testing::leader_at;
using testing::only;
using testing::Random;
using testing::Sailor;
using testing::same_bits;

TEST_CASE_TEMPLATE("the predicted distance is the least distance on the way, as found step by step",
                   S, float, double) {
  constexpr std::uint32_t kSeed = 71;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 300; ++i) {
    const Vec2<double> p = {random(-20, 20), random(-20, 20)};
    const Vec2<double> v = {random(-3, 3), random(-3, 3)}, w = {random(-3, 3), random(-3, 3)};
    const double margin = random(0, 1);
    double least = 1e9;
    for (int k = 0; k <= 4000; ++k) {
      const double t = 0.001 * k;
      least = std::min(least, std::hypot(p.x + t * (v.x - w.x), p.y + t * (v.y - w.y)));
    }
    const OtherVessel<S> other{{S(p.x), S(p.y)}, {S(v.x), S(v.y)}, S(margin), true, false};
    const S found = predicted_distance(S(4), other, Vec2<S>{S(w.x), S(w.y)});
    CHECK(double(found) == doctest::Approx(least - margin).epsilon(1e-3).scale(10));
  }
  const OtherVessel<S> beside{{S(3), S(0)}, {S(1), S(0)}, S(0.5), true, false};
  CHECK(predicted_distance(S(4), beside, Vec2<S>{S(1), S(0)}) == approx(S(2.5)));
}

TEST_CASE("from the speed that a gap allows, a boat stops where the gap ends") {
  Random random(72);
  for (int i = 0; i < 100; ++i) {
    const double a = random(0.1, 40), reaction = random(0.05, 1), gap = random(0.01, 30);
    const double u = stopping_speed(a, reaction, gap);
    CHECK(u * reaction + u * u / (2 * a) == doctest::Approx(gap));
  }
  CHECK(stopping_speed(2.0, 0.4, 0.0) == 0);
  CHECK(stopping_speed(2.0, 0.4, -1.0) == 0);
}

TEST_CASE("a boat takes a course by the smaller turn, stern first if that turn is smaller") {
  Random random(73);
  for (int i = 0; i < 500; ++i) {
    const double psi = random.angle(), course = random.angle(), speed = random(0.01, 3);
    const Vec2<double> w = {speed * std::cos(course), speed * std::sin(course)};
    const Way<double> way = way_to(rotation(psi), w, false);
    const double turn = std::remainder(course - psi, 2 * testing::kPi);
    const bool astern = std::abs(turn) > testing::kPi / 2;
    CHECK((way.u < 0) == astern);
    CHECK(std::abs(std::remainder(psi + way.delta + (astern ? testing::kPi : 0) - course,
                                  2 * testing::kPi)) < 2e-3);
    CHECK(std::abs(way.u) == doctest::Approx(speed * std::pow(std::cos(turn), 2)));
    const Way<double> ahead = way_to(rotation(psi), w, true);
    CHECK(std::abs(std::remainder(ahead.delta - turn, 2 * testing::kPi)) < 2e-3);
    CHECK(ahead.u == (astern ? 0 : way.u));
  }
  const Way<double> nowhere = way_to(rotation(0.3), Vec2<double>{}, false);
  CHECK((nowhere.delta == 0 && nowhere.u == 0));
}

TEST_CASE_TEMPLATE(
    "alone, or with others far away, a boat follows the law unchanged, to the last bit", S, float,
    double) {
  Random random(74);
  auto params = testing::products_law<S>().law;
  params.separation.least = S(kMin);
  for (int i = 0; i < 200; ++i) {
    const auto in = testing::arbitrary_encounter<S>(random);
    auto state = controller_start(in), same = state;
    Traffic<S> traffic;
    const S far = S(random(200, 300));
    traffic.vessels[0] = {{far, S(0)}, {S(random(-1, 1)), S(0)}, S(0), true, false};
    traffic.count = static_cast<std::size_t>(i % 2);
    for (const S dt : {S(0), S(0.01)}) {
      const auto with = controller_step(params, state, in, dt, &traffic);
      const auto without = controller_step(params, same, in, dt);
      CHECK_FALSE(with.separation.yielding);
      CHECK(with.separation.known == (traffic.count == 1));
      CHECK_FALSE(without.separation.known);
      CHECK(same_bits(with.tau.X, without.tau.X));
      CHECK(same_bits(with.tau.N, without.tau.N));
      CHECK(same_bits(state.outer.v_star, same.outer.v_star));
    }
  }
}

TEST_CASE("a boat yields only to a vessel with right of way, but reports one without it as well") {
  Sailor boat({0, 0, 0, 0.5, 0, 0});
  for (const bool has_way : {true, false}) {
    boat.state = {};
    // Crosses its course in two seconds, from starboard.
    boat.sail(leader_at(0, 0), only({{2, 2.5}, {0, -1}, 0, has_way, false}));
    CHECK(boat.out.separation.predicted < 1.4 * kMin);
    CHECK(boat.out.separation.yielding == has_way);
  }
}

TEST_CASE("two boats bow to bow, each with right of way, stop before they are too close") {
  Sailor a({-10, 0, 0, 1.5, 0, 0}), b({10, 0.05, testing::kPi, 1.5, 0, 0});
  double least = 1e9;
  for (int k = 0; k < 3000; ++k) {
    const auto of_b = only(b.seen_by(a, false)), of_a = only(a.seen_by(b, false));
    a.sail(leader_at(15, 0, 0), of_b);
    b.sail(leader_at(-15, 0, 0), of_a);
    least = std::min(least, length(minus(a.place(), b.place())));
  }
  CHECK(least > 1.1 * kMin - 0.05);
  CHECK(least < 1.4 * kMin);
}

TEST_CASE("a stationary vessel on the path is passed, on either side") {
  for (const double aside : {-0.5, 0.0, 0.5}) {
    for (const double psi : {0.0, 1.5, -3.0}) {
      Sailor boat({-10, aside, psi, 0, 0, 0});
      double least = 1e9;
      for (int k = 0; k < 6000; ++k) {
        const Vec2<double> there = minus(Vec2<double>{}, boat.place());
        least = std::min(least, length(there));
        boat.sail(leader_at(-5 + 0.5 * boat.h * k, 0), only({there, {}, 0, true, false}));
      }
      CHECK(least > 1.1 * kMin);
      CHECK(std::hypot(boat.out.error.e.x, boat.out.error.e.y) < 0.05);
    }
  }
}

TEST_CASE("a vessel at an uncertain position is passed at a greater distance") {
  std::vector<double> least;
  for (const double margin : {0.0, 2.0}) {
    Sailor boat({-10, 0.3, 0, 0, 0, 0});
    least.push_back(1e9);
    for (int k = 0; k < 6000; ++k) {
      const Vec2<double> there = minus(Vec2<double>{}, boat.place());
      least.back() = std::min(least.back(), length(there));
      boat.sail(leader_at(-5 + 0.5 * boat.h * k, 0), only({there, {}, margin, true, false}));
    }
  }
  CHECK(least[1] > least[0] + 1.5);
}

TEST_CASE("a boat without limits of speed and yaw rate yields at its least distance per second") {
  const VirtualVelocityParams<double> none{0.2, 0.5, 0, 0}, some{0.2, 0.5, 0.9, 0.4};
  const SeparationParams<double> apart{2};
  const Vec2<double> slot = {0.5, 0}, far = {0, 20}, near = {0, 0.5};
  CHECK(intent_of(none, apart, slot, far).fastest == 2);
  CHECK(intent_of(none, apart, slot, far).turning == 1);
  CHECK(length(intent_of(none, apart, slot, far).straight_n) == doctest::Approx(2));
  CHECK(intent_of(some, apart, slot, far).fastest == 0.9);
  CHECK(intent_of(some, apart, slot, far).turning == 0.4);
  CHECK(intent_of(some, apart, slot, near).straight_n.y == doctest::Approx(0.1));
  // With a limit, the slot's speed does not raise U.
  const Vec2<double> fast = {3, 0};
  CHECK(intent_of(none, apart, fast, far).fastest == doctest::Approx(3.3));
  CHECK(intent_of(some, apart, fast, far).fastest == 0.9);
  CHECK(length(intent_of(some, apart, fast, far).slot_n) == doctest::Approx(0.9));
}

TEST_CASE("a boat looks as far ahead as it needs to turn aside, gather way and make room") {
  const auto horizon = [](double least, double U, double r_m, double a) {
    SeparationParams<double> params;
    params.least = least;
    return horizon_of(params, U, r_m, a);
  };
  CHECK(horizon(1.56, 1.5, 0.8, 20) == 4);  // the paper's hull
  // A WAM-V: 0.4 s to react, 1.4 to gather way, 7.5 for a quarter circle, 5.9 for the room.
  CHECK(horizon(5.88, 1.5, 0.21, 0.54) == doctest::Approx(15.15).epsilon(0.001));
  CHECK(horizon(5.88, 1.5, 0.01, 0.54) == 20);
  CHECK(horizon(5.88, 1.5, 0.21, 1e-9) == 20);
  for (const auto& [U, r_m, a] : {std::array{0.0, 0.8, 1.0}, {1.5, 0.0, 1.0}, {1.5, 0.8, 0.0}}) {
    CHECK(horizon(1.56, U, r_m, a) == 4);
  }
}

TEST_CASE("in Q16, limits next to zero give the longest look ahead without an overflow") {
  SeparationParams<Q16> params;
  params.least = testing::in_scalar<Q16>(5.88);
  const Q16 lsb = Q16::of_raw(1), some = Q16(1);
  (void)take_overflow<Q16>();
  for (const auto& [U, r_m, a] :
       {std::array{lsb, some, some}, {some, lsb, some}, {some, some, lsb}}) {
    CHECK(horizon_of(params, U, r_m, a) == Q16(20));
  }
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE("in Q16, the clearance of a vessel up to 500 m away is that in double") {
  const auto clearance_of = []<class S>(double north, double east, double a) {
    SeparationParams<S> params;
    params.least = testing::in_scalar<S>(5.88);
    Traffic<S> traffic;
    traffic.vessels[0] = {{testing::in_scalar<S>(north), testing::in_scalar<S>(east)},
                          {S(-5), S(2)},
                          S(1),
                          true,
                          true};
    traffic.count = 1;
    const Intent<S> intent{{S(1), S(0)}, {S(1), S(0)}, {S(9), S(0)}, S(2), S(1)};
    const SeparationInput<S> in{traffic, rotation(S(0)), {S(1)}, testing::in_scalar<S>(a),
                                S(1),    intent,         S(0)};
    return testing::number_of(clearance(params, {}, in, Vec2<S>{S(1), S(1)}));
  };
  (void)take_overflow<Q16>();
  for (const double place : {5.0, 100.0, 499.0}) {
    for (const double a : {0.1, 1.0, 50.0}) {
      const double exact = clearance_of.operator()<double>(place, -place, a);
      CHECK(clearance_of.operator()<Q16>(place, -place, a) ==
            doctest::Approx(exact).epsilon(0.001));
    }
  }
  CHECK_FALSE(take_overflow<Q16>());
}

TEST_CASE("to sail abeam, a boat brakes, turns on the spot, and then gathers way") {
  SeparationParams<double> params;
  params.least = kMin;
  const Intent<double> intent{{0.5, 0}, {1, 0}, {2.5, 0}, 1.5, 0.8};
  const Traffic<double> none{};
  const SeparationInput<double> in{none, rotation(0.0), {0.5, 0, 0}, 1, 1, intent, 0.01};
  const auto path = path_to(params, in, Vec2<double>{0, 1}, false);  // abeam, from 0.5 m/s ahead
  double time_s = 0;
  for (const auto& stretch : path) time_s += stretch.time_s;
  CHECK(time_s == doctest::Approx(params.horizon));
  CHECK(path[0].v_n.x == 0.5);
  CHECK(path[1].v_n.x == doctest::Approx(0.25));             // it stops to turn
  CHECK(path[2].v_n.x == doctest::Approx(0).epsilon(1e-9));  // on the spot
  CHECK(path[2].time_s == doctest::Approx(0.4 + M_PI_2 / 0.8));
  CHECK(path[3].v_n.y == doctest::Approx(0.5));
  CHECK(path[4].v_n.y == 1);
}

TEST_CASE("a boat that turns away from a vessel ahead need not yield to it") {
  SeparationParams<double> params;
  params.least = kMin;
  const Intent<double> intent{{0, 0.6}, {0, 0.8}, {0, 1}, 1.5, 0.8};
  const Traffic<double> traffic = only({{4, 0}, {}, 0, true, false});
  for (const double r : {0.0, 0.1, 0.8, -0.8}) {
    SeparationState<double> state{};
    VirtualVelocity<double> desired{};
    desired.nu_star = {0.8, 0, r};
    const auto out = separate(params, state, {traffic, {}, {}, 1, 1, intent, 0.01}, desired);
    CHECK(out.yielding == (std::abs(r) < 0.5));
  }
}

TEST_CASE("a boat that gets nowhere while it goes astern turns about, if it has room") {
  SeparationParams<double> params;
  params.least = kMin;
  const Intent<double> intent{{0.6, 0}, {0.8, 0}, {1, 0}, 1.5, 0.8};
  const OtherVessel<double> ahead{{2, 0}, {0.6, 0}, 0, true, false};
  const auto sails = [&](const Traffic<double>& traffic, double stuck_s, double u) {
    const SeparationInput<double> in{traffic, rotation(3.0), {u, 0, 0}, 1, 1, intent, 0.01};
    SeparationState<double> state{.stuck_s = stuck_s, .yielding = true};
    VirtualVelocity<double> desired;
    for (int step = 0; step < 2; ++step) {
      desired.nu_star = {-0.8, 0, 0};
      CHECK(separate(params, state, in, desired).yielding);
    }
    return std::pair(desired.nu_star, state.bow_first);
  };
  const auto [astern, not_yet] = sails(only(ahead), 1, -0.5);
  CHECK(astern.u < 0);
  CHECK_FALSE(not_yet);
  const auto [turns, about] = sails(only(ahead), 1.995, -0.5);
  CHECK((turns.u == 0 && turns.r == -0.8));
  CHECK(about);
  CHECK_FALSE(sails(only(ahead), 1.995, 0.1).second);
  Traffic<double> ring = only(ahead);
  for (int i = 0; i < 6; ++i) {  // closes
    const double c = std::cos(i), s = std::sin(i);
    ring.vessels[ring.count++] = {{1.2 * c, 1.2 * s}, {-c, -s}, 0, true, false};
  }
  CHECK_FALSE(sails(ring, 1.995, -0.5).second);
}

TEST_CASE("a boat that turns about gathers way from rest, in more time") {
  SeparationParams<double> params;
  params.least = kMin;
  const Intent<double> intent{{0.5, 0}, {1, 0}, {2.5, 0}, 1.5, 0.8};
  const Traffic<double> none{};
  const SeparationInput<double> in{none, rotation(0.0), {-0.5, 0, 0}, 1, 1, intent, 0.01};
  const auto path = path_to(params, in, Vec2<double>{-1, 0}, true);
  double time_s = 0;
  for (const auto& stretch : path) time_s += stretch.time_s;
  CHECK(time_s == doctest::Approx(params.horizon + testing::kPi / 2 / 0.8));
  CHECK(path[1].v_n.x == doctest::Approx(-0.25));
  CHECK(path[2].v_n.x == doctest::Approx(0));
  CHECK(path[2].time_s == doctest::Approx(0.4 + testing::kPi / 0.8));
  CHECK(path[3].v_n.x == doctest::Approx(-0.5));
}

TEST_CASE("a choice that was clear is clear a moment later") {
  constexpr std::uint32_t kSeed = 78;
  INFO("seed ", kSeed);
  Random random(kSeed);
  SeparationParams<double> params;
  params.least = kMin;
  int clear = 0;
  for (int run = 0; run < 2000; ++run) {
    // Already on its course: no turn remains, and its speed is reached.
    const double course = random.angle(), speed = random(0.2, 1.5), dt = 0.1;
    const Vec2<double> w = {speed * std::cos(course), speed * std::sin(course)};
    OtherVessel<double> other{
        {random(-9, 9), random(-9, 9)}, {random(-2, 2), random(-2, 2)}, 0, true};
    const Intent<double> intent{{0.5, 0}, {1, 0}, {2.5, 0}, 1.5, 0.8};
    const auto h = [&](double horizon) {
      SeparationParams<double> shorter = params;
      shorter.horizon = horizon;
      const Traffic<double> traffic = only(other);
      return clearance(shorter, {}, {traffic, rotation(course), {speed, 0, 0}, 10, 10, intent, dt},
                       w);
    };
    const double now = h(params.horizon);
    if (now < 0) continue;
    ++clear;
    other.p_n = {other.p_n.x + dt * (other.v_n.x - w.x), other.p_n.y + dt * (other.v_n.y - w.y)};
    CHECK(h(params.horizon - dt) > now - 1e-9);
  }
  CHECK(clear > 500);
}

TEST_CASE("among several vessels, those without right of way do not affect the chosen course") {
  SeparationParams<double> params;
  params.least = kMin;
  const VirtualVelocityParams<double> limits{0.2, 0.5, 1.5, 0.8};
  const auto intent = intent_of(limits, params, Vec2<double>{0.5, 0}, Vec2<double>{2.5, 0});
  const OtherVessel<double> ahead{{3, 0}, {}, 0, true, false}, aside{{3, 6}, {}, 0, false, false};
  const auto yields_to = [&](const Traffic<double>& traffic) {
    SeparationState<double> state{};
    VirtualVelocity<double> desired{};
    desired.nu_star.u = 1;
    const auto out = separate(params, state, {traffic, {}, {}, 10, 10, intent, 0.01}, desired);
    CHECK((out.yielding && out.known && out.predicted == 0));
    return desired.nu_star;
  };
  const Nu<double> alone = yields_to(only(ahead));
  for (const auto& [first, second] : {std::pair(ahead, aside), std::pair(aside, ahead)}) {
    Traffic<double> both = only(first);
    both.vessels[both.count++] = second;
    const Nu<double> among = yields_to(both);
    CHECK((among.u == alone.u && among.r == alone.r));
  }
}

TEST_CASE("a boat that goes astern stops before the vessel behind it, right of way or not") {
  SeparationParams<double> params;
  params.least = kMin;
  const Intent<double> intent{{0.5, 0}, {1, 0}, {2.5, 0}, 1.5, 0.8};
  for (const double behind_m : {1.4, 1.7, 2.0}) {
    SeparationState<double> state{};
    VirtualVelocity<double> desired{};
    desired.nu_star.u = -1;
    desired.u_star_dot = 1;
    const OtherVessel<double> behind{{-behind_m, 0}, {}, 0, false, false};
    const auto out = separate(params, state, {only(behind), {}, {}, 10, 10, intent, 0.01}, desired);
    CHECK((out.yielding && desired.u_star_dot == 0));
    CHECK((-0.5 < desired.nu_star.u && desired.nu_star.u <= 0));
  }
}

TEST_CASE("a boat gives way on a closed course only where nothing else is clear") {
  constexpr std::uint16_t kEastward = 0x00FE, kAll = 0xFFFF;
  for (const std::uint16_t closed : {std::uint16_t{0}, kEastward, kAll}) {
    Sailor boat({0, 0, 0, 0.5, 0, 0});
    double least = 1e9, east = 0;
    for (int k = 0; k < 4000; ++k) {
      const double t = boat.h * k;
      const Vec2<double> to = minus(Vec2<double>{20 - 0.5 * t, 0}, boat.place());
      auto traffic = only({to, {-0.5, 0}, 0, true, true});
      traffic.closed = closed;
      boat.sail(leader_at(0.5 * t, 0), traffic);
      least = std::min(least, length(to));
      east = std::max(east, boat.place().y);
    }
    CHECK(least > kMin);
    CHECK((east > 0.5) == (closed != kEastward));  // the rules ask for starboard
  }
}

}  // namespace
}  // namespace flotilla::core
