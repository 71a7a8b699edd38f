// SPDX-License-Identifier: MIT
// The velocity that the boat ought to have, ν*, and its derivative.
//
//   u* = u_S − k_x e_x               u̇* = u̇_S − k_x ė_x                           (eq:49a)
//   r* = r_S − k_ψ tanh e_ψ          ṙ* = ṙ_S − k_ψ (1 − tanh² e_ψ) ė_ψ            (eq:49b)
//   v̇* = −(m11/m22) u* r* − (d22/m22) v*,  v*(0) = v_L(0) (eq:mas-constraint)
//
// with e_ψ − θ for e_ψ, and θ̇, θ̈ added, where there is a line of sight; then |u*| ≤ u_max, |r*| ≤ r_max.
// v* over a step h in which u*, r* are held, exactly:
//   v* ← e^{−bh} v* − (m11/d22)(1 − e^{−bh}) u* r*,   b = d22/m22
//
//  symbol        meaning                         unit        tested range
//  k_x, k_psi    gains                           1/s         0 … 2
//  u_max, r_max  greatest speed and yaw rate     m/s, rad/s  0: any
//  v_star        sway that follows from u*, r*   m/s         ±20
//  h             control step                    s           0 … 0.2
//
// Not in paper: θ and the limits. Both are over ground, whatever the slot does: in a current the same
// ν* is another one through the water, by as much as the current. A slot that needs more is too fast,
// |w_S| > u_max or |r_S| > r_max, and is told so. At a limit ν* is constant, and nothing is integrated
// from what could not be reached.
//
// Q16.16: tested within ±500 (damping, kg/s)
#pragma once

#include "core/line_of_sight.hpp"

namespace flotilla::core {

template <class S>
struct VirtualVelocityParams {
  S k_x{};
  S k_psi{};
  S u_max{};
  S r_max{};
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
  bool u_limited = false;
  bool r_limited = false;
};

/// Carries v* over the h seconds since the step before, in which its u* and r* were held.
template <class S>
void virtual_sway_forward(const Vessel<S>& vessel, VirtualVelocityState<S>& state, S h) {
  const S decay = exp(-vessel.d22_m22 * h);
  state.v_star = decay * state.v_star -  // (eq:mas-constraint)
                 vessel.m11_d22 * (S(1) - decay) * state.u_star_held * state.r_star_held;
}

/// Keeps a wanted velocity within ±most, 0: no limit, and tells whether that changed it; where it is
/// held, it has no derivative.
template <class S>
bool keep_within(S most, S& desired, S& desired_dot) {
  if (!(S(0) < most && most < abs(desired))) return false;
  desired = clamp(desired, -most, most);
  desired_dot = S(0);
  return true;
}

/// A velocity no greater than most, 0: any.
template <class S>
Vec2<S> shortened(const Vec2<S>& v, S most) {
  const S speed = hypot(v.x, v.y);
  if (!(S(0) < most && most < speed)) return v;
  return {scaled(v.x, most, speed), scaled(v.y, most, speed)};
}

/// By which of a boat's limits its slot is too fast: what it needs, m/s and rad/s, 0 where that is
/// within the limit.
template <class S>
struct TooFast {
  S u{};
  S r{};
};

template <class S>
TooFast<S> too_fast(const VirtualVelocityParams<S>& params, const Slot<S>& slot) {
  const auto beyond = [](S most, S needed) { return S(0) < most && most < needed ? needed : S(0); };
  return {beyond(params.u_max, hypot(slot.nu.u, slot.nu.v)), beyond(params.r_max, abs(slot.nu.r))};
}

/// The speed that is wanted, before its limit.
template <class S>
S desired_surge(const VirtualVelocityParams<S>& params, const Slot<S>& slot,
                const FormationError<S>& error) {
  return slot.nu.u - params.k_x * error.e.x;  // (eq:49a)
}

template <class S>
VirtualVelocity<S> virtual_velocity(const VirtualVelocityParams<S>& params,
                                    VirtualVelocityState<S>& state, const Slot<S>& slot,
                                    const FormationError<S>& error, const LineOfSight<S>& sight) {
  const S t = tanh(wrap_pi(error.e.psi - sight.theta));
  VirtualVelocity<S> out;
  out.nu_star.u = desired_surge(params, slot, error);
  out.nu_star.v = state.v_star;
  out.nu_star.r = slot.nu.r - params.k_psi * t + sight.theta_dot;  // (eq:49b)
  out.u_star_dot = slot.nu_dot.u - params.k_x * error.e_dot.x;
  out.r_star_dot = slot.nu_dot.r -
                   params.k_psi * (S(1) - t * t) * (error.e_dot.psi - sight.theta_dot) +
                   sight.theta_ddot;
  out.u_limited = keep_within(params.u_max, out.nu_star.u, out.u_star_dot);
  out.r_limited = keep_within(params.r_max, out.nu_star.r, out.r_star_dot);
  state.u_star_held = out.nu_star.u;
  state.r_star_held = out.nu_star.r;
  return out;
}

}  // namespace flotilla::core
