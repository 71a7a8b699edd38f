// SPDX-License-Identifier: MIT
// The velocity that the boat ought to have, ν*, and its derivative.
//
//   u* = u_L − k_x e_x          u̇* = u̇_L − k_x ė_x                              (eq:49a)
//   r* = r_L − k_ψ tanh e_ψ     ṙ* = ṙ_L − k_ψ (1 − tanh² e_ψ) ė_ψ               (eq:49b)
//   v̇* = −(m11/m22) u* r* − (d22/m22) v*,  v*(0) = v_L(0) (eq:mas-constraint)
//
// v* over a step h in which u*, r* are held, exactly:
//   v* ← e^{−bh} v* − (m11/d22)(1 − e^{−bh}) u* r*,   b = d22/m22
//
//  symbol       meaning                     unit       tested range
//  k_x, k_psi   gains                       1/s        0 … 2
//  v_star       sway that follows from u*, r*  m/s     ±20
//  h            control step                s          0 … 0.2
#pragma once

#include "core/formation_error.hpp"
#include "core/vessel.hpp"

namespace flotilla::core {

template <class S>
struct VirtualVelocityParams {
  S k_x{};
  S k_psi{};
};

template <class S>
struct VirtualVelocityState {
  S v_star{};
  S u_star_held{};
  S r_star_held{};
};

template <class S>
struct VirtualVelocity {
  Nu<S> nu_star{};
  S u_star_dot{};
  S r_star_dot{};
};

/// Carries v* over the h seconds since the step before, in which its u* and r* were held.
template <class S>
void virtual_sway_forward(const Vessel<S>& vessel, VirtualVelocityState<S>& state, S h) {
  const S decay = exp(-(vessel.d22 / vessel.m22) * h);
  state.v_star = decay * state.v_star -  // (eq:mas-constraint)
                 (vessel.m11 / vessel.d22) * (S(1) - decay) * state.u_star_held * state.r_star_held;
}

template <class S>
VirtualVelocity<S> virtual_velocity(const VirtualVelocityParams<S>& params,
                                    VirtualVelocityState<S>& state, const Encounter<S>& in,
                                    const FormationError<S>& error) {
  const S t = tanh(error.e.psi);
  VirtualVelocity<S> out;
  out.nu_star.u = in.nu_L.u - params.k_x * error.e.x;  // (eq:49a)
  out.nu_star.v = state.v_star;
  out.nu_star.r = in.nu_L.r - params.k_psi * t;  // (eq:49b)
  out.u_star_dot = in.nu_L_dot.u - params.k_x * error.e_dot.x;
  out.r_star_dot = in.nu_L_dot.r - params.k_psi * (S(1) - t * t) * error.e_dot.psi;
  state.u_star_held = out.nu_star.u;
  state.r_star_held = out.nu_star.r;
  return out;
}

}  // namespace flotilla::core
