// SPDX-License-Identifier: MIT
// The formation law: own and leader's motion in, two thrusts out.
//
// Source: B. Wang, A. Loría, Leader-Follower Formation and Tracking Control of Underactuated
// Surface Vessels, (eq:formation-error) … (eq:mas-underactuated-control).
#pragma once

#include "core/allocation.hpp"
#include "core/pd_plus.hpp"

namespace flotilla::core {

template <class S>
struct ControllerParams {
  Vec2<S> d{};  ///< slot, seen from the leader, north-east, m
  VirtualVelocityParams<S> outer{};
  PdPlusParams<S> inner{};
  Vessel<S> vessel{};
  AllocationParams<S> propellers{};
};

template <class S>
struct ControllerState {
  VirtualVelocityState<S> outer{};
};

template <class S>
struct ControllerOutput {
  FormationError<S> error{};
  VirtualVelocity<S> wanted{};
  Tau<S> tau{};
  Allocation<S> allocation{};
};

/// v*(0) = v_L(0): call when FORMATION is entered and when the leader changes.
template <class S>
ControllerState<S> controller_start(const Encounter<S>& in) {
  ControllerState<S> state;
  state.outer.v_star = in.nu_L.v;
  return state;
}

/// One control step; dt: time since the step before, s, 0 in the first.
template <class S>
ControllerOutput<S> controller_step(const ControllerParams<S>& params, ControllerState<S>& state,
                                    const Encounter<S>& in, S dt) {
  ControllerOutput<S> out;
  out.error = formation_error(in, params.d);
  virtual_sway_forward(params.vessel, state.outer, dt);
  out.wanted = virtual_velocity(params.outer, state.outer, in, out.error);
  out.tau = pd_plus(params.inner, params.vessel, out.wanted, in.nu);
  out.allocation = allocate(params.propellers, out.tau);
  return out;
}

}  // namespace flotilla::core
