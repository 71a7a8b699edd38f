// SPDX-License-Identifier: MIT
// Where the boat is, seen from its slot in the formation, in its own axes.
//
//   [e_x e_y]ᵀ = R(ψ)ᵀ ( p − p_L − d )                  e_ψ = wrap(ψ − ψ_L)
//   ė_x =  r e_y + u − u_L cos e_ψ − v_L sin e_ψ
//   ė_y = −r e_x + v + u_L sin e_ψ − v_L cos e_ψ         ė_ψ = r − r_L
//
//  symbol      meaning                                frame  unit      tested range
//  separation  p − p_L, own minus leader's position   n      m         ±1000
//  d           slot, seen from the leader             n      m         ±100
//  psi, psi_L  headings                               n      rad       ±π
//  nu, nu_L    velocities                             body   m/s, rad/s
//
// Source: paper (eq:formation-error), (eq:error-kinematics-formation). Not in paper: the wrap.
#pragma once

#include "core/rotation.hpp"

namespace flotilla::core {

/// What the boat knows of itself and of its leader, at one instant.
template <class S>
struct Encounter {
  Vec2<S> separation_n{};
  S psi{};
  S psi_L{};
  Nu<S> nu{};
  Nu<S> nu_L{};
  Nu<S> nu_L_dot{};
};

template <class S>
struct FormationError {
  Error<S> e{};
  Error<S> e_dot{};
};

template <class S>
FormationError<S> formation_error(const Encounter<S>& in, const Vec2<S>& d) {
  const Vec2<S> from_slot = {in.separation_n.x - d.x, in.separation_n.y - d.y};
  const Vec2<S> e_b = to_body(in.psi, from_slot);
  const S e_psi = wrap_pi(in.psi - in.psi_L);
  const S c = cos(e_psi);
  const S s = sin(e_psi);
  return {{e_b.x, e_b.y, e_psi},
          {in.nu.r * e_b.y + in.nu.u - in.nu_L.u * c - in.nu_L.v * s,  // :a
           in.nu.v - in.nu.r * e_b.x + in.nu_L.u * s - in.nu_L.v * c,  // :b
           in.nu.r - in.nu_L.r}};                                      // :c
}

}  // namespace flotilla::core
