// SPDX-License-Identifier: MIT
// Detects a boat that does not respond to its propellers: how much of the wrench appears in its
// momentum.
//
//   ŵ = (m11 (u − ū) / T + ⟨d11 u − m22 v r⟩) / 2X₀        observed wrench, at most ±50
//   g = ⟨X⟩ / 2X₀                                          applied wrench, equally smoothed
//   d = μ (|m11 (u − ū) / T| + ⟨|d11 u| + |m22 v r|⟩) / 2X₀     uncertainty of the model
//   P ← P + (h / (W + h)) (ŵ g + d |g| − P)     Q ← Q + (h / (W + h)) (g² − Q)
//   no response where Q > ¼, P < ε Q and ⟨X⟩ (⟨u*⟩ − ū) > |⟨X⟩| δ for 0.75 s; likewise in yaw
//
//  symbol    meaning                                            unit         tested range
//  X, N      applied wrench                                     N, N m       ±1000
//  u, v, r   measured velocity over ground                      m/s, rad/s   ±20, ±4
//  ⟨·⟩, ū    means over the last T                              s            0.5
//  u*, r*    desired velocity; δ: tolerance of it               m/s, rad/s   0.15, 0.15
//  W         averaging time of P, Q                             s            1
//  X₀, N₀    smaller wrenches are not judged                    N, N m
//  μ         error of each of the model's parameters            1            0.5
//  ε         least share of the wrench to be observed           1
//  h         step                                               s            0 … 1
//
// Not in paper. It needs no derivative and no observer, which would take a dead propeller for an
// unknown force. Without disturbances P ≥ Q for every boat whose parameters are wrong by no more
// than μ; in yaw, where disturbances are greater, ε is smaller. A boat at its desired velocity
// counts as responding, because in a current it may need thrust to stand still.
//
// Q16.16: tested within ±8,000 (ŵ g + d |g| − P)
#pragma once

#include "core/allocation.hpp"
#include "core/vessel.hpp"

namespace flotilla::core {

template <class S>
struct ThrustResponseParams {
  Vessel<S> vessel{};
  AllocationParams<S> propellers{};
  S T = S(0.5);
  S W = S(1);
  S patience = S(0.75);
  Nu<S> least{S(0.25), S(0), S(1.3)};  ///< X₀, N₀: at least the drag at this velocity
  S least_share = S(0.01);             ///< and at least this share of the greatest wrench
  S mismatch = S(0.5);
  S surge = S(0.3);  ///< ε
  S yaw = S(0.1);
  S near = S(0.15);  ///< δ
};

/// One axis: means over T of the velocity, the applied wrench and the hull's resistance.
template <class S>
struct ThrustResponseAxis {
  S rate{};
  S desired{};
  S given{};
  S resisted{};
  S weight{};  ///< sum of the magnitudes of the resistance's terms
  S P{};
  S Q{};
};

template <class S>
struct ThrustResponse {
  ThrustResponseAxis<S> surge{};
  ThrustResponseAxis<S> yaw{};
  S failing{};  ///< time without response, s
  bool started = false;
};

template <class S>
struct ThrustResponseInput {
  S inertia{};
  S rate{};
  S desired{};
  S drag{};
  S coupling{};
  S given{};
  S least{};
};

template <class S>
void thrust_response_axis(const ThrustResponseParams<S>& params, ThrustResponseAxis<S>& axis,
                          const ThrustResponseInput<S>& in, S h) {
  const S p = h / (params.T + h);
  axis.rate = axis.rate + p * (in.rate - axis.rate);
  axis.desired = axis.desired + p * (in.desired - axis.desired);
  axis.given = axis.given + p * (in.given - axis.given);
  axis.resisted = axis.resisted + p * (in.drag + in.coupling - axis.resisted);
  axis.weight = axis.weight + p * (abs(in.drag) + abs(in.coupling) - axis.weight);
  const S momentum = in.inertia * (in.rate - axis.rate) / params.T;
  const S seen = momentum + axis.resisted;
  const S doubt = params.mismatch * (abs(momentum) + axis.weight);
  const S unit = S(2) * in.least, most = S(50);
  const S g = ratio_within(axis.given, unit, most);
  const S w = ratio_within(seen, unit, most);
  const S d = ratio_within(doubt, unit, most);
  const S q = h / (params.W + h);
  axis.P = axis.P + q * (w * g + d * abs(g) - axis.P);
  axis.Q = axis.Q + q * (g * g - axis.Q);
}

template <class S>
bool fails(const ThrustResponseAxis<S>& axis, S share, S near) {
  const S lacking = axis.desired - axis.rate;
  const bool lacks = near < (axis.given < S(0) ? -lacking : lacking);
  return lacks && S(0.25) < axis.Q && axis.P < share * axis.Q;
}

/// Advances by h seconds; nu: last measured velocity; given: wrench applied to reach `desired`.
template <class S>
void thrust_response_forward(const ThrustResponseParams<S>& params, ThrustResponse<S>& state,
                             const Nu<S>& nu, const Nu<S>& desired, const Tau<S>& given, S h) {
  const Vessel<S>& m = params.vessel;
  const AllocationParams<S>& propellers = params.propellers;
  if (!state.started) {
    state = ThrustResponse<S>{};
    state.surge.rate = nu.u;
    state.yaw.rate = nu.r;
    state.surge.desired = desired.u;
    state.yaw.desired = desired.r;
    state.started = true;
  }
  const S most = S(2) * params.least_share * max(propellers.F, propellers.R);
  thrust_response_axis(
      params, state.surge,
      ThrustResponseInput<S>{m.m11, nu.u, desired.u, surge_damping(m, nu.u) * nu.u,
                             -m.m22 * nu.v * nu.r, given.X, max(params.least.u * m.d11, most)},
      h);
  thrust_response_axis(params, state.yaw,
                       ThrustResponseInput<S>{m.m33, nu.r, desired.r, yaw_damping(m, nu.u) * nu.r,
                                              (m.m22 - m.m11) * nu.u * nu.v, given.N,
                                              max(params.least.r * m.d33, propellers.a * most)},
                       h);
  const bool fail =
      fails(state.surge, params.surge, params.near) || fails(state.yaw, params.yaw, params.near);
  state.failing = fail ? min(state.failing + h, S(10)) : S(0);
}

template <class S>
bool answers(const ThrustResponseParams<S>& params, const ThrustResponse<S>& state) {
  return state.failing < params.patience;
}

}  // namespace flotilla::core
