// SPDX-License-Identifier: MIT
#include "core/arbitrary.hpp"
#include "core/formation_error.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::kPi;
using testing::later;
using testing::Random;

TEST_CASE_TEMPLATE(
    "a boat that heads east, one metre north of its slot, is one metre to port of it", S, float,
    double) {
  ControllerInput<S> in;
  in.separation_n = {S(-2), S(-2)};
  in.psi = S(kPi / 2);
  in.psi_L = S(0);
  const Error<S> e = testing::papers_error(in, Vec2<S>{S(-3), S(-2)}).e;
  CHECK(e.x == approx(S(0)));
  CHECK(e.y == approx(S(-1)));
  CHECK(e.psi == approx(S(kPi / 2)));
}

TEST_CASE_TEMPLATE("a boat in its slot with its leader's motion has no error and no error rate", S,
                   float, double) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Vec2<S> d{S(random(-9, 9)), S(random(-9, 9))};
    const FormationError<S> error = testing::papers_error(testing::encounter_in_slot(d, random), d);
    CHECK(error.e.x == S(0));
    CHECK(error.e.y == S(0));
    CHECK(error.e.psi == S(0));
    CHECK(error.e_dot.x == S(0));
    CHECK(error.e_dot.y == S(0));
    CHECK(error.e_dot.psi == S(0));
  }
}

TEST_CASE_TEMPLATE("the error does not change if everything is shifted or turned", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 6;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    const Vec2<S> d{S(random(-9, 9)), S(random(-9, 9))};
    const S turn = S(random.angle());
    const Vec2<S> shift{S(random(-20, 20)), S(random(-20, 20))};
    ControllerInput<S> moved = in;
    moved.separation_n =
        to_north_east(turn, Vec2<S>{in.separation_n.x + shift.x, in.separation_n.y + shift.y});
    moved.psi = in.psi + turn;
    moved.psi_L = in.psi_L + turn;
    const FormationError<S> a = testing::papers_error(in, d);
    const FormationError<S> b =
        testing::papers_error(moved, to_north_east(turn, Vec2<S>{d.x + shift.x, d.y + shift.y}));
    CHECK(b.e.x == approx(a.e.x, 50));
    CHECK(b.e.y == approx(a.e.y, 50));
    CHECK(wrap_pi(b.e.psi - a.e.psi) == approx(S(0), 10));
    CHECK(b.e_dot.x == approx(a.e_dot.x, 100));
    CHECK(b.e_dot.y == approx(a.e_dot.y, 100));
    CHECK(b.e_dot.psi == approx(a.e_dot.psi));
  }
}

TEST_CASE_TEMPLATE("a turn of the boat turns its error the other way", S, float, double) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    const ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    ControllerInput<S> turned = in;
    const S turn = S(random.angle());
    turned.psi = in.psi + turn;
    const Error<S> a = testing::papers_error(in, Vec2<S>{}).e,
                   b = testing::papers_error(turned, Vec2<S>{}).e;
    const Vec2<S> expected = to_body(turn, Vec2<S>{a.x, a.y});
    CHECK(b.x == approx(expected.x, 50));
    CHECK(b.y == approx(expected.y, 50));
  }
}

TEST_CASE("the error's derivative is the slope of the error while both vessels sail on") {
  constexpr std::uint32_t kSeed = 8;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const ControllerInput<double> in = testing::arbitrary_encounter<double>(random);
    const Vec2<double> d{random(-9, 9), random(-9, 9)};
    constexpr double h = 1e-4;
    const Error<double> before = testing::papers_error(later(in, -h), d).e;
    const Error<double> after = testing::papers_error(later(in, h), d).e;
    const Error<double> e_dot = testing::papers_error(in, d).e_dot;
    CHECK(std::abs((after.x - before.x) / (2 * h) - e_dot.x) < 1e-5);
    CHECK(std::abs((after.y - before.y) / (2 * h) - e_dot.y) < 1e-5);
    CHECK(std::abs(wrap_pi(after.psi - before.psi) / (2 * h) - e_dot.psi) < 1e-5);
  }
}

}  // namespace
}  // namespace flotilla::core
