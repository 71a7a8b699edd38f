// SPDX-License-Identifier: MIT
// Whether the boat moves as its propellers would have it: how much of the wrench that was given is
// seen in its momentum.
//
//   ŵ = (m11 (u − ū) / T + ⟨d11 u − m22 v r⟩) / X₀        the wrench seen, in units of X₀
//   g = ⟨X⟩ / X₀                                          the wrench given, as slow
//   d = μ (|m11 (u − ū) / T| + ⟨|d11 u| + |m22 v r|⟩) / X₀     as much the model may be wrong
//   P ← P + (h / (W + h)) (ŵ g + d |g| − P)     Q ← Q + (h / (W + h)) (g² − Q)
//   it does not answer where Q > 1, P < ε Q and ⟨X⟩ (⟨u*⟩ − ū) > |⟨X⟩| δ for a while; likewise in yaw
//
//  symbol    meaning                                            unit         tested range
//  X, N      wrench given                                       N, N m       ±1000
//  u, v, r   velocity over ground, as it is told                m/s, rad/s   ±20, ±4
//  ⟨·⟩, ū    means over the last T                              s            0.5
//  u*, r*    velocity that is wanted; δ: how near to it is as good    m/s, rad/s   0.15, 0.15
//  W         time over which it is judged                       s            1
//  X₀, N₀    a smaller wrench says nothing                      N, N m
//  μ         error of each of the model's parameters            1            0.5
//  ε         share of it that must be seen                      1
//  h         step                                               s            0 … 1
//
// Not in paper. It needs no derivative and no observer, which would take a propeller that gives
// nothing for an unknown force. Without disturbances P ≥ Q for every boat whose parameters are wrong
// by no more than μ; in yaw, where they are greater, less is asked for. A boat that has the velocity
// that is wanted does answer, whatever else acts: in a stream it takes thrust to stand still.
//
// Q16.16: tested within ±500 (wrench given, N)
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
  Nu<S> least{S(0.25), S(0), S(1.3)};  ///< the wrench that holds less against drag says nothing
  S least_share = S(0.01);             ///< nor does less of all that the propellers can give
  S mismatch = S(0.5);
  S surge = S(0.3);  ///< ε
  S yaw = S(0.1);
  S near = S(0.15);  ///< δ
};

/// One axis: means over T of velocity, of the wrench given and of that which the hull takes.
template <class S>
struct ThrustResponseAxis {
  S rate{};
  S desired{};
  S given{};
  S resisted{};
  S weight{};  ///< the same without regard to signs
  S P{};
  S Q{};
};

template <class S>
struct ThrustResponse {
  ThrustResponseAxis<S> surge{};
  ThrustResponseAxis<S> yaw{};
  S failing{};  ///< for how long it has not answered
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
  const S g = ratio_within(axis.given, in.least, S(100));
  const S w = ratio_within(seen, in.least, S(100));
  const S d = ratio_within(doubt, in.least, S(100));
  const S q = h / (params.W + h);
  axis.P = axis.P + q * (w * g + d * abs(g) - axis.P);
  axis.Q = axis.Q + q * (g * g - axis.Q);
}

template <class S>
bool fails(const ThrustResponseAxis<S>& axis, S share, S near) {
  const S lacking = axis.desired - axis.rate;
  const bool lacks = near < (axis.given < S(0) ? -lacking : lacking);
  return lacks && S(1) < axis.Q && axis.P < share * axis.Q;
}

/// The velocity was last told to be nu, and over the last h seconds the wrench was given, for the
/// sake of that wanted.
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
      ThrustResponseInput<S>{m.m11, nu.u, desired.u, m.d11 * nu.u, -m.m22 * nu.v * nu.r, given.X,
                             max(params.least.u * m.d11, most)},
      h);
  thrust_response_axis(
      params, state.yaw,
      ThrustResponseInput<S>{m.m33, nu.r, desired.r, m.d33 * nu.r, (m.m22 - m.m11) * nu.u * nu.v,
                             given.N, max(params.least.r * m.d33, propellers.a * most)},
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
