// SPDX-License-Identifier: MIT
// Follows a slot that moves in the shape as a vessel on its own course, possibly opposite to the
// leader's.
//
//   frame 0: V = U + w            V̇ = U̇ + r × U + ẇ
//   frame 1: V = U + r × d + w    V̇ = U̇ + r × (U + r × d) + 2 r × w + ẇ      in the leader's axes
//   ψ = arg V      u = |V|      r = V × V̇ / |V|²      u̇ = V · V̇ / |V|
//
//  symbol       meaning                                              unit
//  U, r, U̇      leader's velocity, yaw rate, acceleration            m/s, rad/s, m/s²
//  d, w, ẇ      slot; its velocity and acceleration in the shape     m, m/s, m/s²
//
// While the slot moves, k_x and k_ψ are doubled and the look-ahead is halved. The usual gains suit
// the noise and delay behind a slot that rests in the shape. Behind a moving slot, a boat of 1.2 m
// with these gains took 7 s to turn about, fell behind its slot, and closed up slowly.
//
// Before the slot reverses (V · V_s < 0, where V_s is its velocity in kTurnAhead_s) the boat turns
// to V_s: a boat that turned only with its slot would fall behind.
//
// Not in paper, where slots rest in the shape. The leader's ṙ is left out.
#pragma once

#include "app/guidance/slot_follower.hpp"
#include "core/rotation.hpp"

namespace flotilla::app {

/// w_soon: w in kTurnAhead_s. All three are in the slot's axes.
template <class S>
Lead<S> on_own_course(Lead<S> lead, core::Vec2<S> w, core::Vec2<S> w_dot, core::Vec2<S> w_soon) {
  const auto [u, v, r] = lead.motion.nu;
  const auto [u_dot, v_dot, r_dot] = lead.motion.nu_dot;
  const S psi_L = lead.motion.psi;
  const core::Rotation<S> R = core::rotation(psi_L);
  core::Vec2<S> swept{u, v};
  if (lead.slot.turns) {
    const core::Vec2<S> d = lead.slot.d, d_n = core::to_north_east(R, d);
    swept = {u - r * d.y, v + r * d.x};
    w_dot = {w_dot.x - S(2) * r * w.y, w_dot.y + S(2) * r * w.x};
    lead.offset_n = {lead.offset_n.x + d_n.x, lead.offset_n.y + d_n.y};
    lead.slot.d = {};
    lead.slot.turns = false;
  } else {
    w = core::to_body(R, w);
    w_dot = core::to_body(R, w_dot);
    w_soon = core::to_body(R, w_soon);
  }
  const core::Vec2<S> V{swept.x + w.x, swept.y + w.y};
  const core::Vec2<S> V_dot{u_dot - r * swept.y + w_dot.x, v_dot + r * swept.x + w_dot.y};
  const S speed = core::hypot(V.x, V.y);
  const S q = core::max(speed, S(0.2));  // below this its course is ill-defined
  lead.motion.psi = core::wrap_pi(psi_L + core::atan2(V.y, V.x));
  lead.motion.nu = {speed, S(0), (V.x * V_dot.y - V.y * V_dot.x) / (q * q)};
  lead.motion.nu_dot = {(V.x * V_dot.x + V.y * V_dot.y) / q, S(0), S(0)};
  const core::Vec2<S> V_soon{swept.x + w_soon.x, swept.y + w_soon.y};
  const S speed_soon = core::hypot(V_soon.x, V_soon.y);
  if (V.x * V_soon.x + V.y * V_soon.y < S(0) && S(0.1) < speed_soon) {
    lead.motion.psi = core::wrap_pi(psi_L + core::atan2(V_soon.y, V_soon.x));
    lead.motion.nu = {speed_soon, S(0), S(0)};
    lead.motion.nu_dot = {};
  }
  lead.slot.moves = true;
  return lead;
}

/// Doubles the gains and halves the look-ahead, for a slot that moves.
template <class S>
void hasten(core::VirtualVelocityParams<S>& gains, core::LineOfSightParams<S>& sight) {
  gains.k_x = S(2) * gains.k_x;
  gains.k_psi = S(2) * gains.k_psi;
  sight.Delta = S(0.5) * sight.Delta;
}

}  // namespace flotilla::app
