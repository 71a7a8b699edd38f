// SPDX-License-Identifier: MIT
// Motion of a vessel that is driven by velocities, made for a boat to follow: limited acceleration,
// yaw rate and yaw acceleration.
//
//   u ← u_d within u ± u̇_max h        r ← r_d within r ± ṙ_max h, |r| ≤ r_max
//   with a course:  r_d = ±min(r_max, √(2 · 0.9 ṙ_max |χ_d − ψ|)), so that it stops turning there
//   ψ ← ψ + r̄ h        p ← p + ū h [cos ψ̄  sin ψ̄]ᵀ        bars: means over the step
//
//  symbol  meaning                        frame  unit   tested range
//  u_d     desired speed ahead            body   m/s    0 … 5
//  r_d     desired yaw rate               body   rad/s  ±4
//  χ_d     desired course                 n      rad    ±π
//  h       control step                          s      0 … 0.2
//
// Not in paper, where the virtual leader's input is given.
//
// Q16.16: tested within ±1000 (p, m, since the vessel's place was last set)
#pragma once

#include <optional>

#include "core/route.hpp"

namespace flotilla::core {

template <class S>
struct Drive {
  S u{};
  S r{};
  std::optional<S> course{};  ///< if set, r is not used
};

/// Advances the vessel by h > 0 seconds; discards its route.
template <class S>
void drive_forward(const RouteParams<S>& params, const Drive<S>& desired, RouteState<S>& state,
                   S h) {
  Motion<S>& motion = state.motion;
  const Nu<S> before = motion.nu;
  S r = clamp(desired.r, -params.yaw_rate, params.yaw_rate);
  if (desired.course) {
    const S off = wrap_pi(*desired.course - motion.psi);
    const S most = min(params.yaw_rate, sqrt(S(1.8) * params.yaw_accel * abs(off)));
    r = off < S(0) ? -most : most;
  }
  const S du = params.accel * h, dr = params.yaw_accel * h;
  motion.nu.u = clamp(desired.u, before.u - du, before.u + du);
  motion.nu.r = clamp(r, before.r - dr, before.r + dr);
  const S turned = S(0.5) * (before.r + motion.nu.r) * h;
  const S ds = state.way_rest.take(S(0.5) * (before.u + motion.nu.u), h);
  const auto [s, c] = sin_cos(motion.psi + S(0.5) * turned);
  motion.moved_n = {motion.moved_n.x + state.north_rest.take(c, ds),
                    motion.moved_n.y + state.east_rest.take(s, ds)};
  motion.psi = wrap_pi(motion.psi + turned);
  motion.nu_dot = {(motion.nu.u - before.u) / h, S(0), (motion.nu.r - before.r) / h};
  state.phase = RoutePhase::kArrived;
}

}  // namespace flotilla::core
