// SPDX-License-Identifier: MIT
// Updates of a vessel's track by messages at any times.
#include "core/closed_loop.hpp"
#include "core/estimation/track.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::Hull;
using testing::Random;

template <class S>
bool all_finite(const Motion<S>& m) {
  return std::isfinite(m.moved_n.x) && std::isfinite(m.moved_n.y) && std::isfinite(m.psi) &&
         std::isfinite(m.nu.u) && std::isfinite(m.nu.v) && std::isfinite(m.nu.r) &&
         std::isfinite(m.nu_dot.u) && std::isfinite(m.nu_dot.v) && std::isfinite(m.nu_dot.r);
}

template <class S>
TrackMessage<S> message_of(const Hull& hull, double dt) {
  return {wrap_pi(S(hull.q[2])), {S(hull.q[3]), S(hull.q[4]), S(hull.q[5])}, S(dt)};
}

/// A vessel of constant jerk.
struct Steady {
  double psi_0, nu_0, a, j;
  double nu(double t) const { return nu_0 + a * t + j * t * t / 2; }
  double nu_dot(double t) const { return a + j * t; }
  double psi(double t) const { return psi_0 + nu_0 * t + a * t * t / 2 + j * t * t * t / 6; }
};

TEST_CASE_TEMPLATE("a steady jerk is tracked without lag, whatever the message spacing", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 20;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 50; ++i) {
    const Steady yaw{random.angle(), random(-0.5, 0.5), random(-0.1, 0.1), random(-0.02, 0.02)};
    const Steady surge{0, random(-1, 1), random(-0.2, 0.2), random(-0.05, 0.05)};
    const double longest = random(0.02, 0.9);  // jerk is carried for a second
    TrackState<S> state;
    double t = 0, dt = 0;
    for (; t < 12; dt = random(0.02, longest), t += dt) {
      const Nu<S> nu{S(surge.nu(t)), S(0), S(yaw.nu(t))};
      track_update(TrackParams<S>{}, state, {wrap_pi(S(yaw.psi(t))), nu, S(dt)});
      if (t < 10) continue;
      const Motion<S> m = track_forward(state, S(0.5));
      REQUIRE(std::abs(double(m.nu.u) - surge.nu(t + 0.5)) < 2e-3);
      REQUIRE(std::abs(double(m.nu_dot.u) - surge.nu_dot(t + 0.5)) < 5e-3);
      REQUIRE(std::abs(double(state.nu_ddot.u) - surge.j) < 1e-2);
      REQUIRE(std::abs(double(m.nu.r) - yaw.nu(t + 0.5)) < 2e-3);
      REQUIRE(std::abs(wrap_pi(double(m.psi) - yaw.psi(t + 0.5))) < 2e-3);
    }
  }
}

TEST_CASE_TEMPLATE("a leader's jump in speed decays with the three poles", S, float, double) {
  const TrackParams<S> params;
  for (const double dt : {0.01, 0.05, 0.1, 0.2, 0.5, 0.95}) {
    INFO("a message each ", dt, " s");
    const double T = std::min(double(params.T), 4 * dt), T_j = double(params.T_j);
    const double rho = T / (T + dt), rho_j = T_j / (T_j + dt);
    // The prediction error is Z⁻¹ of z (z − 1)² / ((z − ρ)² (z − ρ_j)).
    const double A = std::pow((1 - rho_j) / (rho - rho_j), 2), B = 1 - A;
    const double C = (1 - rho) * (1 - rho) / (rho - rho_j);
    TrackState<S> state;
    for (int k = 0; k < 3; ++k) track_update(params, state, {S(0), {}, S(dt)});
    for (int k = 0; k < 40; ++k) {
      const double off =
          A * std::pow(rho_j, k) + B * std::pow(rho, k) + C * k * std::pow(rho, k - 1);
      const Nu<S> foreseen = track_forward(state, S(dt)).nu;
      REQUIRE(std::abs(1 - double(foreseen.u) - off) < 1e-4);
      REQUIRE(std::abs(0.4 - double(foreseen.r) - 0.4 * off) < 1e-4);
      track_update(params, state, {S(0), {S(1), S(0), S(0.4)}, S(dt)});
    }
  }
}

TEST_CASE_TEMPLATE("a leader that turns past south keeps its heading", S, float, double) {
  for (const double r : {0.7, -0.7}) {
    TrackState<S> state;
    for (int k = 0; k < 300; ++k) {
      const double psi = 2 + 0.1 * k * r;
      track_update(TrackParams<S>{}, state,
                   {S(wrap_pi(psi)), {S(1), S(0), S(r)}, S(k == 0 ? 0 : 0.1)});
      REQUIRE(std::abs(wrap_pi(double(state.psi) - psi)) < 1e-4);
      REQUIRE(std::abs(state.psi) < S(4));  // an hour of circles does not wear out the scalar
    }
  }
}

TEST_CASE_TEMPLATE("messages with equal or backward times do no harm", S, float, double) {
  for (const double dt : {0.0, -0.1, -1e6}) {
    TrackState<S> state;
    track_update(TrackParams<S>{}, state, {S(0.1), {S(1), S(0), S(0)}, S(0)});
    track_update(TrackParams<S>{}, state, {S(0.1), {S(1.1), S(0), S(0)}, S(0.1)});
    track_update(TrackParams<S>{}, state, {S(0.3), {S(2), S(0), S(0.5)}, S(dt)});
    CHECK(all_finite(track_forward(state, S(0.2))));
    CHECK(state.nu.u == S(2));
    CHECK(state.psi == S(0.3));
    CHECK(state.nu_dot.u == S(0));
    CHECK(state.nu_ddot.u == S(0));
  }
}

TEST_CASE_TEMPLATE("whatever a vessel reports, its track stays within the limits of a vessel", S,
                   float, double) {
  constexpr std::uint32_t kSeed = 21;
  INFO("seed ", kSeed);
  Random random(kSeed);
  const TrackParams<S> params;
  for (int run = 0; run < 100; ++run) {
    TrackState<S> state;
    const double spacing = std::pow(10, random(-3, 0));
    for (int k = 0; k < 300; ++k) {
      const Nu<S> nu{S(random(-20, 20)), S(random(-20, 20)), S(random(-4, 4))};
      const double dt = k % 50 == 49 ? random(-1, 0) : spacing * random(0.5, 2);
      track_update(params, state, {S(random.angle()), nu, S(dt)});
      const double T = std::min(double(params.T), 2 * spacing);
      REQUIRE(std::abs(state.nu.u) <= S(40));
      REQUIRE(std::abs(state.nu_dot.u) <= S(40 / T));  // the range of speeds, over T
      REQUIRE(std::abs(state.nu_dot.r) <= S(8 / T));
      REQUIRE(std::abs(state.nu_ddot.u) <= S(40 / T / double(params.T_j)));
      REQUIRE(params.a_min <= state.a);
      REQUIRE(all_finite(track_forward(state, S(random(0, 10)))));
    }
  }
}

TEST_CASE_TEMPLATE("after a gap the old acceleration, jerk and innovation are discarded", S, float,
                   double) {
  const TrackParams<S> params;
  TrackState<S> state;
  track_update(params, state, {S(0), {S(0), S(0), S(0)}, S(0)});
  track_update(params, state, {S(0), {S(1), S(0), S(0)}, S(0.5)});
  CHECK(state.nu_dot.u > S(1));
  CHECK(state.nu_ddot.u > S(0));
  CHECK(state.a > params.a_min);
  track_update(params, state, {S(0), {S(3), S(0), S(0)}, S(2.5)});
  CHECK(state.nu_dot.u == S(0));
  CHECK(state.nu_ddot.u == S(0));
  CHECK(state.a == params.a_min);
  CHECK(state.nu.u == S(3));
  CHECK(state.dt == S(0));
}

TEST_CASE_TEMPLATE("a vessel reported by another source keeps its acceleration", S, float, double) {
  for (const double silence : {0.1, 1.9, 2.5, 0.0}) {
    TrackState<S> state;
    track_update(TrackParams<S>{}, state, {S(0), {S(0), S(0), S(0)}, S(0)});
    track_update(TrackParams<S>{}, state, {S(0), {S(1), S(0), S(0)}, S(0.5)});
    const TrackState<S> before = state;
    // 0.1 m/s of disagreement is no acceleration.
    track_resume(TrackParams<S>{}, state, {S(1), {S(1.1), S(0), S(2)}, S(silence)});
    const bool goes_on = 0 < silence && silence < 2;
    CHECK(state.nu_dot.u == (goes_on ? before.nu_dot.u : S(0)));
    CHECK(state.nu_ddot.u == (goes_on ? before.nu_ddot.u : S(0)));
    CHECK(state.a == (goes_on ? before.a : TrackParams<S>{}.a_min));
    CHECK(state.nu_dot.r == S(0));
    CHECK(state.dt == (goes_on ? S(silence) : S(0)));
    CHECK(state.nu.u == S(1.1));
    CHECK(state.psi == S(1));
  }
}

TEST_CASE_TEMPLATE("an unpredictable leader gets a larger uncertainty than a steady one", S, float,
                   double) {
  Random random(22);
  TrackState<S> steady, wild;
  for (int k = 0; k < 50; ++k) {
    const S dt = S(k == 0 ? 0 : 0.2);
    track_update(TrackParams<S>{}, steady, {S(0), {S(1), S(0), S(0)}, dt});
    track_update(TrackParams<S>{}, wild, {S(0), {S(random(0.5, 1.5)), S(0), S(0)}, dt});
  }
  CHECK(steady.a == TrackParams<S>{}.a_min);
  CHECK(track_uncertainty(wild, S(1), S(0)) > S(5) * track_uncertainty(steady, S(1), S(0)));
  // An unpredicted turn also displaces a vessel.
  TrackState<S> turning = steady;
  track_update(TrackParams<S>{}, turning, {S(0), {S(1), S(0), S(0.8)}, S(0.2)});
  CHECK(turning.a > S(2) * steady.a);
  for (int k = 0; k < 50; ++k) {
    track_update(TrackParams<S>{}, wild, {S(0), {S(1), S(0), S(0)}, S(0.2)});
  }
  CHECK(wild.a == TrackParams<S>{}.a_min);  // it counts as steady again
}

TEST_CASE_TEMPLATE("on the S-curve the leader's error never exceeds its uncertainty", S, float,
                   double) {
  for (const double dt : {0.05, 0.2, 0.5}) {
    for (const double age : {0.2, 0.5, 1.0, 2.0}) {
      INFO("a message each ", dt, " s, ", age, " s old");
      Hull hull{{0, 0, 1, 0.5, 0, 0}};
      TrackState<S> state;
      for (double t = 0; t < 40; t += dt) {
        track_update(TrackParams<S>{}, state, message_of<S>(hull, t > 0 ? dt : 0));
        Hull there = hull;
        for (double h = 0; h < age - 1e-6; h += 0.01) there.advance(testing::s_curve(t + h), 0.01);
        const Vec2<S> way = track_forward(state, S(age)).moved_n;
        const double off = std::hypot(there.q[0] - hull.q[0] - double(way.x),
                                      there.q[1] - hull.q[1] - double(way.y));
        if (t > 5) REQUIRE(off < double(track_uncertainty(state, S(age), S(0))));
        for (double h = 0; h < dt - 1e-6; h += 0.01) hull.advance(testing::s_curve(t + h), 0.01);
      }
    }
  }
}

}  // namespace
}  // namespace flotilla::core
