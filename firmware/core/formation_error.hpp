// SPDX-License-Identifier: MIT
// The boat's offset from its slot in the formation, in its own axes.
//
//   [e_x e_y]ᵀ = R(ψ)ᵀ ( p − p_L − d )                  e_ψ = wrap(ψ − ψ_S)
//   ė_x =  r e_y + u − u_S cos e_ψ − v_S sin e_ψ
//   ė_y = −r e_x + v + u_S sin e_ψ − v_S cos e_ψ         ė_ψ = r − r_S
//
//  symbol      meaning                                frame  unit      tested range
//  separation  p − p_L, own minus leader's position   n      m         ±1000
//  d           slot, relative to the leader           n      m         ±1000
//  psi, psi_S  headings, own and the slot's           n      rad       ±π
//  nu, nu_S    velocities                             body   m/s, rad/s
//
// Source: paper (eq:formation-error), (eq:error-kinematics-formation), where the slot's heading and
// velocity are the leader's. Not in paper: the wrap.
//
// Q16.16: tested within ±200 (separation, m)
#pragma once

#include "core/slot.hpp"

namespace flotilla::core {

template <class S>
struct FormationError {
  Error<S> e{};
  Error<S> e_dot{};
  Rotation<S> R{};    ///< R(ψ)
  Rotation<S> R_e{};  ///< R(e_ψ)
};

template <class S>
FormationError<S> formation_error(const ControllerInput<S>& in, const Slot<S>& slot) {
  const Vec2<S> from_slot = {in.separation_n.x - slot.d_n.x, in.separation_n.y - slot.d_n.y};
  const Rotation<S> R = rotation(in.psi);
  const Vec2<S> e_b = to_body(R, from_slot);
  const S e_psi = wrap_pi(in.psi - slot.psi);
  const Rotation<S> R_e = rotation(e_psi);
  const Vec2<S> v_S = to_body(R_e, Vec2<S>{slot.nu.u, slot.nu.v});
  return {{e_b.x, e_b.y, e_psi},
          {in.nu.r * e_b.y + in.nu.u - v_S.x,  // :a
           in.nu.v - in.nu.r * e_b.x - v_S.y,  // :b
           in.nu.r - slot.nu.r},               // :c
          R,
          R_e};
}

}  // namespace flotilla::core
