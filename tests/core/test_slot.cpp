// SPDX-License-Identifier: MIT
// The slot at one instant and at rest; test_slot_voyage.cpp: behind a leader that sails.
#include "core/arbitrary.hpp"
#include "core/slot.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Random;

template <class S>
SlotParams<S> slot_at(double ahead, double to_starboard, bool turns, bool steers) {
  SlotParams<S> params;
  params.d = {S(ahead), S(to_starboard)};
  params.turns = turns;
  params.steers = steers;
  return params;
}

template <class S>
bool all_finite(const Slot<S>& slot) {
  return std::isfinite(slot.d_n.x + slot.d_n.y + slot.psi + slot.nu.u + slot.nu.v + slot.nu.r) &&
         std::isfinite(slot.nu_dot.u + slot.nu_dot.v + slot.nu_dot.r);
}

/// The slot after `seconds` with constant input.
template <class S>
Slot<S> settled(const SlotParams<S>& params, const Vessel<S>& vessel, const ControllerInput<S>& in,
                double seconds = 60) {
  SlotState<S> state = slot_start(in);
  Slot<S> slot;
  for (double t = 0; t < seconds; t += 0.01)
    slot = slot_forward(params, vessel, state, in, S(0.01));
  return slot;
}

template <class S>
void check_same(const Slot<S>& slot, const Vec2<S>& d_n, const ControllerInput<S>& in) {
  CHECK(slot.d_n.x == d_n.x);
  CHECK(slot.d_n.y == d_n.y);
  CHECK(slot.psi == in.psi_L);
  CHECK(slot.nu.u == in.nu_L.u);
  CHECK(slot.nu.v == in.nu_L.v);
  CHECK(slot.nu.r == in.nu_L.r);
  CHECK(slot.nu_dot.u == in.nu_L_dot.u);
  CHECK(slot.nu_dot.v == in.nu_L_dot.v);
  CHECK(slot.nu_dot.r == in.nu_L_dot.r);
}

TEST_CASE_TEMPLATE("the paper's slot lies beside its leader and has exactly the leader's motion", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 71;
  INFO("seed ", kSeed);
  Random random(kSeed);
  SlotState<S> state, steered_state;
  for (int i = 0; i < 500; ++i) {
    ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    in.current_n = {S(random(-2, 2)), S(random(-2, 2))};
    const auto params = slot_at<S>(random(-9, 9), random(-9, 9), false, false);
    check_same(slot_beside(in, params.d), params.d, in);
    auto steered = params;
    steered.steers = true;
    const Slot<S> slot = slot_forward(params, testing::papers_vessel<S>(), state, in, S(0.01));
    check_same(slot, params.d, in);
    const Slot<S> same =
        slot_forward(steered, testing::papers_vessel<S>(), steered_state, in, S(0.01));
    CHECK(slot.pace == same.pace);  // only the course differs
  }
}

TEST_CASE_TEMPLATE("two metres astern of a leader that heads east is two metres west of it", S,
                   float, double) {
  ControllerInput<S> in;
  in.psi_L = S(testing::kPi / 2);
  in.nu_L = {S(1), S(0), S(0)};
  const auto params = slot_at<S>(-2, 0, true, true);
  SlotState<S> state = slot_start(in);
  const Slot<S> slot = slot_forward(params, testing::papers_vessel<S>(), state, in, S(0));
  CHECK(slot.d_n.x == approx(S(0)));
  CHECK(slot.d_n.y == approx(S(-2)));
  CHECK(slot.nu.u == approx(S(1)));
}

TEST_CASE_TEMPLATE("a slot starts with the sway of its leader through the water", S, float,
                   double) {
  Random random(72);
  auto in = testing::arbitrary_encounter<S>(random);
  CHECK(slot_start(in).v_w == in.nu_L.v);
  in.current_n = {S(0.3), S(-0.2)};
  const double psi = double(in.psi_L);
  const SlotState<S> state = slot_start(in);
  CHECK(state.v_w == approx(S(double(in.nu_L.v) + 0.3 * std::sin(psi) + 0.2 * std::cos(psi))));
  CHECK(state.n.rate == S(0));
  CHECK(state.q_s.rate == S(0));
  CHECK_FALSE(state.started);
}

/// On a circle of the leader the boat's sway is −m11 u r / d22: it heads inward of its course.
TEST_CASE_TEMPLATE(
    "around a circling leader the slot heads as a boat does that sails the slot's own circle", S,
    float, double) {
  constexpr std::uint32_t kSeed = 73;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 60; ++i) {
    Vessel<double> m = testing::arbitrary_vessel<double>(random);
    m.m11 = random(0.1, 0.5) * m.m22;
    const double u_L = random(0.5, 2), r = random(-0.3, 0.3);
    m.d22 = m.m11 * random(1.5, 20);
    const double ahead = random(-1, 1), aside = random(-1, 1);
    ControllerInput<double> in;
    in.psi_L = random.angle();
    in.nu_L = {u_L, -m.m11 * u_L * r / m.d22, r};
    const double w_x = u_L - r * aside, w_y = in.nu_L.v + r * ahead;
    const double heading = in.psi_L + std::atan2(w_y, w_x) + std::atan(m.m11 * r / m.d22);

    ControllerInput<S> seen;
    seen.psi_L = S(in.psi_L);
    seen.nu_L = {S(in.nu_L.u), S(in.nu_L.v), S(in.nu_L.r)};
    const Vessel<S> vessel{S(m.m11), S(m.m22), S(m.m33), S(m.d11), S(m.d22), S(m.d33)};
    const Slot<S> slot = settled(slot_at<S>(ahead, aside, true, true), vessel, seen);
    INFO("w ", w_x, " ", w_y, ", m11/m22 ", m.m11 / m.m22, ", d22/m11 ", m.d22 / m.m11);
    // ε reduces the turn a little, and v_w is in the leader's axes, not in the slot's.
    CHECK(std::abs(double(slot.psi) - heading) < 0.0025 / (w_x * w_x) + 0.03);
    CHECK(double(slot.pace) == doctest::Approx(w_x).epsilon(1e-3));
    CHECK(double(slot.nu.r) == doctest::Approx(r).epsilon(1e-3));
    CHECK(std::hypot(double(slot.nu.u), double(slot.nu.v)) ==
          doctest::Approx(std::hypot(w_x, w_y)).epsilon(1e-5));
  }
}

TEST_CASE_TEMPLATE("in a cross current the slot heads along its own motion through the water", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 74;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 60; ++i) {
    ControllerInput<S> in;
    in.psi_L = S(random.angle());
    in.nu_L = {S(random(0.4, 2)), S(0), S(0)};  // over ground: a leader that no water carries
    const Vec2<double> c = to_north_east(random.angle(), Vec2<double>{random(0, 0.3), 0});
    in.current_n = {S(c.x), S(c.y)};
    const Slot<S> slot = settled(slot_at<S>(random(-9, 9), random(-9, 9), i % 2 == 0, true),
                                 testing::papers_vessel<S>(), in, 10);
    const auto over_ground = to_north_east(double(in.psi_L), Vec2<double>{double(in.nu_L.u), 0});
    const Vec2<double> through = {over_ground.x - c.x, over_ground.y - c.y};
    const double q_x = to_body(double(in.psi_L), through).x;
    const double off = wrap_pi(double(slot.psi) - std::atan2(through.y, through.x));
    CHECK(std::abs(off) < 0.0025 / (q_x * q_x) + 1e-4);  // ε again
    const auto goes =
        to_north_east(double(slot.psi), Vec2<double>{double(slot.nu.u), double(slot.nu.v)});
    CHECK(std::abs(goes.x - over_ground.x) < 1e-5);
    CHECK(std::abs(goes.y - over_ground.y) < 1e-5);
    CHECK(std::abs(slot.nu.r) < S(1e-4));
  }
}

TEST_CASE_TEMPLATE("a steady change is smoothed without lag, a step by two equal poles", S, float,
                   double) {
  for (const double h : {0.005, 0.02, 0.1}) {
    const double rho = 1 / (1 + 2 * h);
    Smooth<S> ramp, leap;
    ramp.value = S(0.3);
    smooth(smoothing(S(2), S(h)), ramp, S(0.3));
    CHECK(ramp.value == S(0.3));
    CHECK(ramp.rate == S(0));
    for (double t = h; t < 20; t += h) smooth(smoothing(S(2), S(h)), ramp, S(0.3 + 0.1 * t));
    const S before = ramp.value;
    smooth(smoothing(S(2), S(h)), ramp, ramp.value + S(0.1 * h));
    CHECK(double(ramp.rate) == doctest::Approx(0.1).epsilon(1e-3));
    CHECK(double(ramp.value - before) == doctest::Approx(0.1 * h).epsilon(1e-3));
    smooth(smoothing(S(2), S(h)), leap, S(0));
    for (int k = 0; k < 100; ++k) {  // 1 − n after k + 1 steps: (1 + …) of a double pole
      const double left = rho * rho * std::pow(rho, k) * (1 + k - k / rho);
      smooth(smoothing(S(2), S(h)), leap, S(1));
      REQUIRE(std::abs(1 - double(leap.value) - left) < 1e-4);
    }
  }
}

TEST_CASE_TEMPLATE("no leader, current, hull or time step takes the slot out of range", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 75;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 100; ++run) {
    const Vessel<S> vessel = testing::arbitrary_vessel(random, S(random(0.1, 0.5)));
    const double size = std::pow(10, random(0, 3));
    const auto params = slot_at<S>(random(-size, size), random(-size, size), run % 2 == 0, true);
    SlotState<S> state;
    for (int k = 0; k < 300; ++k) {
      ControllerInput<S> in;
      in.psi_L = S(random.angle());
      in.nu_L = {S(random(-20, 20)), S(random(-20, 20)), S(random(-4, 4))};
      if (k % 7 == 0) in.nu_L = {};
      in.nu_L_dot = {S(random(-20, 20)), S(random(-20, 20)), S(random(-20, 20))};
      in.current_n = {S(random(-2, 2)), S(random(-2, 2))};
      const S h = S(k % 5 == 0 ? 0 : random(0, 0.2));
      REQUIRE(all_finite(slot_forward(params, vessel, state, in, h)));
      REQUIRE(std::isfinite(state.v_w + state.n.value + state.n.rate));
    }
  }
}

}  // namespace
}  // namespace flotilla::core
