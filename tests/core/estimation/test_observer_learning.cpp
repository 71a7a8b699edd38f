// SPDX-License-Identifier: MIT
// The estimate of unknown forces from the boat's fixes; test_observer_current.cpp: of the current.
#include "core/watched_boat.hpp"

namespace flotilla::core {
namespace {

using testing::Random;
using testing::Sighting;
using testing::Watched;

TEST_CASE_TEMPLATE("a constant force and moment are found, later with a smaller bandwidth", S,
                   float, double) {
  for (const double omega : {0.5, 2.0, 4.0}) {
    for (const double spacing : {0.01, 0.05, 0.2}) {
      INFO("bandwidth ", omega, " rad/s, a fix each ", spacing, " s");
      Watched<S> boat;
      boat.params.omega = S(omega);
      boat.params.omega_c = S(0);
      boat.spacing = spacing;
      boat.extra = {1.5, -0.4};
      Tau<double> delay{};
      while (boat.t < 20 / omega + 5) {
        boat.sail(testing::s_curve(boat.t), testing::s_curve(boat.t));
        delay.X += spacing * (1 - boat.unknown().X / boat.extra.X);
        delay.N += spacing * (1 - boat.unknown().N / boat.extra.N);
      }
      CHECK(boat.unknown().X == doctest::Approx(1.5).epsilon(0.01));
      CHECK(boat.unknown().N == doctest::Approx(-0.4).epsilon(0.01));
      // Summed over all fixes, ν − ν̂ = φ (1 − k) (ν − ν̂) + ψ (b − b̂) and b = Σ g k (ν − ν̂).
      const double k = spacing / (spacing + 0.1), g = omega / (1 + omega * spacing);
      const auto expected = [&](double rate) {
        const double phi = std::exp(-rate * spacing), psi = (1 - phi) / rate;
        return spacing * (1 - phi * (1 - k)) / (psi * g * k);
      };
      CHECK(delay.X == doctest::Approx(expected(3.436 / 1.012)).epsilon(0.05));
      CHECK(delay.N == doctest::Approx(expected(0.864 / 0.354)).epsilon(0.05));
      if (spacing < 0.1) CHECK(std::abs(delay.X * omega - 1) < 0.75);  // about 1/ω
    }
  }
}

TEST_CASE_TEMPLATE("thrust that weak propellers cannot give is not taken for an external force", S,
                   float, double) {
  const AllocationParams<double> propellers{0.25, 20, 20};
  const auto asked = [](double t) {
    return Tau<double>{80 * std::sin(0.4 * t), 15 * std::sin(0.9 * t)};
  };
  Watched<S> given, deceived;
  double wound_up = 0;
  while (given.t < 30) {
    const double t = given.t;
    const Tau<double> gives = allocate(propellers, asked(t)).given;
    given.sail(gives, gives);
    deceived.sail(gives, asked(t));
    REQUIRE(std::abs(given.unknown().X) < 0.8);
    REQUIRE(std::abs(given.unknown().N) < 0.8);
    wound_up = std::max(wound_up, std::abs(deceived.unknown().X));
  }
  CHECK(wound_up > 19.9);  // the limit; it is reached with the wrench before allocation
}

TEST_CASE_TEMPLATE("no fix, however absurd, takes the estimated force or current beyond its limit",
                   S, float, double) {
  constexpr std::uint32_t kSeed = 42;
  INFO("seed ", kSeed);
  Random random(kSeed);
  const Vessel<S> m = testing::papers_vessel<S>();
  const auto params = testing::products_law<S>().observer;
  const auto within = [](S x, S most) { return std::abs(x) <= most * S(1.000001); };
  Observer<S> state;
  for (int k = 0; k < 100'000; ++k) {
    const double size = std::pow(10, random(0, 6));
    const auto absurd = [&] { return S(random(-size, size)); };
    observer_forward(m, state, Tau<S>{absurd(), absurd()}, S(random(-0.1, 0.1)));
    const Nu<S> nu{absurd(), absurd(), absurd()};
    const Fix<S> fix{{absurd(), absurd()}, absurd(), nu, S(random(-0.1, 0.1)), S(random(-1, 3))};
    observer_correct(params, m, state, fix);
    REQUIRE(within(state.b.u, params.b_max.u));
    REQUIRE(within(state.b.v, params.b_max.v));
    REQUIRE(within(state.b.r, params.b_max.r));
    REQUIRE(within(state.c_n.x, params.c_max));
    REQUIRE(within(state.c_n.y, params.c_max));
    const Motion<S>& now = state.motion;
    REQUIRE(std::isfinite(now.moved_n.x + now.moved_n.y + now.psi + now.nu_dot.u + now.nu_dot.r));
  }
  for (int k = 0; k < 100; ++k) observer_forward(m, state, {}, S(1));
  CHECK(std::abs(state.motion.nu.u) <= S(50));
}

TEST_CASE_TEMPLATE("a boat that estimates no unknown forces takes its fixes as they are", S, float,
                   double) {
  Watched<S> boat;
  boat.params.omega = S(0);
  boat.noise = {0.1, 0.1, 0.2, 0.1};
  boat.hull.current = {0.1, 0.2};
  boat.extra = {3, 1};
  while (boat.t < 20) {
    const Sighting said = boat.fix();
    const Tau<double> tau = testing::s_curve(boat.t);
    boat.take(said);
    REQUIRE(boat.state.motion.nu.u == S(said.nu.u));
    REQUIRE(boat.state.motion.nu.v == S(said.nu.v));
    REQUIRE(boat.state.motion.nu.r == S(said.nu.r));
    REQUIRE(boat.state.motion.psi == wrap_pi(S(said.psi)));
    REQUIRE(boat.state.motion.moved_n.x == S(0));
    REQUIRE(boat.unknown().X == 0);
    REQUIRE(boat.unknown().N == 0);
    boat.go(tau, tau);
  }
}

TEST_CASE_TEMPLATE("the noise of many fixes is averaged", S, float, double) {
  Watched<S> boat;
  boat.noise = {0.02, 0.009, 0.02, 0.0035};
  boat.params.omega_c = S(0);
  std::array<double, 4> raw{}, kept{};
  int n = 0;
  for (; boat.t < 200; ++n) {
    const Sighting said = boat.fix(), truth = testing::sighting_of(boat.hull);
    const Tau<double> tau = testing::s_curve(boat.t);
    boat.take(said);
    const Motion<S>& m = boat.state.motion;
    const auto add = [](double& sum, double off) { sum += off * off; };
    add(raw[0], said.place.x - truth.place.x);
    add(raw[1], said.psi - truth.psi);
    add(raw[2], said.nu.u - truth.nu.u);
    add(raw[3], said.nu.r - truth.nu.r);
    add(kept[0], boat.anchor.x + double(m.moved_n.x) - truth.place.x);
    add(kept[1], wrap_pi(double(m.psi) - truth.psi));
    add(kept[2], double(m.nu.u) - truth.nu.u);
    add(kept[3], double(m.nu.r) - truth.nu.r);
    boat.go(tau, tau);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    INFO("component ", i, ", raw ", raw[i], ", kept ", kept[i]);
    CHECK(kept[i] < 0.5 * raw[i]);
  }
  CHECK(std::sqrt(raw[0] / n) == doctest::Approx(0.02).epsilon(0.1));
}

}  // namespace
}  // namespace flotilla::core
