// SPDX-License-Identifier: MIT
// Hulls of three degrees of freedom. Equations, frames and sources: sil/plant/hull.py.
#include <array>
#include <cmath>

#include "arrays.hpp"
#include "plant.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace flotilla::plant {
namespace {

/// A row of `sil.plant.hull.stack`: `HullParameters`, then M inverted.
struct Hull {
  double m11, m22, m33, d11, d22, d33, m23, d11_uu, d33_rr, crossflow, length, d33_u;
  double sway_of_yaw, sway_inertia, yaw_of_sway, yaw_inertia;
};
constexpr std::size_t kColumns = sizeof(Hull) / sizeof(double);

struct Pair {
  double first, second;
};

/// Cross-flow drag in sway and yaw: k ∫ |v + x r| (v + x r) [1 x] dx, |x| ≤ `half` (m).
/// In closed form, in two cases: v + x r changes its sign on the waterline, or does not.
Pair crossflow(double v, double r, double k, double half) {
  const double swing = r * half;
  if (std::abs(v) >= std::abs(swing)) {
    const double drag = 2.0 * half * k * std::abs(v) * v;
    const double ratio = v != 0.0 ? swing / v : 0.0;
    return {drag * (1.0 + ratio * ratio / 3.0), (2.0 / 3.0) * drag * half * ratio};
  }
  const double drag = half * k * std::abs(swing) * swing;
  const double q = v / swing;
  return {drag * (2.0 + (2.0 / 3.0) * q * q) * q,
          drag * half * (0.5 + q * q * (1.0 - q * q / 6.0))};
}

using Rates = std::array<double, 6>;

/// [ẋ ẏ ψ̇ u̇ v̇ ṙ], written out by rows; `plain`: the paper's vessel on still water.
Rates rates(double psi, double u, double v, double r, Pair tau, const double* w, bool plain,
            Pair water, const Hull& p) {
  const double cos = std::cos(psi), sin = std::sin(psi);
  const double x_dot = cos * u - sin * v, y_dot = sin * u + cos * v;
  if (plain) {  // the same bits as below, in half the time
    const double surge = tau.first + w[0] + p.m22 * v * r - p.d11 * u;
    const double sway = w[1] - p.m11 * u * r - p.d22 * v;
    const double yaw = tau.second + w[2] - (p.m22 - p.m11) * u * v - p.d33 * r;
    return {x_dot, y_dot, r, surge / p.m11, sway / p.sway_inertia, yaw / p.yaw_inertia};
  }
  const auto [north, east] = water;
  const double u_c = cos * north + sin * east, v_c = cos * east - sin * north;
  const double u_r = u - u_c, v_r = v - v_c;
  const double surge = tau.first + w[0] + p.m22 * v_r * r - p.d11 * u_r +
                       (p.m23 * r * r - p.d11_uu * std::abs(u_r) * u_r);
  double sway = w[1] - p.m11 * u_r * r - p.d22 * v_r;
  double yaw = tau.second + w[2] - (p.m22 - p.m11) * u_r * v_r - p.d33 * r -
               (p.m23 * u_r + p.d33_rr * std::abs(r) + p.d33_u * std::abs(u_r)) * r;
  if (p.crossflow > 0.0) {
    const auto [sway_drag, yaw_drag] = crossflow(v_r, r, p.crossflow, 0.5 * p.length);
    sway -= sway_drag;
    yaw -= yaw_drag;
  }
  return {x_dot,
          y_dot,
          r,
          surge / p.m11 + r * v_c,
          (sway - p.sway_of_yaw * yaw) / p.sway_inertia - r * u_c,
          (yaw - p.yaw_of_sway * sway) / p.yaw_inertia};
}

struct Vessel {
  double* eta;
  double* nu;
  const double* w;
  Pair water;
  const Hull& hull;
};

/// One step of classical Runge-Kutta 4; tau at its start, middle and end.
void carry(const Vessel& at, Pair start, Pair middle, Pair end, double h) {
  const Hull& p = at.hull;
  const auto [north, east] = at.water;
  const bool plain = p.m23 == 0.0 && p.d11_uu == 0.0 && p.d33_rr == 0.0 && p.d33_u == 0.0 &&
                     p.crossflow == 0.0 && north == 0.0 && east == 0.0;
  const double half = 0.5 * h, sixth = h / 6.0;
  const double psi = at.eta[2], u = at.nu[0], v = at.nu[1], r = at.nu[2];
  const auto after = [&](double step, const Rates& k, Pair tau) {
    return rates(psi + step * k[2], u + step * k[3], v + step * k[4], r + step * k[5], tau, at.w,
                 plain, at.water, p);
  };
  const Rates a = rates(psi, u, v, r, start, at.w, plain, at.water, p);
  const Rates b = after(half, a, middle);
  const Rates c = after(half, b, middle);
  const Rates d = after(h, c, end);
  for (std::size_t j = 0; j < 3; ++j) {
    at.eta[j] += sixth * (a[j] + 2.0 * (b[j] + c[j]) + d[j]);
    at.nu[j] += sixth * (a[j + 3] + 2.0 * (b[j + 3] + c[j + 3]) + d[j + 3]);
  }
}

using Rows = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using InputRows = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

void advance_hulls(Rows eta, Rows nu, Input<3> tau, InputRows w, InputRows current,
                   InputRows parameters, double h_s) {
  const std::size_t n = eta.shape(0);
  expect(eta, "eta: (n, 3)", n, 3);
  expect(nu, "nu: (n, 3)", n, 3);
  expect(tau, "tau: (2 steps + 1, n, 2)", tau.shape(0) | 1U, n, 2);
  expect(w, "w: (n, 3)", n, 3);
  expect(current, "current: (n, 2)", n, 2);
  expect(parameters, "parameters: (n, 16)", n, kColumns);
  const auto given = tau.view();
  for (std::size_t k = 0; k + 2 < tau.shape(0); k += 2) {
    for (std::size_t i = 0; i < n; ++i) {
      const auto tau_at = [&](std::size_t stage) -> Pair {
        return {given(k + stage, i, 0), given(k + stage, i, 1)};
      };
      const double* p = parameters.data() + kColumns * i;
      const Hull hull{p[0], p[1], p[2],  p[3],  p[4],  p[5],  p[6],  p[7],
                      p[8], p[9], p[10], p[11], p[12], p[13], p[14], p[15]};
      const double* water = current.data() + 2 * i;
      carry({eta.data() + 3 * i, nu.data() + 3 * i, w.data() + 3 * i, {water[0], water[1]}, hull},
            tau_at(0), tau_at(1), tau_at(2), h_s);
    }
  }
}

}  // namespace

void bind_hull(nb::module_& m) {
  m.def("advance_hulls", &advance_hulls, "eta"_a.noconvert(), "nu"_a.noconvert(),
        "tau"_a.noconvert(), "w"_a.noconvert(), "current"_a.noconvert(), "parameters"_a.noconvert(),
        "h_s"_a, "Advances hulls by steps of `h_s` seconds, in place: `sil.plant.hull.sail`.");
}

}  // namespace flotilla::plant
