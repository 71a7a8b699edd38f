// SPDX-License-Identifier: MIT
#include "core/arbitrary.hpp"
#include "core/pd_plus.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Random;

/// Rows X and N of M ν̇ + C(ν) ν + D ν, C written as the matrix of the paper's (eq:1b).
template <class S>
Tau<S> wrench_needed(const Vessel<S>& m, const Nu<S>& nu, const Nu<S>& nu_dot) {
  const S c13 = -m.m22 * nu.v, c23 = m.m11 * nu.u;
  const S C_nu_X = c13 * nu.r;
  const S C_nu_N = -c13 * nu.u - c23 * nu.v;
  const S d_u = m.d11 + m.d11q * abs(nu.u), d_r = m.d33 + m.d33u * abs(nu.u);
  return {m.m11 * nu_dot.u + C_nu_X + d_u * nu.u, m.m33 * nu_dot.r + C_nu_N + d_r * nu.r};
}

TEST_CASE_TEMPLATE("a boat in its slot gets the wrench that its leader's own motion takes", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 9;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const Vec2<S> d{S(random(-9, 9)), S(random(-9, 9))};
    const ControllerInput<S> in = testing::encounter_in_slot(d, random);
    const Vessel<S> vessel = testing::with_speed_drag(testing::arbitrary_vessel<S>(random), random);
    VirtualVelocityState<S> state{.v_star = in.nu_L.v};
    const auto desired = testing::papers_velocity(
        VirtualVelocityParams<S>{S(random(0, 2)), S(random(0, 2))}, state, in, d);
    const Tau<S> tau =
        pd_plus(PdPlusParams<S>{S(random(0, 100)), S(random(0, 100))}, vessel, desired, in.nu);
    const Tau<S> needed = wrench_needed(vessel, in.nu_L, in.nu_L_dot);
    CHECK(tau.X == approx(needed.X, 500));
    CHECK(tau.N == approx(needed.N, 500));
  }
}

TEST_CASE_TEMPLATE("a boat that is too fast is braked in proportion, as is one that turns too fast",
                   S, float, double) {
  Random random(10);
  const PdPlusParams<S> gains{S(7), S(3)};
  for (int i = 0; i < 200; ++i) {
    const Vessel<S> vessel = testing::arbitrary_vessel<S>(random);
    const Nu<S> star = testing::arbitrary_nu<S>(random);
    const VirtualVelocity<S> desired{star, S(random(-1, 1)), S(random(-1, 1))};
    const Nu<S> nu = testing::arbitrary_nu<S>(random);
    const Tau<S> with = pd_plus(gains, vessel, desired, nu);
    const Tau<S> without = pd_plus(PdPlusParams<S>{}, vessel, desired, nu);
    CHECK(with.X - without.X == approx(S(-7) * (nu.u - star.u), 500));
    CHECK(with.N - without.N == approx(S(-3) * (nu.r - star.r), 500));
  }
}

TEST_CASE_TEMPLATE("drag that grows with speed is compensated at the boat's own speed", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 12;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 200; ++i) {
    const Vessel<S> plain = testing::arbitrary_vessel<S>(random);
    const Vessel<S> dragged = testing::with_speed_drag(plain, random);
    const VirtualVelocity<S> desired{testing::arbitrary_nu<S>(random), S(0), S(0)};
    const Nu<S> nu = testing::arbitrary_nu<S>(random);
    const Tau<S> less = pd_plus(PdPlusParams<S>{}, plain, desired, nu);
    const Tau<S> more = pd_plus(PdPlusParams<S>{}, dragged, desired, nu);
    const S speed = nu.u < S(0) ? -nu.u : nu.u;
    CHECK(more.X - less.X == approx(dragged.d11q * speed * desired.nu_star.u, 500));
    CHECK(more.N - less.N == approx(dragged.d33u * speed * desired.nu_star.r, 500));
  }
}

TEST_CASE("the wrench of the printed equation, term by term") {
  const Vessel<double> m{2, 3, 5, 7, 11, 13};
  const VirtualVelocity<double> desired{{1.5, 0.25, 0.5}, 0.1, 0.2};
  const Tau<double> tau = pd_plus({17, 19}, m, desired, Nu<double>{1, -0.5, 0.75});
  CHECK(tau.X == doctest::Approx(2 * 0.1 - 3 * -0.5 * 0.5 + 7 * 1.5 - 17 * (1 - 1.5)));
  CHECK(tau.N == doctest::Approx(5 * 0.2 + 3 * -0.5 * 1.5 - 2 * 1 * 0.25 + 13 * 0.5 - 19 * 0.25));
}

}  // namespace
}  // namespace flotilla::core
