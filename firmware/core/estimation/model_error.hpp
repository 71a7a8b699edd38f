// SPDX-License-Identifier: MIT
// Estimates, over minutes, errors of the boat's model: drag, yaw damping, and the difference
// between its propellers.
//
//   over each block of T seconds, bars: means, Δ: changes
//   y_u = m11 Δu_w/T − X̄ − m22 v̄_w r + D̄_u u = −δ D̄_u u − β N̄/a  + [F_n F_e] [cos̄ψ sin̄ψ]ᵀ
//   y_r = m33 Δr/T − N̄ + (m22 − m11) ū_w v_w + D̄_r r = −γ D̄_r r − β a X̄ + [G_n G_e] [cos̄ψ sin̄ψ]ᵀ
//   each is a Kalman filter of x = [δ β F_n F_e]ᵀ, [γ β G_n G_e]ᵀ, nearly constant:
//   P ← P + Q T      k = P φ / (R + φᵀ P φ)     x ← x + k (y − φᵀ x)     P ← P − k φᵀ P
//   R = V (1 + ρ) / (1 − ρ)      V, ρ: variance of the residuals and their correlation in turn
//   β of both: means by 1/σ², σ² = 1 / (1/σ_u² + 1/σ_r²) + w_u w_r (β_u − β_r)²
//
//  symbol     meaning                                                   unit       tested range
//  u_w, v_w   velocity through the water, its estimate                  m/s        ±20
//  X, N       wrench of the commands as sent                            N, N m     ±1000
//  D_u, D_r   damping at that speed: d11 + d11q |u|, d33 + d33u |u|     kg/s, kg m²/s
//  δ, γ       share by which drag, yaw damping exceed the model's       1          −0.9 … 3
//  β          share by which the starboard propeller is stronger than
//             its model, and the port one weaker                        1          ±0.5
//  F, G       what wind, waves and an unknown current do               N, N m
//  T          length of a block                                         s          5
//
// Not in paper. The law's observer finds the sum of all unmodelled forces at once; this filter
// finds their persistent causes. A wind keeps its direction over ground, so F and G turn in the
// boat's axes, while δ, γ and β do not: on one course, or in one steady turn, they are not
// observable separately, and P stays large. Gusts are correlated from block to block: ρ reduces
// their weight. y and φ are divided by the damping at 1 m/s or 1 rad/s, so that hulls of any size
// have the same P, Q and R.
#pragma once

#include <Eigen/Core>

#include "core/scalar/scalar.hpp"
#include "core/types.hpp"

namespace flotilla::core {

template <class S>
struct ModelErrorParams {
  S m11{}, m22{}, m33{};
  S d11{}, d33{}, d11q{}, d33u{};
  S a{};      ///< half the distance between the propellers, m
  S r_max{};  ///< blocks with faster turns are skipped: damping is not linear there; 0: no limit
  S T = S(5);
  S least_V = S(0.00004);
  int memory = 24;  ///< averaging length of V and ρ, blocks
};

template <class S>
struct ModelErrorAxis {
  Eigen::Matrix<S, 4, 1> x = Eigen::Matrix<S, 4, 1>::Zero();
  Eigen::Matrix<S, 4, 4> P = Eigen::Matrix<S, 4, 1>{S(1), S(0.0625), S(0.09), S(0.09)}.asDiagonal();
  S V = S(0.0025);
  S C{};  ///< ρ V
  S last{};
  int count = 5;  ///< blocks of V and C
};

/// Integrals over the block so far, and the velocities at its beginning.
template <class S>
struct ModelErrorBlock {
  bool begun = false;
  S time{};
  Tau<S> given{};
  S drag{}, damping{}, coupled_X{}, coupled_N{}, cos{}, sin{}, turned{};
  S first_u{}, first_r{};
};

template <class S>
struct ModelError {
  ModelErrorAxis<S> surge{}, yaw{};
  ModelErrorBlock<S> block{};
  int blocks = 0;
};

/// A share, and its variance.
template <class S>
struct Share {
  S value{};
  S variance{};
};

/// The impulse given in the last step, and the motion at its end in water that moves with c_n.
template <class S>
struct ModelErrorInput {
  Tau<S> impulse{};
  Nu<S> nu{};
  SinCos<S> heading{};
  Vec2<S> c_n{};
};

/// Corrects one axis by its equation: `y` and the row φ.
template <class S>
void model_error_correct(const ModelErrorParams<S>& params, ModelErrorAxis<S>& axis, S y,
                         const Eigen::Matrix<S, 4, 1>& phi) {
  // Drag and damping may change by 14 % in an hour, all else by 5 %.
  const S V = max(axis.V, params.least_V);
  const S rho = clamp(axis.C / V, S(0), S(0.9));
  const S R = V * (S(1) + rho) / (S(1) - rho);
  // Loops over the coefficients: a third of the flash of Eigen's products, at one block in 5 s.
  Eigen::Matrix<S, 4, 1> P_phi;
  S variance = R, off = y;
  for (int i = 0; i < 4; ++i) {
    axis.P(i, i) = axis.P(i, i) + params.T * (i == 0 ? S(0.0000055) : S(0.0000007));
    P_phi(i) = S(0);
    for (int j = 0; j < 4; ++j) P_phi(i) = P_phi(i) + axis.P(i, j) * phi(j);
    variance = variance + phi(i) * P_phi(i);
    off = off - phi(i) * axis.x(i);
  }
  const S share = S(1) / variance;
  for (int i = 0; i < 4; ++i) {
    const S k = share * P_phi(i);
    axis.x(i) = axis.x(i) + off * k;
    for (int j = 0; j < 4; ++j) axis.P(i, j) = axis.P(i, j) - k * P_phi(j);
  }
  const S left = R * share * off;
  if (axis.count < params.memory) ++axis.count;
  const S weight = S(1) / S(axis.count);
  axis.V = axis.V + weight * (left * left - axis.V);
  axis.C = axis.C + weight * (left * axis.last - axis.C);
  axis.last = left;
}

/// Uses a block that ends with velocities u, r through the water.
template <class S>
void model_error_end(const ModelErrorParams<S>& params, ModelError<S>& state, S u, S r) {
  const ModelErrorBlock<S>& sum = state.block;
  const S X_1 = params.d11 + params.d11q, N_1 = params.d33 + params.d33u;
  const S X = S(1) / (sum.time * X_1), N = S(1) / (sum.time * N_1);
  const S c = sum.cos / sum.time, s = sum.sin / sum.time;
  ++state.blocks;
  model_error_correct(params, state.surge,
                      X * (params.m11 * (u - sum.first_u) - sum.given.X - sum.coupled_X + sum.drag),
                      Eigen::Matrix<S, 4, 1>{-X * sum.drag, -X * sum.given.N / params.a, c, s});
  model_error_correct(
      params, state.yaw,
      N * (params.m33 * (r - sum.first_r) - sum.given.N + sum.coupled_N + sum.damping),
      Eigen::Matrix<S, 4, 1>{-N * sum.damping, -N * params.a * sum.given.X, c, s});
}

/// A step of h seconds. True at the end of a block that is used.
template <class S>
bool model_error_forward(const ModelErrorParams<S>& params, ModelError<S>& state,
                         const ModelErrorInput<S>& in, S h) {
  ModelErrorBlock<S>& sum = state.block;
  const auto& [sin_psi, cos_psi] = in.heading;
  const S u = in.nu.u - (cos_psi * in.c_n.x + sin_psi * in.c_n.y);
  const S v = in.nu.v - (cos_psi * in.c_n.y - sin_psi * in.c_n.x);
  const S r = in.nu.r;
  bool used = false;
  if (sum.begun) {
    sum.time = sum.time + h;
    sum.given = {sum.given.X + in.impulse.X, sum.given.N + in.impulse.N};
    sum.drag = sum.drag + h * (params.d11 + params.d11q * abs(u)) * u;
    sum.damping = sum.damping + h * (params.d33 + params.d33u * abs(u)) * r;
    sum.coupled_X = sum.coupled_X + h * params.m22 * v * r;
    sum.coupled_N = sum.coupled_N + h * (params.m22 - params.m11) * u * v;
    sum.cos = sum.cos + h * cos_psi;
    sum.sin = sum.sin + h * sin_psi;
    sum.turned = sum.turned + h * r;
    if (sum.time < params.T) return false;
    used = !(S(0) < params.r_max) || abs(sum.turned) < params.r_max * sum.time;
    if (used) model_error_end(params, state, u, r);
  }
  sum = {};
  sum.begun = true;
  sum.first_u = u;
  sum.first_r = r;
  return used;
}

/// Discards the current block: the boat was held, or its motion unknown.
template <class S>
void model_error_interrupt(ModelError<S>& state) {
  state.block = {};
}

template <class S>
Share<S> share_of(const ModelErrorAxis<S>& axis, int i) {
  return {axis.x(i), axis.P(i, i)};
}

template <class S>
Share<S> drag_error(const ModelError<S>& state) {
  return share_of(state.surge, 0);
}
template <class S>
Share<S> yaw_damping_error(const ModelError<S>& state) {
  return share_of(state.yaw, 0);
}

/// β, from both equations.
template <class S>
Share<S> balance_error(const ModelError<S>& state) {
  const S P_u = state.surge.P(1, 1), P_r = state.yaw.P(1, 1);
  const S w_u = P_r / (P_u + P_r), w_r = S(1) - w_u;
  const S apart = state.surge.x(1) - state.yaw.x(1);
  return {w_u * state.surge.x(1) + w_r * state.yaw.x(1), w_u * P_u + w_u * w_r * apart * apart};
}

/// Removes from the estimates the corrections that the model has received: β, δ.
template <class S>
void model_error_applied(ModelError<S>& state, S beta, S delta) {
  state.surge.x(1) = state.surge.x(1) - beta;
  state.yaw.x(1) = state.yaw.x(1) - beta;
  state.surge.x(0) = (state.surge.x(0) - delta) / (S(1) + delta);
}

}  // namespace flotilla::core
