// SPDX-License-Identifier: MIT
// The slot's position and motion, as those of a vessel that sails along the slot's path.
//
//   frame 0: d north and east of the leader          frame 1: d ahead and to starboard, turning
//   w = [u_L − r_L d_y  v_L + r_L d_x]               velocity of the slot, leader's axes (frame 1)
//   q = w − R(ψ_L)ᵀ c                                velocity through the water
//   q_s, n ← q_x, q_y − v_w                          smoothed, with their rates: two poles at ω_n
//   δ = atan( n q_s³ / (q_s² + ε²)² )                with the bow turned by δ, sway is v_w
//   ψ_S = ψ_L + δ      [u_S v_S]ᵀ = R(δ)ᵀ w      r_S = r_L + δ̇
//   m22 v̇_w = −m11 q_s r_S − d22 v_w                 sway of this boat on the slot's course
//
//  symbol       meaning                                    frame  unit        tested range
//  psi_L, nu_L  leader's heading, velocity                 n, body  rad, m/s, rad/s
//  d            slot, relative to the leader               n or leader's axes  m  ±1000
//  c            current                                    n      m/s         ±2
//  v_w          sway through the water                     body   m/s         ±20
//  ε            speed below which there is no course              m/s
//  ω_n          bandwidth: above any turns, below noise           rad/s
//
// Not in paper: there the slot does not turn with its leader, and has the leader's heading and
// velocity, which is right for equal hulls in still water. A boat's course and heading differ in a
// current, outside its leader's turn, and behind a leader with another hull. The noisy u̇_L and
// v̇_L enter δ̇ only through the smoothing; ṙ_S is ṙ_L.
//
// Q16.16: tested within ±500 (inertia, kg)
#pragma once

#include "core/rotation.hpp"
#include "core/scalar/carry.hpp"
#include "core/vessel.hpp"

namespace flotilla::core {

/// Estimates of the boat, its leader and the water at one instant.
template <class S>
struct ControllerInput {
  Vec2<S> separation_n{};  ///< p − p_L
  S psi{};
  S psi_L{};
  Nu<S> nu{};
  Nu<S> nu_L{};
  Nu<S> nu_L_dot{};
  Vec2<S> current_n{};
  Tau<S> unknown{};  ///< wrench that neither model nor propellers account for
};

template <class S>
struct SlotParams {
  Vec2<S> d{};
  bool turns = false;   ///< frame 1
  bool steers = false;  ///< the slot has its own course: in frame 1, or where a current is known
  bool moves = false;   ///< the slot moves in the shape: its course may be far from the boat's
  S epsilon = S(0.05);
  S omega_n = S(2);
};

/// A smoothed value and its rate of change.
template <class S>
struct Smooth {
  S value{};
  S rate{};
  Carry<S> value_rest{}, rate_rest{};
};

template <class S>
struct SlotState {
  S v_w{};
  Smooth<S> q_s{};
  Smooth<S> n{};
  bool started = false;
};

template <class S>
struct Slot {
  Vec2<S> d_n{};  ///< relative to the leader
  S psi{};
  Nu<S> nu{};
  Nu<S> nu_dot{};
  S pace{};  ///< q_s
};

/// A slot with its leader's heading and velocity.
template <class S>
Slot<S> slot_beside(const ControllerInput<S>& in, const Vec2<S>& d_n) {
  return {d_n, in.psi_L, in.nu_L, in.nu_L_dot, in.nu_L.u};
}

/// Velocity in the leader's axes: over ground, its rate of change, and through the water.
template <class S>
struct SlotVelocity {
  Vec2<S> w{};
  Vec2<S> w_dot{};
  Vec2<S> q{};
};

template <class S>
SlotVelocity<S> slot_velocity(const SlotParams<S>& params, const ControllerInput<S>& in,
                              const Rotation<S>& R_L) {
  const auto& [u, v, r] = in.nu_L;
  const auto& a = in.nu_L_dot;
  const Vec2<S> d = params.turns ? params.d : Vec2<S>{};
  const Vec2<S> c = to_body(R_L, in.current_n);
  const Vec2<S> w = {u - r * d.y, v + r * d.x};
  return {w, {a.u - a.r * d.y, a.v + a.r * d.x}, {w.x - c.x, w.y - c.y}};
}

/// Step and gains of a second-order tracker, which follows a ramp without lag.
template <class S>
struct Smoothing {
  S h{};
  S of_value{};  ///< gains
  S of_rate{};
};

template <class S>
Smoothing<S> smoothing(S omega, S h) {
  const S step = omega * h;
  const S gain = step / (S(1) + step * (S(2) + step));
  return {h, gain * (S(2) + step), omega * gain};
}

template <class S>
void smooth(const Smoothing<S>& by, Smooth<S>& state, S value) {
  const S off = value - state.value - by.h * state.rate;
  state.value = state.value + state.value_rest.take(by.h, state.rate);
  state.value = state.value + state.value_rest.take(by.of_value, off);
  state.rate = state.rate + state.rate_rest.take(by.of_rate, off);
}

/// δ and δ̇.
template <class S>
struct BowTurn {
  S angle{};
  S rate{};
};

template <class S>
BowTurn<S> bow_turn(const SlotParams<S>& params, const SlotState<S>& state) {
  const S q_s = state.q_s.value;
  const S qq = q_s * q_s;
  const S D = qq + params.epsilon * params.epsilon;
  const S share = qq / D;  // → 1 for |q_s| ≫ ε
  const S per_q = share * q_s / D;
  const S z = state.n.value * per_q;
  const S z_dot =
      state.n.rate * per_q + state.n.value * (S(3) - S(4) * share) * share / D * state.q_s.rate;
  return {atan(z), z_dot / (S(1) + z * z)};
}

/// The slot's motion; advances its state by the h seconds since the previous step.
template <class S>
Slot<S> slot_forward(const SlotParams<S>& params, const Vessel<S>& m, SlotState<S>& state,
                     const ControllerInput<S>& in, S h) {
  const Rotation<S> R_L = rotation(in.psi_L);
  Slot<S> slot = slot_beside(in, params.turns ? to_north_east(R_L, params.d) : params.d);
  const auto [w, w_dot, q] = slot_velocity(params, in, R_L);
  if (!state.started) {
    state.q_s.value = q.x;
    state.n.value = q.y - state.v_w;
    state.started = true;
  }
  const Smoothing<S> by = smoothing(params.omega_n, h);
  smooth(by, state.q_s, q.x);
  smooth(by, state.n, q.y - state.v_w);
  const S q_s = state.q_s.value;
  const auto [delta, delta_dot] = params.steers ? bow_turn(params, state) : BowTurn<S>{};
  slot.nu.r = in.nu_L.r + delta_dot;
  slot.pace = q_s;
  state.v_w = (state.v_w - h * m.m11_m22 * q_s * slot.nu.r) / (S(1) + h * m.d22_m22);
  if (!params.steers) return slot;
  const Rotation<S> turned = rotation(delta);
  const Vec2<S> nu = to_body(turned, w);
  const Vec2<S> nu_dot = to_body(turned, w_dot);
  slot.psi = in.psi_L + delta;
  slot.nu.u = nu.x;
  slot.nu.v = nu.y;
  slot.nu_dot = {nu_dot.x + delta_dot * nu.y, nu_dot.y - delta_dot * nu.x, in.nu_L_dot.r};
  return slot;
}

/// Whether the slot goes astern on the inside of its leader's turn, where no hull can follow.
template <class S>
bool goes_astern(const SlotParams<S>& params, const ControllerInput<S>& in, const Slot<S>& slot) {
  return params.turns && S(0) < in.nu_L.u && slot.nu.u < S(-0.05);
}

/// The leader's sway through the water: start value for a boat that has sailed beside the leader.
template <class S>
S sway_beside(const ControllerInput<S>& in) {
  return in.nu_L.v - to_body(in.psi_L, in.current_n).y;
}

template <class S>
SlotState<S> slot_start(const ControllerInput<S>& in) {
  SlotState<S> state;
  state.v_w = sway_beside(in);
  return state;
}

}  // namespace flotilla::core
