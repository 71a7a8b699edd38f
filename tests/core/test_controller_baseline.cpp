// SPDX-License-Identifier: MIT
// With every extension at 0 the law is the paper's, to the last bit.
#include <array>

#include "core/arbitrary.hpp"

namespace flotilla::core {
namespace {

using testing::Random;

/// All outputs of the paper's law, in this order.
template <class S>
using Said = std::array<S, 22>;

/// The paper's equations and the allocation, written once more.
template <class S>
struct PapersLaw {
  ControllerParams<S> p;
  S v_star, u_held{}, r_held{};

  Said<S> step(const ControllerInput<S>& in, S dt) {
    const Vessel<S>& m = p.vessel;
    const auto [u, v, r] = in.nu;
    const auto [u_L, v_L, r_L] = in.nu_L;

    // (eq:formation-error), (eq:error-kinematics-formation)
    const S x = in.separation_n.x - p.slot.d.x, y = in.separation_n.y - p.slot.d.y;
    const S e_x = std::cos(in.psi) * x + std::sin(in.psi) * y;
    const S e_y = std::cos(in.psi) * y - std::sin(in.psi) * x;
    const S e_psi = wrap_pi(in.psi - in.psi_L);
    const S c = std::cos(e_psi), s = std::sin(e_psi);
    const S e_x_dot = r * e_y + u - (u_L * c + v_L * s);
    const S e_y_dot = v - r * e_x - (v_L * c - u_L * s);
    const S e_psi_dot = r - r_L;

    // (eq:mas-constraint)
    const S decay = std::exp(-(m.d22 / m.m22) * dt);
    v_star = decay * v_star - (m.m11 / m.d22) * (1 - decay) * u_held * r_held;

    // (eq:49a), (eq:49b)
    const S t = std::tanh(e_psi);
    const S u_star = u_L - p.outer.k_x * e_x;
    const S r_star = r_L - p.outer.k_psi * t;
    const S u_star_dot = in.nu_L_dot.u - p.outer.k_x * e_x_dot;
    const S r_star_dot = in.nu_L_dot.r - p.outer.k_psi * (1 - t * t) * e_psi_dot;
    u_held = u_star;
    r_held = r_star;

    // (eq:mas-underactuated-control)
    const S X =
        m.m11 * u_star_dot - m.m22 * v * r_star + m.d11 * u_star - p.inner.k_du * (u - u_star);
    const S N = m.m33 * r_star_dot + m.m22 * v * u_star - m.m11 * u * v_star + m.d33 * r_star -
                p.inner.k_dr * (r - r_star);

    // not in paper: yaw first, then surge
    const auto& [a, F, R, brakes] = p.propellers;
    REQUIRE(!brakes);
    const S D_max = S(0.5) * (F + R);
    const S D = clamp(N / (2 * a), -D_max, D_max);
    const S middle = clamp(S(0.5) * X, std::abs(D) - R, F - std::abs(D));
    const S port = clamp(middle + D, -R, F), stbd = clamp(middle - D, -R, F);
    const S X_given = port + stbd, N_given = a * (port - stbd);
    return {e_x,     e_y,         e_psi,       e_x_dot, e_y_dot, e_psi_dot, u_star, v_star,
            r_star,  u_star_dot,  r_star_dot,  X,       N,       port,      stbd,   X_given,
            N_given, X - X_given, N - N_given, u_held,  r_held,  v_star};
  }
};

template <class S>
Said<S> said(const ControllerOutput<S>& out, const ControllerState<S>& state) {
  const auto& [slot, error, sight, too_fast, desired, separation, tau, allocation, astern] = out;
  return {error.e.x,
          error.e.y,
          error.e.psi,
          error.e_dot.x,
          error.e_dot.y,
          error.e_dot.psi,
          desired.nu_star.u,
          desired.nu_star.v,
          desired.nu_star.r,
          desired.u_star_dot,
          desired.r_star_dot,
          tau.X,
          tau.N,
          allocation.thrust.port,
          allocation.thrust.stbd,
          allocation.given.X,
          allocation.given.N,
          allocation.missing.X,
          allocation.missing.N,
          state.outer.u_star_held,
          state.outer.r_star_held,
          state.outer.v_star};
}

template <class S>
ControllerParams<S> arbitrary_params(Random& random) {
  ControllerParams<S> params;
  params.slot.d = {S(random(-9, 9)), S(random(-9, 9))};
  params.outer = {S(random(0, 2)), S(random(0, 2))};
  params.inner = {S(random(0, 100)), S(random(0, 100))};
  params.vessel = testing::arbitrary_vessel<S>(random);
  params.propellers = {S(random(0.1, 2)), S(random(1, 500)), S(random(1, 500))};
  return params;
}

template <class S>
int different(const Said<S>& a, const Said<S>& b) {
  int out = 0;
  for (std::size_t i = 0; i < a.size(); ++i) out += !testing::same_bits(a[i], b[i]);
  return out;
}

TEST_CASE_TEMPLATE("with every extension at 0 the law is the paper's, to the last bit", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 91;
  INFO("seed ", kSeed);
  Random random(kSeed);
  int saturated = 0, free = 0;
  for (int run = 0; run < 2000; ++run) {
    const ControllerParams<S> params = arbitrary_params<S>(random);
    ControllerInput<S> in = testing::arbitrary_encounter<S>(random);
    ControllerState<S> state = controller_start(in);
    PapersLaw<S> paper{params, in.nu_L.v};
    for (int k = 0; k < 5; ++k) {
      const S dt = S(k == 0 ? 0 : random(0, 0.2));
      const auto out = controller_step(params, state, in, dt);
      REQUIRE(different(said(out, state), paper.step(in, dt)) == 0);
      const bool limited = out.allocation.limits != 0;
      (limited ? saturated : free) += 1;
      in = testing::arbitrary_encounter<S>(random);
    }
  }
  CHECK(saturated > 100);
  CHECK(free > 100);
}

TEST_CASE_TEMPLATE(
    "at rest, in the slot or with the opposite heading the law is the paper's, to the bit", S,
    float, double) {
  Random random(92);
  for (int run = 0; run < 1000; ++run) {
    const ControllerParams<S> params = arbitrary_params<S>(random);
    ControllerInput<S> in = testing::encounter_in_slot(params.slot.d, random);
    if (run % 3 == 0) in.nu = in.nu_L = in.nu_L_dot = {};
    if (run % 3 == 1) in.psi_L = in.psi + S(random(3.1, 3.14)) * S(run % 2 == 0 ? 1 : -1);
    if (run % 9 == 0) in.psi_L = in.psi + S(run % 2 == 0 ? testing::kPi : -testing::kPi);
    ControllerState<S> state = controller_start(in);
    PapersLaw<S> paper{params, in.nu_L.v};
    for (const double dt : {0.0, 0.01, 0.02}) {
      const auto out = controller_step(params, state, in, S(dt));
      REQUIRE(different(said(out, state), paper.step(in, S(dt))) == 0);
    }
  }
}

TEST_CASE_TEMPLATE("with a heading opposite to the leader's, r* is that of the reported error", S,
                   float, double) {
  Random random(92);
  for (int i = 0; i < 3000; ++i) {
    ControllerInput<S> in;
    in.psi = S(random.angle());
    in.psi_L = in.psi + S(i % 2 == 0 ? testing::kPi : -testing::kPi);
    VirtualVelocityState<S> state;
    const auto error = testing::papers_error(in, {});
    const auto desired =
        testing::papers_velocity(VirtualVelocityParams<S>{S(1), S(1)}, state, in, {});
    CHECK(desired.nu_star.r == -std::tanh(error.e.psi));
  }
}

TEST_CASE("a one-bit change of any gain changes the result") {
  Random random(93);
  const ControllerParams<double> params = arbitrary_params<double>(random);
  const auto in = testing::arbitrary_encounter<double>(random);
  ControllerParams<double> other = params;
  other.outer.k_x = std::nextafter(params.outer.k_x, 10.0);
  ControllerState<double> state = controller_start(in);
  PapersLaw<double> paper{other, in.nu_L.v};
  const auto out = controller_step(params, state, in, 0.0);
  CHECK(different(said(out, state), paper.step(in, 0.0)) > 0);
}

}  // namespace
}  // namespace flotilla::core
