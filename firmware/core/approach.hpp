// SPDX-License-Identifier: MIT
// The way to a slot that cannot be sailed along: it makes no way, or more than the boat may.
//
//   w = ŵ_S − k_x [e_s e_c]ᵀ        ŵ_S: [u_S v_S]ᵀ, no longer than u_max; nor is w
//   q = w − c                       the same through the water
//   θ = arg q, or arg q + π stern first       θ̇ = (q × q̇)/|q|²,  q̇ ≈ −k_x [ė_s ė_c]ᵀ
//   u* = n·ŵ_S − k_x e_x            n: the bow, in the slot's axes
//
//   begins where |q_s| < ε or |w_S| > u_max, and |q| > 1.5 k_x Δ
//   ends   where |q_s| > 1.5 ε and |w_S| < 0.95 u_max, or |q| < 0.3 k_x Δ
//
//  symbol    meaning                                           frame  unit   tested range
//  e_s, e_c  behind and beside the slot, along its heading     slot   m      ±1000
//  w_S, q_s  the slot's velocity, over ground; its pace               m/s    ±20
//  c         current                                           slot   m/s    ±2
//  Δ, ε      look-ahead, and speed under which there is no course     m, m/s  0: never; 0.15
//  θ         turn of the bow from the slot's heading                  rad    ±π
//
// Not in paper, where u* = u_S − k_x e_x: a boat abeam of a slot at rest would stay there. The bow or
// the stern points to the slot, whichever is the smaller turn; the other one only once it is smaller by
// 0.8 rad. Within 0.3 Δ the boat turns to its slot's heading again, and is left alone within 1.5 Δ. In a
// known current it stays bow or stern to that, the only way to stay. Behind a slot that is too fast
// it goes where that goes, and closes up.
//
// Q16.16: tested within ±2,000 (w, m/s)
#pragma once

#include "core/virtual_velocity.hpp"

namespace flotilla::core {

struct ApproachState {
  bool on = false;
  bool astern = false;
};

/// Where the boat is to go, in the slot's axes.
template <class S>
struct SlotWay {
  Vec2<S> slot{};   ///< ŵ_S
  S slot_speed{};   ///< |w_S|
  Vec2<S> q{};
  Vec2<S> q_dot{};
};

/// A velocity no greater than most, 0: any.
template <class S>
Vec2<S> shortened(const Vec2<S>& v, S most) {
  const S speed = hypot(v.x, v.y);
  if (!(S(0) < most && most < speed)) return v;
  return {scaled(v.x, most, speed), scaled(v.y, most, speed)};
}

template <class S>
SlotWay<S> slot_way(const VirtualVelocityParams<S>& params, const Slot<S>& slot,
                    const FormationError<S>& error, const Nu<S>& nu, const Vec2<S>& c_b) {
  const auto [e, e_dot] = beside_slot(slot, error, nu);
  const Vec2<S> slot_w = {slot.nu.u, slot.nu.v};
  const Vec2<S> at_most = shortened(slot_w, params.u_max);
  const Vec2<S> w = shortened(
      Vec2<S>{at_most.x - params.k_x * e.x, at_most.y - params.k_x * e.y}, params.u_max);
  const Vec2<S> c = to_north_east(error.R_e, c_b);
  return {at_most,
          hypot(slot_w.x, slot_w.y),
          {w.x - c.x, w.y - c.y},
          {-params.k_x * e_dot.x, -params.k_x * e_dot.y}};
}

/// Whether the boat has to approach; near: k_x Δ.
template <class S>
bool approaches(const ApproachState& state, S near, S epsilon, S u_max, S pace,
                const SlotWay<S>& way) {
  const S speed = hypot(way.q.x, way.q.y);
  const bool rests = abs(pace) < (state.on ? S(1.5) * epsilon : epsilon);
  const bool runs = S(0) < u_max && (state.on ? S(0.95) * u_max : u_max) < way.slot_speed;
  return (rests || runs) && (state.on ? S(0.3) : S(1.5)) * near < speed;
}

/// θ and θ̇; the end of the boat that goes first is kept.
template <class S>
LineOfSight<S> sight_of_way(ApproachState& state, const SlotWay<S>& way) {
  const S pi = S(3.14159265358979323846);
  S theta = atan2(way.q.y, way.q.x);
  if (state.astern) theta = wrap_pi(theta + pi);
  if (S(0.5) * pi + S(0.4) < abs(theta)) {
    state.astern = !state.astern;
    theta = wrap_pi(theta + pi);
  }
  const S speed = hypot(way.q.x, way.q.y);
  const Vec2<S> n = {way.q.x / speed, way.q.y / speed};
  return {theta, (n.x * way.q_dot.y - n.y * way.q_dot.x) / speed, S(0)};
}

/// Where the boat has to approach: slot and sight as it is to sail them then.
template <class S>
void approach(const LineOfSightParams<S>& params, const VirtualVelocityParams<S>& outer,
              ApproachState& state, const SlotWay<S>& way, Slot<S>& slot,
              const FormationError<S>& error, LineOfSight<S>& sight) {
  const S near = outer.k_x * params.Delta;
  if (!(S(0) < near && approaches(state, near, params.epsilon, outer.u_max, slot.pace, way))) {
    state = {};
    return;
  }
  state.on = true;
  sight = sight_of_way(state, way);
  slot.nu.u = to_body(error.R_e, way.slot).x;
  slot.nu_dot.u = S(0);
}

}  // namespace flotilla::core
