// SPDX-License-Identifier: MIT
// A miniature world: the paper's three-degree-of-freedom vessel (eq:1), twice, and the law between.
#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "core/arbitrary.hpp"

namespace flotilla::testing {

/// x, y, ψ, u, v, r of a vessel with the paper's nominal values; its own model, not core's.
struct Hull {
  using Q = std::array<double, 6>;
  Q q{};

  static Q rates(const Q& q, core::Tau<double> tau) {
    constexpr double m11 = 1.012, m22 = 1.982, m33 = 0.354, d11 = 3.436, d22 = 18.99, d33 = 0.864;
    const auto [x, y, psi, u, v, r] = q;
    return {u * std::cos(psi) - v * std::sin(psi),
            u * std::sin(psi) + v * std::cos(psi),
            r,
            (tau.X + m22 * v * r - d11 * u) / m11,
            (-m11 * u * r - d22 * v) / m22,
            (tau.N - (m22 - m11) * u * v - d33 * r) / m33};
  }

  /// Runge-Kutta of order 4 with the wrench held.
  void advance(core::Tau<double> tau, double h) {
    const auto at = [&](const Q& k, double step) {
      Q out = q;
      for (std::size_t i = 0; i < out.size(); ++i) out[i] += step * k[i];
      return out;
    };
    const Q k1 = rates(q, tau), k2 = rates(at(k1, h / 2), tau), k3 = rates(at(k2, h / 2), tau),
            k4 = rates(at(k3, h), tau);
    for (std::size_t i = 0; i < q.size(); ++i)
      q[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
  }
};

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
core::Encounter<S> encounter_of(const ClosedLoop& world, core::Tau<double> leader_tau) {
  const auto& o = world.boat.q;
  const auto& l = world.leader.q;
  const Hull::Q l_dot = Hull::rates(l, leader_tau);
  return {{S(o[0] - l[0]), S(o[1] - l[1])},
          S(o[2]),
          S(l[2]),
          {S(o[3]), S(o[4]), S(o[5])},
          {S(l[3]), S(l[4]), S(l[5])},
          {S(l_dot[3]), S(l_dot[4]), S(l_dot[5])}};
}

inline double number_of(float x) { return double{x}; }
inline double number_of(double x) { return x; }

/// Sails until `until` at 100 Hz; the leader's wrench is a function of time. The last error.
template <class S, class Number>
core::Error<double> sail(ClosedLoop& world, core::ControllerState<S>& state, double until,
                         const std::function<core::Tau<double>(double)>& leader_tau,
                         Number number) {
  constexpr double h = 0.01;
  const core::ControllerParams<S> params = papers_controller<S>();
  core::Error<double> e{};
  for (; world.t < until - h / 2; world.t += h) {
    const core::Encounter<S> in = encounter_of<S>(world, leader_tau(world.t));
    const core::ControllerOutput<S> out =
        core::controller_step(params, state, in, world.t > 0 ? S(h) : S(0));
    const core::Tau<S>& given = out.allocation.given;
    world.boat.advance({number(given.X), number(given.N)}, h);
    world.leader.advance(leader_tau(world.t), h);
    e = {number(out.error.e.x), number(out.error.e.y), number(out.error.e.psi)};
  }
  return e;
}

/// The paper's leader.
inline core::Tau<double> s_curve(double t) { return {2, 0.3 * std::sin(0.3 * t)}; }

}  // namespace flotilla::testing
