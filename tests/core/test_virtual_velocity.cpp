// SPDX-License-Identifier: MIT
#include <algorithm>

#include "core/arbitrary.hpp"
#include "core/virtual_velocity.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::later;
using testing::Random;

template <class S>
VirtualVelocity<S> step(const VirtualVelocityParams<S>& params, VirtualVelocityState<S>& state,
                        const ControllerInput<S>& in, S h) {
  virtual_sway_forward(testing::papers_vessel<S>(), state, h);
  const auto desired = testing::papers_velocity(params, state, in, Vec2<S>{});
  state.u_star_held = desired.nu_star.u;
  state.r_star_held = desired.nu_star.r;
  return desired;
}

TEST_CASE_TEMPLATE(
    "a boat ahead of its slot slows down; one that points to starboard turns to port", S, float,
    double) {
  ControllerInput<S> in;
  in.nu_L = {S(1), S(0), S(0)};
  in.separation_n = {S(2), S(0)};
  in.psi = in.psi_L = S(0);
  VirtualVelocityState<S> state;
  CHECK(step(VirtualVelocityParams<S>{S(0.2), S(0.3)}, state, in, S(0)).nu_star.u ==
        approx(S(0.6)));
  in.separation_n = {};
  in.psi = S(0.5);
  CHECK(step(VirtualVelocityParams<S>{S(0.2), S(0.3)}, state, in, S(0)).nu_star.r ==
        approx(S(-0.3 * std::tanh(0.5))));
}

TEST_CASE_TEMPLATE("virtual sway reaches the exact value, whatever the lengths of the steps", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 11;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 50; ++run) {
    const ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    const S v_0 = S(random(-1, 1));
    VirtualVelocityState<S> state{.v_star = v_0};
    VirtualVelocity<S> last = step(VirtualVelocityParams<S>{S(0.2), S(0.2)}, state, in, S(0));
    CHECK(last.nu_star.v == v_0);  // the first wrench is computed with v*(0)
    double t = 0;
    for (int k = 0; k < 30; ++k) {
      const S h = S(random(0, 0.02));
      t += double(h);
      last = step(VirtualVelocityParams<S>{S(0.2), S(0.2)}, state, in, h);
    }
    const auto m = testing::papers_vessel<double>();
    const double decay = std::exp(-m.d22 / m.m22 * t);
    const double exact = decay * double(v_0) - m.m11 / m.d22 * (1 - decay) *
                                                   double(last.nu_star.u) * double(last.nu_star.r);
    CHECK(last.nu_star.v == approx(S(exact), 2));
  }
}

TEST_CASE_TEMPLATE("virtual sway stays bounded over an hour of long steps", S, float, double) {
  Random random(12);
  VirtualVelocityState<S> state{.v_star = S(20)};
  S greatest = S(0);
  for (int k = 0; k < 20'000; ++k) {
    const ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    const S v = step(VirtualVelocityParams<S>{S(0.2), S(0.2)}, state, in, S(0.2)).nu_star.v;
    REQUIRE(std::isfinite(v));
    if (k > 100) greatest = std::max(greatest, std::abs(v));
  }
  CHECK(greatest < S(1.012 / 18.99 * 15 * 3));  // (m11/d22) max |u* r*|
}

TEST_CASE("the derivatives of u* and r* are their slopes while both vessels sail on") {
  constexpr std::uint32_t kSeed = 13;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    ControllerInput<double> in = testing::arbitrary_encounter<double>(random);
    in.psi_L = in.psi + random(-3, 3);  // r* jumps where the heading error wraps
    const VirtualVelocityParams<double> params{random(0, 2), random(0, 2)};
    const auto star = [&](double h) {
      VirtualVelocityState<double> state;
      return step(params, state, later(in, h), 0.0);
    };
    constexpr double h = 1e-4;
    CHECK(std::abs((star(h).nu_star.u - star(-h).nu_star.u) / (2 * h) - star(0).u_star_dot) < 1e-5);
    CHECK(std::abs((star(h).nu_star.r - star(-h).nu_star.r) / (2 * h) - star(0).r_star_dot) < 1e-5);
  }
}

TEST_CASE("r* follows a line of sight that turns, and its derivative is the slope of that") {
  constexpr std::uint32_t kSeed = 14;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    ControllerInput<double> in = testing::arbitrary_encounter<double>(random);
    const LineOfSight<double> sight{random(-1, 1), random(-1, 1), random(-1, 1)};
    in.psi_L = in.psi + random(-2, 2);
    const VirtualVelocityParams<double> params{random(0, 2), random(0, 2)};
    const auto star = [&](double h) {
      const auto then = later(in, h);
      const Slot<double> slot = slot_beside(then, {});
      VirtualVelocityState<double> state;
      return virtual_velocity(params, state, slot, formation_error(then, slot),
                              {sight.theta + h * sight.theta_dot + h * h / 2 * sight.theta_ddot,
                               sight.theta_dot + h * sight.theta_ddot, sight.theta_ddot});
    };
    constexpr double h = 1e-4;
    CHECK(std::abs((star(h).nu_star.r - star(-h).nu_star.r) / (2 * h) - star(0).r_star_dot) < 1e-5);
    CHECK(star(0).nu_star.u ==
          in.nu_L.u - params.k_x * formation_error(in, slot_beside(in, {})).e.x);
    // A bow on the line of sight turns with it.
    in.psi = in.psi_L + sight.theta;
    CHECK(star(0).nu_star.r == approx(in.nu_L.r + sight.theta_dot));
  }
}

TEST_CASE_TEMPLATE("the request never exceeds the limits, whatever the slot does", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 15;
  INFO("seed ", kSeed);
  Random random(kSeed);
  int limited = 0;
  for (int i = 0; i < 2000; ++i) {
    const ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    const VirtualVelocityParams<S> any{S(random(0, 2)), S(random(0, 2))};
    VirtualVelocityParams<S> params = any;
    params.u_max = S(random(0.1, 4));
    params.r_max = S(random(0.1, 3));
    const VirtualVelocityState<S> state;
    const auto kept = testing::papers_velocity(params, state, in, {});
    const auto free = testing::papers_velocity(any, state, in, {});
    const S u_most = params.u_max, r_most = S(0.97) * params.r_max;
    REQUIRE(std::abs(kept.nu_star.u) <= u_most);
    REQUIRE(std::abs(kept.nu_star.r) <= r_most);
    const bool too_fast = std::abs(free.nu_star.u) > u_most;
    CHECK((kept.limits & kSpeedLimit) == (too_fast ? kSpeedLimit : 0));
    CHECK(kept.nu_star.u == (too_fast ? std::copysign(u_most, free.nu_star.u) : free.nu_star.u));
    CHECK(kept.u_star_dot == (too_fast ? S(0) : free.u_star_dot));
    const bool spins = std::abs(free.nu_star.r) > r_most;
    CHECK((kept.limits & kYawRateLimit) == (spins ? kYawRateLimit : 0));
    CHECK(kept.nu_star.r == (spins ? std::copysign(r_most, free.nu_star.r) : free.nu_star.r));
    CHECK(kept.r_star_dot == (spins ? S(0) : free.r_star_dot));
    limited += too_fast && spins;
  }
  CHECK(limited > 100);
}

TEST_CASE_TEMPLATE("r* rises from a quarter of its limit to the limit in 0.25 s, and falls at once",
                   S, float, double) {
  const VirtualVelocityParams<S> params{.r_max = S(0.8)};
  VirtualVelocityState<S> state;
  const auto limited = [&](S wish, S h) {
    VirtualVelocity<S> desired;
    desired.nu_star.r = wish;
    desired.r_star_dot = S(1);
    limit_growth(params, state, h, desired);
    state.r_star_held = desired.nu_star.r;
    return std::pair(desired.nu_star.r, desired.r_star_dot);
  };
  CHECK(limited(S(0.776), S(0)) == std::pair(S(0.776), S(1)));  // the first step
  CHECK(limited(S(0.1), S(0.01)) == std::pair(S(0.1), S(1)));
  CHECK(limited(S(0.776), S(0.01)).first == approx(S(0.2)));
  CHECK(limited(S(-0.776), S(0.01)) == std::pair(S(-0.2), S(0)));
  for (int step = 1; step <= 24; ++step) {
    const auto [rate, slope] = limited(S(-0.776), S(0.01));
    CHECK(rate == approx(S(-0.2 - 0.024 * step)));
    CHECK((step == 24 || slope == S(0)));
  }
  CHECK(limited(S(0.05), S(0.01)) == std::pair(S(0.05), S(1)));
  CHECK(limited(S(-0.19), S(0.01)) == std::pair(S(-0.19), S(1)));
}

TEST_CASE_TEMPLATE("without LAW_R_MAX r* may jump", S, float, double) {
  VirtualVelocity<S> desired;
  desired.nu_star.r = S(5);
  limit_growth({}, VirtualVelocityState<S>{.r_star_held = S(-5)}, S(0.01), desired);
  CHECK(desired.nu_star.r == S(5));
}

TEST_CASE_TEMPLATE("a slot that needs more than the limits is reported with its needs", S, float,
                   double) {
  Random random(16);
  int fast = 0, spins = 0, neither = 0;
  for (int i = 0; i < 500; ++i) {
    const Slot<S> slot = slot_beside(testing::encounter_in_slot(Vec2<S>{}, random), Vec2<S>{});
    const S u_max = S(random(0.5, 3)), r_max = S(random(0.1, 3));
    const S speed = std::hypot(slot.nu.u, slot.nu.v), rate = std::abs(slot.nu.r);
    const TooFast<S> told = too_fast(VirtualVelocityParams<S>{S(1), S(1), u_max, r_max}, slot);
    CHECK(told.u == approx(speed > u_max ? speed : S(0)));
    CHECK(told.r == (rate > r_max ? rate : S(0)));
    fast += told.u > S(0), spins += told.r > S(0), neither += told.u + told.r == S(0);
    const TooFast<S> any = too_fast(VirtualVelocityParams<S>{S(1), S(1)}, slot);
    CHECK((any.u == S(0) && any.r == S(0)));
  }
  CHECK(std::min({fast, spins, neither}) > 50);
}

TEST_CASE_TEMPLATE("a limit of zero means no limit", S, float, double) {
  ControllerInput<S> in;
  in.separation_n = {S(-1000), S(0)};
  in.nu_L = {S(20), S(0), S(4)};
  VirtualVelocityState<S> state;
  const auto desired =
      testing::papers_velocity(VirtualVelocityParams<S>{S(2), S(2), S(0), S(0)}, state, in, {});
  CHECK(desired.limits == 0);
  CHECK(desired.nu_star.u == S(2020));
  CHECK(desired.nu_star.r == S(4));
}

}  // namespace
}  // namespace flotilla::core
