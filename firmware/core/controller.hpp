// SPDX-License-Identifier: MIT
// The formation law: own and leader's motion in, two thrusts out.
//
// Source: B. Wang, A. Loría, Leader-Follower Formation and Tracking Control of Underactuated
// Surface Vessels, (eq:formation-error) … (eq:mas-underactuated-control). Not in paper, and without
// effect where their parameters are zero: a slot with its own course, or one that moves in the
// shape, line of sight, approach, limits of ν*, separation from other vessels, current, unknown
// wrench.
//
// Q16.16: tested within ±1,000 (wrench, N)
#pragma once

#include "core/allocation.hpp"
#include "core/approach.hpp"
#include "core/pd_plus.hpp"
#include "core/separation.hpp"

namespace flotilla::core {

template <class S>
struct ControllerParams {
  SlotParams<S> slot{};
  VirtualVelocityParams<S> outer{};
  PdPlusParams<S> inner{};
  Vessel<S> vessel{};
  AllocationParams<S> propellers{};
  LineOfSightParams<S> sight{};
  SeparationParams<S> separation{};
};

template <class S>
struct ControllerState {
  VirtualVelocityState<S> outer{};
  SlotState<S> slot{};
  ApproachState<S> approach{};
  SeparationState<S> separation{};
};

template <class S>
struct ControllerOutput {
  Slot<S> slot{};
  FormationError<S> error{};
  LineOfSight<S> sight{};
  TooFast<S> too_fast{};
  VirtualVelocity<S> desired{};
  Separation<S> separation{};
  Tau<S> tau{};
  Allocation<S> allocation{};
  bool astern = false;  ///< the slot goes astern, on the inside of a turn

  Limits limits() const { return desired.limits | allocation.limits; }
};

/// v*(0) = v_L(0): call when FORMATION is entered and when the leader changes.
template <class S>
ControllerState<S> controller_start(const ControllerInput<S>& in) {
  ControllerState<S> state;
  state.outer.v_star = sway_beside(in);
  state.slot = slot_start(in);
  return state;
}

/// The slot's motion that the boat must follow, and the bow's turn from the slot's heading.
template <class S>
struct Course {
  Slot<S> slot{};
  LineOfSight<S> sight{};
};

template <class S>
ApproachParams<S> approach_params(const ControllerParams<S>& params) {
  // ESCs do not turn their propellers below about 5 % of the full command. Force of two propellers
  // at that command:
  const S neutral = S(0.1);  // of one propeller's reverse maximum
  return {params.outer.k_x, params.sight.Delta, params.sight.epsilon, params.outer.u_max,
          neutral * params.propellers.R};
}

/// Follows the slot's path, or approaches the slot.
template <class S>
Course<S> course(const ControllerParams<S>& params, ApproachState<S>& state,
                 const ControllerInput<S>& in, const Slot<S>& slot,
                 const FormationError<S>& error) {
  const Vec2<S> c_b = to_body(error.R, in.current_n);
  const ApproachParams<S> approach = approach_params(params);
  const bool unsailed = cannot_be_sailed(approach, slot, state.on);
  const bool at_rest = rests(approach, slot, state.on);
  const bool far = is_longer(Vec2<S>{error.e.x, error.e.y}, S(3) * params.sight.Delta);
  if (unsailed || at_rest || far) {
    const Vec2<S> drift_b = pushed(approach, c_b, to_body(error.R, state.push_n));
    const SlotWay<S> way = slot_way(approach, slot, error, in.nu, drift_b);
    if (lies_astern(approach, slot, way, state.on) ||
        (unsailed && is_off(approach, way, state.on)) || lies_abeam(approach, way, state.on)) {
      state.on = true;
      Slot<S> sailed = slot;
      sailed.nu.u = to_body(error.R_e, way.slot).x;
      sailed.nu_dot.u = S(0);
      return {sailed,
              sight_of_way(approach, state, way, error.e.psi, slot.nu.r, unsailed || at_rest)};
    }
  }
  state.on = state.astern = state.waits = false;
  Slot<S> sailed = slot;
  // While a boat still turns to its slot's course, it moves with the slot as far as its heading
  // allows.
  if (params.slot.moves) {
    sailed.nu.u = to_body(error.R_e, Vec2<S>{slot.nu.u, slot.nu.v}).x;
    sailed.nu_dot.u = error.R_e.c * slot.nu_dot.u;
  }
  const S U = smaller_of_same_sign(slot.pace, desired_surge(params.outer, sailed, error) - c_b.x);
  return {sailed, line_of_sight(params.sight, in.nu, slot, error, U)};
}

/// ν* through the water, as PD+ and v* need it; c_b: current in the boat's axes.
template <class S>
VirtualVelocity<S> through_water(VirtualVelocity<S> desired, const Vec2<S>& c_b, S r) {
  desired.nu_star.u = desired.nu_star.u - c_b.x;
  desired.u_star_dot = desired.u_star_dot - r * c_b.y;
  return desired;
}

/// Input of the separation: the boat, its slot's velocity, and the way to the slot.
template <class S>
SeparationInput<S> separation_input(const ControllerParams<S>& params, const Traffic<S>& traffic,
                                    const Slot<S>& slot, const FormationError<S>& error,
                                    const Nu<S>& nu, S dt) {
  const Vec2<S> v = to_north_east(slot.psi, Vec2<S>{slot.nu.u, slot.nu.v});
  const Vec2<S> off = to_north_east(error.R, Vec2<S>{-error.e.x, -error.e.y});
  return {traffic,
          error.R,
          nu,
          params.propellers.R / params.vessel.m11,
          S(2) * params.propellers.a * params.propellers.R / params.vessel.m33,
          intent_of(params.outer, params.separation, v, off),
          dt};
}

/// One control step; dt: s since the previous step, 0 in the first; traffic: nullptr if there are
/// no other vessels to keep apart from.
template <class S>
ControllerOutput<S> controller_step(const ControllerParams<S>& params, ControllerState<S>& state,
                                    const ControllerInput<S>& in, S dt,
                                    const Traffic<S>* traffic = nullptr) {
  const Slot<S> slot = slot_forward(params.slot, params.vessel, state.slot, in, dt);
  const FormationError<S> error = formation_error(in, slot);
  const Vec2<S> c_b = to_body(error.R, in.current_n);
  push_forward(approach_params(params), params.vessel, state.approach, in, slot, dt);
  const auto [sailed, sight] = course(params, state.approach, in, slot, error);
  virtual_sway_forward(params.vessel, state.outer, dt);
  VirtualVelocity<S> desired = virtual_velocity(params.outer, state.outer, sailed, error, sight);
  Separation<S> separation{};
  if (traffic == nullptr || traffic->count == 0) {
    state.separation = {};
  } else {
    separation = separate(params.separation, state.separation,
                          separation_input(params, *traffic, slot, error, in.nu, dt), desired);
  }
  if (!state.separation.yielding) limit_growth(params.outer, state.outer, dt, desired);
  const VirtualVelocity<S> desired_w = through_water(desired, c_b, in.nu.r);
  state.outer.u_star_held = desired_w.nu_star.u;  // through the water, as v* is
  state.outer.r_star_held = desired_w.nu_star.r;
  const Tau<S> needed = pd_plus(params.inner, params.vessel, desired_w,
                                Nu<S>{in.nu.u - c_b.x, in.nu.v - c_b.y, in.nu.r});
  const Tau<S> tau = {needed.X - in.unknown.X, needed.N - in.unknown.N};
  return {slot,
          error,
          sight,
          too_fast(params.outer, slot),
          desired,
          separation,
          tau,
          allocate(params.propellers, tau),
          goes_astern(params.slot, in, slot)};
}

}  // namespace flotilla::core
