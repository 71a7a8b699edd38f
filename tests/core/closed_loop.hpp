// SPDX-License-Identifier: MIT
// A miniature world: the paper's three-degree-of-freedom vessel (eq:1), twice, and the law between.
#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "core/arbitrary.hpp"

namespace flotilla::testing {

/// A thrust that is a function of time, s.
using Thrusting = std::function<core::Tau<double>(double)>;

/// A vessel with the paper's nominal values in water that moves; its own model, not core's.
struct Hull {
  using Q = std::array<double, 6>;
  Q q{};                         ///< x, y, ψ over ground; u, v, r through the water
  core::Vec2<double> current{};  ///< the water's velocity, north and east
  core::Vec2<double> drag{};     ///< besides: surge kg/m of |u| u, yaw kg m of |u| r

  static Q rates(const Q& q, core::Tau<double> tau, const core::Vec2<double>& current = {},
                 const core::Vec2<double>& drag = {}) {
    constexpr double m11 = 1.012, m22 = 1.982, m33 = 0.354, d11 = 3.436, d22 = 18.99, d33 = 0.864;
    const auto [x, y, psi, u, v, r] = q;
    const double c = std::cos(psi), s = std::sin(psi);
    return {u * c - v * s + current.x,
            u * s + v * c + current.y,
            r,
            (tau.X + m22 * v * r - d11 * u - drag.x * std::abs(u) * u) / m11,
            (-m11 * u * r - d22 * v) / m22,
            (tau.N - (m22 - m11) * u * v - d33 * r - drag.y * std::abs(u) * r) / m33};
  }

  /// Runge-Kutta of order 4 with the wrench held.
  void advance(core::Tau<double> tau, double h) {
    const auto at = [&](const Q& k, double step) {
      Q out = q;
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += step * k[i];
      return rates(out, tau, current, drag);
    };
    const Q k1 = at({}, 0), k2 = at(k1, h / 2), k3 = at(k2, h / 2), k4 = at(k3, h);
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
};

/// A vessel as others see it: over ground.
struct Sighting {
  core::Vec2<double> place{};
  double psi = 0;
  core::Nu<double> nu{}, nu_dot{};
};

inline Sighting sighting_of(const Hull& hull, core::Tau<double> tau = {}) {
  const auto& q = hull.q;
  const Hull::Q rate = Hull::rates(q, tau, hull.current);
  const double c = std::cos(q[2]), s = std::sin(q[2]), r = q[5];
  const double ahead = c * hull.current.x + s * hull.current.y;
  const double aside = c * hull.current.y - s * hull.current.x;
  return {{q[0], q[1]},
          q[2],
          {q[3] + ahead, q[4] + aside, r},
          {rate[3] + r * aside, rate[4] - r * ahead, rate[5]}};
}

template <class S>
core::Nu<S> in_scalar(const core::Nu<double>& nu) {
  return {in_scalar<S>(nu.u), in_scalar<S>(nu.v), in_scalar<S>(nu.r)};
}

template <class S>
core::ControllerInput<S> controller_input_of(const Sighting& own, const Sighting& leader) {
  return {{in_scalar<S>(own.place.x - leader.place.x), in_scalar<S>(own.place.y - leader.place.y)},
          in_scalar<S>(own.psi),
          in_scalar<S>(leader.psi),
          in_scalar<S>(own.nu),
          in_scalar<S>(leader.nu),
          in_scalar<S>(leader.nu_dot),
          {},
          {}};
}

struct ClosedLoop {
  Hull leader{};
  Hull boat{{1.46, 0.45, 1.33, 0, 0, 0}};
  double t = 0;
};

/// The default law with the paper's gains and 50 N propellers.
template <class S>
core::ControllerParams<S> papers_controller() {
  return {{}, {S(0.2), S(0.2)}, {S(10), S(10)}, papers_vessel<S>(), {S(0.25), S(50), S(50)}};
}

template <class S>
core::Tau<double> in_double(const core::Tau<S>& tau) {
  return {number_of(tau.X), number_of(tau.N)};
}

/// Sails until `until` at 100 Hz with exact states; returns the last error.
template <class S>
core::Error<double> sail(ClosedLoop& world, core::ControllerState<S>& state, double until,
                         const Thrusting& leader_tau) {
  constexpr double h = 0.01;
  const core::ControllerParams<S> params = papers_controller<S>();
  core::Error<double> e{};
  for (; world.t < until - h / 2; world.t += h) {
    const core::Tau<double> tau = leader_tau(world.t);
    const auto in = controller_input_of<S>(sighting_of(world.boat), sighting_of(world.leader, tau));
    const core::ControllerOutput<S> out =
        core::controller_step(params, state, in, world.t > 0 ? in_scalar<S>(h) : S(0));
    world.boat.advance(in_double(out.allocation.given), h);
    world.leader.advance(tau, h);
    e = {number_of(out.error.e.x), number_of(out.error.e.y), number_of(out.error.e.psi)};
  }
  return e;
}

/// The paper's leader.
inline core::Tau<double> s_curve(double t) { return {2, 0.3 * std::sin(0.3 * t)}; }

}  // namespace flotilla::testing
