// SPDX-License-Identifier: MIT
#include "core/arbitrary.hpp"
#include "core/virtual_velocity.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Random;

template <class S>
VirtualVelocity<S> step(const VirtualVelocityParams<S>& params, VirtualVelocityState<S>& state,
                        const Encounter<S>& in, S h) {
  virtual_sway_forward(testing::papers_vessel<S>(), state, h);
  return virtual_velocity(params, state, in, formation_error(in, Vec2<S>{}));
}

TEST_CASE_TEMPLATE(
    "a boat ahead of its slot wants to be slower, one that points to starboard to port", S, float,
    double) {
  Encounter<S> in;
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

TEST_CASE_TEMPLATE("virtual sway reaches the same value in steps of any lengths: the exact one", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 11;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 50; ++run) {
    const Encounter<S> in = testing::arbitrary_encounter<S>(random);
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
    const Encounter<S> in = testing::arbitrary_encounter<S>(random);
    const S v = step(VirtualVelocityParams<S>{S(0.2), S(0.2)}, state, in, S(0.2)).nu_star.v;
    REQUIRE(std::isfinite(v));
    if (k > 100) greatest = std::max(greatest, std::abs(v));
  }
  CHECK(greatest < S(1.012 / 18.99 * 15 * 3));  // (m11/d22) max |u* r*|
}

/// The encounter h later: both with their velocity, the leader with its acceleration.
Encounter<double> later(Encounter<double> in, double h) {
  const auto way = [h](double psi, const Nu<double>& nu) {
    return to_north_east(psi + 0.5 * h * nu.r, Vec2<double>{h * nu.u, h * nu.v});
  };
  const Vec2<double> own = way(in.psi, in.nu), leader = way(in.psi_L, in.nu_L);
  in.separation_n = {in.separation_n.x + own.x - leader.x, in.separation_n.y + own.y - leader.y};
  in.psi += h * in.nu.r;
  in.psi_L += h * in.nu_L.r;
  in.nu_L = {in.nu_L.u + h * in.nu_L_dot.u, in.nu_L.v + h * in.nu_L_dot.v,
             in.nu_L.r + h * in.nu_L_dot.r};
  return in;
}

TEST_CASE("the derivatives of u* and r* are their slopes while both vessels sail on") {
  constexpr std::uint32_t kSeed = 13;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    Encounter<double> in = testing::arbitrary_encounter<double>(random);
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

}  // namespace
}  // namespace flotilla::core
