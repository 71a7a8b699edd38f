// SPDX-License-Identifier: MIT
// PD+: the wrench that makes the velocity follow ν*, τ = G†(M ν̇* + C(ν) ν* + D(u) ν* − K_d (ν − ν*)).
//
//   X = m11 u̇* − m22 v r* + (d11 + d11q |u|) u* − k_du (u − u*)
//   N = m33 ṙ* + m22 v u* − m11 u v* + (d33 + d33u |u|) r* − k_dr (r − r*)
//
//  symbol      meaning                       unit        tested range
//  k_du, k_dr  velocity gains, surge, yaw    kg/s, kg m²/s  0 … 100
//
// Source: paper (eq:mas-underactuated-control), its two actuated rows. Not in paper: d11q, d33u. |u|
// is the measured speed, as C's velocities are: the error of ν then obeys M ė + C(ν) e + (D(u) + K_d)
// e = 0, and the terms only add to its damping.
//
// Q16.16: tested within ±1,000 (wrench, N)
#pragma once

#include "core/virtual_velocity.hpp"

namespace flotilla::core {

template <class S>
struct PdPlusParams {
  S k_du{};
  S k_dr{};
};

template <class S>
Tau<S> pd_plus(const PdPlusParams<S>& params, const Vessel<S>& m, const VirtualVelocity<S>& desired,
               const Nu<S>& nu) {
  const Nu<S>& star = desired.nu_star;
  return {m.m11 * desired.u_star_dot - m.m22 * nu.v * star.r + surge_damping(m, nu.u) * star.u -
              params.k_du * (nu.u - star.u),
          m.m33 * desired.r_star_dot + m.m22 * nu.v * star.u - m.m11 * nu.u * star.v +
              yaw_damping(m, nu.u) * star.r - params.k_dr * (nu.r - star.r)};
}

}  // namespace flotilla::core
