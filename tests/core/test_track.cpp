// SPDX-License-Identifier: MIT
#include "core/arbitrary.hpp"
#include "core/track.hpp"

namespace flotilla::core {
namespace {

/// A message that arrives the moment it was true.
template <class S>
void update(const TrackParams<S>& params, TrackState<S>& state, S psi, const Nu<S>& nu, S dt) {
  track_update(params, state, TrackMessage<S>{psi, nu, dt, S(0)});
}

using testing::approx;
using testing::Random;

template <class S>
bool all_finite(const Motion<S>& m) {
  return std::isfinite(m.moved_n.x) && std::isfinite(m.moved_n.y) && std::isfinite(m.psi) &&
         std::isfinite(m.nu.u) && std::isfinite(m.nu.v) && std::isfinite(m.nu.r) &&
         std::isfinite(m.nu_dot.u) && std::isfinite(m.nu_dot.v) && std::isfinite(m.nu_dot.r);
}

TEST_CASE_TEMPLATE("a leader at constant velocity is carried forward along its straight line", S,
                   float, double) {
  TrackState<S> state;
  for (int k = 0; k < 5; ++k) {
    update(TrackParams<S>{}, state, S(0.7), Nu<S>{S(1.5), S(-0.2), S(0)}, S(k > 0 ? 0.1 : 0));
  }
  const Motion<S> m = track_forward(state, S(2));
  const Vec2<S> way = to_north_east(S(0.7), Vec2<S>{S(3), S(-0.4)});
  CHECK(m.moved_n.x == approx(way.x));
  CHECK(m.moved_n.y == approx(way.y));
  CHECK(m.psi == approx(S(0.7)));
  CHECK(m.nu.u == approx(S(1.5)));
  CHECK(m.nu_dot.u == approx(S(0)));
}

TEST_CASE_TEMPLATE("a turning leader is carried forward along its circle", S, float, double) {
  constexpr std::uint32_t kSeed = 19;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const double u = random(-3, 3), v = random(-1, 1), r = random(-1, 1), psi = random.angle();
    const double h = random(0, 1);
    TrackState<S> state;
    update(TrackParams<S>{}, state, S(psi), Nu<S>{S(u), S(v), S(r)}, S(0));
    const Motion<S> m = track_forward(state, S(h));
    const double chord = std::abs(r) < 1e-9 ? h : 2 / r * std::sin(0.5 * r * h);
    const auto exact = to_north_east(psi + 0.5 * r * h, Vec2<double>{u * chord, v * chord});
    const double bound = r * r * h * h / 24 * h * std::hypot(u, v) + 1e-5;
    CHECK(std::abs(double(m.moved_n.x) - exact.x) <= bound);
    CHECK(std::abs(double(m.moved_n.y) - exact.y) <= bound);
    CHECK(m.psi == approx(S(psi + r * h), 4));
  }
}

TEST_CASE_TEMPLATE("a leader at constant acceleration is carried forward with it", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 20;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 50; ++i) {
    const double a_u = random(-1, 1), a_v = random(-0.2, 0.2), a_r = random(-0.5, 0.5);
    TrackState<S> state;
    double t = 0;
    for (int k = 0; k < 60; ++k) {
      const double dt = k == 0 ? 0 : random(0.05, 0.3);
      t += dt;
      update(TrackParams<S>{}, state, S(0.5 * a_r * t * t),
             Nu<S>{S(a_u * t), S(a_v * t), S(a_r * t)}, S(dt));
    }
    CHECK(std::abs(double(state.nu_dot.u) - a_u) < 1e-3);
    CHECK(std::abs(double(state.nu_dot.v) - a_v) < 1e-3);
    CHECK(std::abs(double(state.nu_dot.r) - a_r) < 1e-3);
    const Motion<S> m = track_forward(state, S(0.4));
    CHECK(std::abs(double(m.nu.u) - a_u * (t + 0.4)) < 1e-3);
    CHECK(std::abs(double(m.psi) - 0.5 * a_r * (t + 0.4) * (t + 0.4)) < 1e-3);
  }
}

TEST_CASE_TEMPLATE("messages at no distance in time, or backwards, do no harm", S, float, double) {
  for (const double dt : {0.0, -0.1, -1e6}) {
    TrackState<S> state;
    update(TrackParams<S>{}, state, S(0.1), Nu<S>{S(1), S(0), S(0)}, S(0));
    update(TrackParams<S>{}, state, S(0.1), Nu<S>{S(1.1), S(0), S(0)}, S(0.1));
    update(TrackParams<S>{}, state, S(0.3), Nu<S>{S(2), S(0), S(0.5)}, S(dt));
    const Motion<S> m = track_forward(state, S(0.2));
    CHECK(all_finite(m));
    CHECK(std::abs(m.nu_dot.u) <= S(5));
    CHECK(state.nu.u == S(2));
    CHECK(state.psi == S(0.3));
  }
}

TEST_CASE_TEMPLATE(
    "no spacing of messages makes the acceleration exceed the range of speeds over T", S, float,
    double) {
  constexpr std::uint32_t kSeed = 21;
  INFO("seed ", kSeed);
  Random random(kSeed);
  const TrackParams<S> params;
  for (int run = 0; run < 50; ++run) {
    TrackState<S> state;
    const double shortest = std::pow(10, random(-6, 0));
    for (int k = 0; k < 300; ++k) {
      const Nu<S> nu{S(random(-20, 20)), S(random(-20, 20)), S(random(-4, 4))};
      update(params, state, S(random.angle()), nu, S(random(0, 3) * shortest));
      REQUIRE(std::abs(state.nu_dot.u) <= S(40) / params.lag_s * S(1.001));
      REQUIRE(std::abs(state.nu_dot.r) <= S(8) / params.lag_s * S(1.001));
      REQUIRE(all_finite(track_forward(state, S(random(0, 10)))));
    }
  }
}

TEST_CASE_TEMPLATE("after a gap the old acceleration is forgotten", S, float, double) {
  TrackState<S> state;
  update(TrackParams<S>{}, state, S(0), Nu<S>{S(0), S(0), S(0)}, S(0));
  update(TrackParams<S>{}, state, S(0), Nu<S>{S(1), S(0), S(0)}, S(0.5));
  CHECK(state.nu_dot.u > S(1));
  update(TrackParams<S>{}, state, S(0), Nu<S>{S(3), S(0), S(0)}, S(2.5));
  CHECK(state.nu_dot.u == S(0));
}

TEST_CASE_TEMPLATE("told by another source, a vessel goes on with the acceleration that it had", S,
                   float, double) {
  for (const double silence : {0.1, 1.9, 2.5, 0.0}) {
    TrackState<S> state;
    update(TrackParams<S>{}, state, S(0), Nu<S>{S(0), S(0), S(0)}, S(0));
    update(TrackParams<S>{}, state, S(0), Nu<S>{S(1), S(0), S(0)}, S(0.5));
    const S before = state.nu_dot.u;
    // 0.1 m/s of disagreement is no acceleration.
    track_resume(TrackParams<S>{}, state,
                 TrackMessage<S>{S(1), {S(1.1), S(0), S(2)}, S(silence), S(0.1)});
    const bool goes_on = 0 < silence && silence < 2;
    CHECK(state.nu_dot.u == (goes_on ? before : S(0)));
    CHECK(state.nu_dot.r == S(0));
    CHECK(state.dt == (goes_on ? S(silence) : S(0)));
    CHECK(state.nu.u == S(1.1));
    CHECK(state.psi == S(1));
  }
}

TEST_CASE_TEMPLATE("a message of age zero says where the vessel is, not where it may be", S, float,
                   double) {
  TrackState<S> state;
  CHECK(all_finite(track_forward(state, S(10))));  // before the first message
  update(TrackParams<S>{}, state, S(1), Nu<S>{S(1), S(2), S(3)}, S(0));
  const Motion<S> m = track_forward(state, S(0));
  CHECK(m.moved_n.x == S(0));
  CHECK(m.moved_n.y == S(0));
  CHECK(m.psi == S(1));
  CHECK(m.nu.r == S(3));
}

}  // namespace
}  // namespace flotilla::core
