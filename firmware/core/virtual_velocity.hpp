// SPDX-License-Identifier: MIT
// The desired velocity ν* and its derivative.
//
//   u* = u_S − k_x e_x               u̇* = u̇_S − k_x ė_x                           (eq:49a)
//   r* = r_S − k_ψ tanh e_ψ          ṙ* = ṙ_S − k_ψ (1 − tanh² e_ψ) ė_ψ            (eq:49b)
//   v̇* = −(m11/m22) u* r* − (d22/m22) v*,  v*(0) = v_L(0) (eq:mas-constraint)
//
// A line of sight replaces e_ψ by e_ψ − θ and adds θ̇, θ̈; then |u*| ≤ u_max, |r*| ≤ 0.97 r_max.
// Where |r*| is above r_max / 4, it grows by 3 r_max per second at most.
// v* over a step h with constant u*, r*, exactly:
//   v* ← e^{−bh} v* − (m11/d22)(1 − e^{−bh}) u* r*,   b = d22/m22
//
//  symbol        meaning                         unit        tested range
//  k_x, k_psi    gains                           1/s         0 … 2
//  u_max, r_max  greatest speed and yaw rate     m/s, rad/s  0: no limit
//  v_star        sway that follows from u*, r*   m/s         ±20
//  h             control step                    s           0 … 0.2
//
// Not in paper: θ and the limits. Because its propellers respond late, a boat turns a little faster
// than r*, and much faster where r* jumps from side to side, as it does behind a reference that
// many boats have relayed. Hence 0.97 and the limited growth, which keep the boat itself within
// r_max. Both limits apply over ground; through the water ν* differs by the current. A slot with
// |w_S| > u_max or |r_S| > r_max is reported as too fast. At a limit the derivative is 0, and
// v* follows from the limited u*, r*.
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

/// controller_step() alone sets the held u* and r*, once they are final.
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
  Limits limits = 0;  ///< kSpeedLimit, kYawRateLimit
};

/// Advances v* by the h seconds since the previous step, over which u* and r* were constant.
template <class S>
void virtual_sway_forward(const Vessel<S>& vessel, VirtualVelocityState<S>& state, S h) {
  const S decay = exp(-vessel.d22_m22 * h);
  state.v_star = decay * state.v_star -  // (eq:mas-constraint)
                 vessel.m11_d22 * (S(1) - decay) * state.u_star_held * state.r_star_held;
}

/// Limits a desired velocity to ±most (0: no limit) and sets its derivative to 0 where it does so;
/// returns whether it did.
template <class S>
bool keep_within(S most, S& desired, S& desired_dot) {
  if (!(S(0) < most && most < abs(desired))) return false;
  desired = clamp(desired, -most, most);
  desired_dot = S(0);
  return true;
}

/// v, no longer than most; 0: no limit.
template <class S>
Vec2<S> shortened(const Vec2<S>& v, S most) {
  const S speed = hypot(v.x, v.y);
  if (!(S(0) < most && most < speed)) return v;
  return {scaled(v.x, most, speed), scaled(v.y, most, speed)};
}

/// The limit of r*; 0: none.
template <class S>
S r_star_max(S r_max) {
  return S(0.97) * r_max;
}

/// Speed and yaw rate that the slot needs beyond the boat's limits, m/s and rad/s; 0 where within.
template <class S>
struct TooFast {
  S u{};
  S r{};
};

template <class S>
TooFast<S> too_fast(const VirtualVelocityParams<S>& params, const Slot<S>& slot) {
  const bool u = S(0) < params.u_max && is_longer(Vec2<S>{slot.nu.u, slot.nu.v}, params.u_max);
  const bool r = S(0) < params.r_max && params.r_max < abs(slot.nu.r);
  return {u ? hypot(slot.nu.u, slot.nu.v) : S(0), r ? abs(slot.nu.r) : S(0)};
}

/// u* before its limit.
template <class S>
S desired_surge(const VirtualVelocityParams<S>& params, const Slot<S>& slot,
                const FormationError<S>& error) {
  return slot.nu.u - params.k_x * error.e.x;  // (eq:49a)
}

template <class S>
VirtualVelocity<S> virtual_velocity(const VirtualVelocityParams<S>& params,
                                    const VirtualVelocityState<S>& state, const Slot<S>& slot,
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
  if (keep_within(params.u_max, out.nu_star.u, out.u_star_dot)) out.limits |= kSpeedLimit;
  if (keep_within(r_star_max(params.r_max), out.nu_star.r, out.r_star_dot)) {
    out.limits |= kYawRateLimit;
  }
  return out;
}

/// Limits the growth of |r*| above r_max / 4; |r*| may fall at once. h: s since the previous step,
/// 0 in the first, which may have any r*.
template <class S>
void limit_growth(const VirtualVelocityParams<S>& params, const VirtualVelocityState<S>& state, S h,
                  VirtualVelocity<S>& desired) {
  if (!(S(0) < params.r_max && S(0) < h)) return;
  const S grown = S(3) * params.r_max * h, free = S(0.25) * params.r_max;
  const S low = min(state.r_star_held - grown, -free);
  const S high = max(state.r_star_held + grown, free);
  S& r_star = desired.nu_star.r;
  if (r_star < low || high < r_star) desired.r_star_dot = S(0);
  r_star = clamp(r_star, low, high);
}

}  // namespace flotilla::core
