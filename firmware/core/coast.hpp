// SPDX-License-Identifier: MIT
// COAST: dead-reckons a silent leader along its circle at decreasing speed, and limits the thrusts
// to those of the previous step.
//
//   f(t) = 1 − (t/T)², 0 after T    s = ∫ f dt = t − ⅓ t³/T², over a step
//   ψ_L ← ψ_L + r_0 s              p_L ← p_L + s R(ψ_L + r_0 s/2) [u_0 v_0]ᵀ
//   ν_L = f ν_0                    ν̇_L = −2 t/T² ν_0, 0 after T
//   d ← clamp(d, ±c)               m ← clamp(m, ±(c − |d|))          port = m + d, stbd = m − d
//
//  symbol   meaning                                         frame  unit       tested range
//  t, T     time in COAST, and its duration                        s          0 … 60
//  nu_0     leader's velocity when COAST began              body   m/s, rad/s ±20, ±4
//  c        larger |thrust| of the previous step                   N          0 … 50
//  m, d     mean of the thrusts, half their difference             N          ±50
//
// Not in paper: there the leader is always heard. f falls slowly at first, for short silences.
//
// Q16.16: tested within ±500 (the leader's way, propellers' thrusts)
#pragma once

#include "core/allocation.hpp"
#include "core/estimation/track.hpp"

namespace flotilla::core {

template <class S>
struct CoastState {
  Motion<S> leader{};
  Nu<S> nu_0{};
  S t{};
};

template <class S>
CoastState<S> coast_start(const Motion<S>& leader) {
  return {leader, leader.nu, S(0)};
}

/// Advances the leader by h seconds.
template <class S>
void coast_forward(S T, CoastState<S>& state, S h) {
  Motion<S>& leader = state.leader;
  const auto arc = [T](S x) { return T * x * (S(1) - S(0.33333333333333333) * x * x); };
  const S before = state.t / T;
  state.t = min(state.t + h, T);
  const S x = state.t / T;
  const S s = arc(x) - arc(before);
  const S turned = state.nu_0.r * s;
  const Vec2<S> way = {state.nu_0.u * s, state.nu_0.v * s};
  const Vec2<S> way_n = to_north_east(leader.psi + S(0.5) * turned, way);
  leader.moved_n = {leader.moved_n.x + way_n.x, leader.moved_n.y + way_n.y};
  leader.psi = wrap_pi(leader.psi + turned);
  leader.nu = plus(Nu<S>{}, S(1) - x * x, state.nu_0);
  leader.nu_dot = x < S(1) ? plus(Nu<S>{}, S(-2) * x / T, state.nu_0) : Nu<S>{};
}

/// Limits both thrusts to ±most; yaw has priority.
template <class S>
Thrust<S> limited(const Thrust<S>& asked, S most) {
  const S port = S(0.5) * asked.port;
  const S stbd = S(0.5) * asked.stbd;
  const S d = clamp(port - stbd, -most, most);
  const S rest = most - abs(d);
  const S m = clamp(port + stbd, -rest, rest);
  return {clamp(m + d, -most, most), clamp(m - d, -most, most)};
}

}  // namespace flotilla::core
