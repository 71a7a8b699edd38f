// SPDX-License-Identifier: MIT
// Pairs of propellers. Equations and shapes: sil/plant/propeller.py.
#include <algorithm>
#include <cmath>

#include "arrays.hpp"
#include "plant.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace flotilla::plant {
namespace {

/// A row of `sil.plant.propeller.stack`.
struct Propellers {
  double arm, forward_max, reverse_max, expo, lag_s, rpm_max;
  double gain[2];
  double dead;
};

Propellers propellers_of(const Input<2>& parameters, std::size_t i) {
  const auto p = parameters.view();
  return {p(i, 0), p(i, 1), p(i, 2), p(i, 3), p(i, 4), p(i, 5), {p(i, 6), p(i, 7)}, p(i, 8)};
}

double steady_thrust(double command, const Propellers& p) {
  const double c = std::min(std::max(command, -1.0), 1.0);
  if (std::abs(c) < p.dead) return 0.0;
  const double limit = c >= 0.0 ? p.forward_max : p.reverse_max;
  return limit * ((1.0 - p.expo) * c + p.expo * c * std::abs(c));
}

void advance_propellers(Array<2> thrust, Input<2> command, Array<3> tau, Input<2> parameters,
                        double h_s) {
  const std::size_t n = thrust.shape(0);
  expect(thrust, "thrust: (n, 2)", n, 2);
  expect(command, "command: (n, 2)", n, 2);
  expect(tau, "tau: (3, n, 2)", 3, n, 2);
  expect(parameters, "parameters: (n, 9)", n, 9);
  const auto now = thrust.view();
  const auto commanded = command.view();
  const auto out = tau.view();
  for (std::size_t i = 0; i < n; ++i) {
    const Propellers p = propellers_of(parameters, i);
    const double half_decay = p.lag_s > 0.0 ? std::exp(-0.5 * h_s / p.lag_s) : 0.0;
    const double port_end = p.gain[0] * steady_thrust(commanded(i, 0), p);
    const double stbd_end = p.gain[1] * steady_thrust(commanded(i, 1), p);
    double port_gap = p.lag_s > 0.0 ? now(i, 0) - port_end : 0.0;
    double stbd_gap = p.lag_s > 0.0 ? now(i, 1) - stbd_end : 0.0;
    for (std::size_t stage = 0; stage < 3; ++stage) {
      const double port = port_end + port_gap, stbd = stbd_end + stbd_gap;
      out(stage, i, 0) = port + stbd;
      out(stage, i, 1) = p.arm * (port - stbd);
      now(i, 0) = port;
      now(i, 1) = stbd;
      port_gap *= half_decay;
      stbd_gap *= half_decay;
    }
  }
}

void shaft_speeds(Input<2> thrust, Input<2> parameters, Array<2> rpm) {
  const std::size_t n = thrust.shape(0);
  expect(thrust, "thrust: (n, 2)", n, 2);
  expect(parameters, "parameters: (n, 9)", n, 9);
  expect(rpm, "rpm: (n, 2)", n, 2);
  const auto now = thrust.view();
  const auto out = rpm.view();
  for (std::size_t i = 0; i < n; ++i) {
    const Propellers p = propellers_of(parameters, i);
    for (std::size_t side = 0; side < 2; ++side) {
      const double ideal = now(i, side) / p.gain[side];
      const double limit = ideal >= 0.0 ? p.forward_max : p.reverse_max;
      // limit 0: a propeller that cannot reverse
      const double speed = limit > 0.0 ? p.rpm_max * std::sqrt(std::abs(ideal) / limit) : 0.0;
      out(i, side) = ideal >= 0.0 ? speed : -speed;
    }
  }
}

}  // namespace

void bind_propeller(nb::module_& m) {
  m.def("advance_propellers", &advance_propellers, "thrust"_a.noconvert(), "command"_a.noconvert(),
        "tau"_a.noconvert(), "parameters"_a.noconvert(), "h_s"_a,
        "Advances the thrust of propellers by one step: `sil.plant.propeller.advance`.");
  m.def("shaft_speeds", &shaft_speeds, "thrust"_a.noconvert(), "parameters"_a.noconvert(),
        "rpm"_a.noconvert(), "Shaft speeds of propellers: `sil.plant.propeller.shaft_speed`.");
}

}  // namespace flotilla::plant
