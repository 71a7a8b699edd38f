// SPDX-License-Identifier: MIT
// Estimates the latency of a navigation unit whose clock is unknown, from the yaw response to the
// applied moment.
//
//   each hypothesis τ_i = i h of the latency has a Kalman filter of x = [r  b  γ]ᵀ at the fixes:
//   ṙ = γ n(t − τ_i) − δ r + b     ḃ, γ̇ = white     z = r + white     n = N/m33, δ = d33/m33
//   J_i ← λ J_i + (z − r̂)² / (P_rr + R)             normalized squared innovations
//   τ̂: vertex of the parabola at the least J_i and its neighbours; A = J_{i−1} − 2 J_i + J_{i+1}
//   known where A > A_min J / Σλ and J_none − J_i > D_min J / Σλ, J = max(J_i, J_min Σλ):
//   σ_τ = h √(2 J / (A Σλ)) < h √(2 / A_min)
//
//  symbol  meaning                                     frame  unit         tested range
//  r, z    yaw rate, its measurement in a fix                 rad/s        ±4
//  n       applied moment over inertia                        rad/s²       ±100
//  b       unknown moment over inertia                        rad/s²
//  γ       effective share of the applied moment                           0.2 … 3
//  age     age of the fix without the latency                 s            0 … 0.5
//  dt      time since the previous fix                        s            0 … 0.5
//
// Not in paper. Position, heading and velocity with the same latency are consistent with each
// other; only the delay after the applied thrust reveals it. A constant moment, straight ahead or
// at rest, reveals nothing. The law's response to noise excites enough; no turn is made for it.
// Propeller lag counts as latency, and predicting over it does no harm. Each filter estimates γ and
// b, so that a model error of one half does not look like latency.
#pragma once

#include <Eigen/Core>

#include "core/scalar/scalar.hpp"

namespace flotilla::core {

template <class S>
struct LatencyParams {
  S d{};  ///< δ
  S h = S(0.05);
  S step = S(0.061);  ///< longest step of the integration, s
  S R = S(0.0001);
  S q_r = S(0.01), q_b = S(0.3), q_gamma = S(0.0001);
  S memory = S(60);  ///< of λ = 1 − dt/memory, s
  S gamma_min = S(0.2);
  S A_min = S(60);
  S D_min = S(60);
  S J_min = S(0.1);  ///< floor of J / Σλ, for the model's error
};

template <class S>
struct Latency {
  static constexpr int kHypotheses = 11;  ///< 0 … 0.5 s
  static constexpr int kLength = 128;
  static constexpr S kBin = S(0.01);  ///< s
  struct Hypothesis {
    Eigen::Matrix<S, 3, 1> x{S(0), S(0), S(1)};
    Eigen::Matrix<S, 3, 3> P = Eigen::Matrix<S, 3, 1>{S(0.1), S(0.1), S(0.25)}.asDiagonal();
    S J{};
  };
  Hypothesis hypotheses[kHypotheses];
  Hypothesis none = unmoved();  ///< the boat does not respond to moments, γ = 0
  S impulse[kLength]{};         ///< ∫n dt of the last bins, a ring buffer
  int last = 0;                 ///< the bin being filled
  S filled{};                   ///< time in that bin, s
  S weight{};                   ///< Σλ

  static Hypothesis unmoved() {
    Hypothesis one;
    one.x(2) = S(0);
    one.P(2, 2) = S(0);
    return one;
  }
};

/// Not known where it is unobservable, as in a boat that hardly responds to its moments.
template <class S>
struct Late {
  S tau{};
  bool known = false;
};

/// Records the moment over inertia applied for `time`, s.
template <class S>
void latency_forward(Latency<S>& state, S n, S time) {
  while (S(0) < time) {
    const S part = min(time, state.kBin - state.filled);
    state.impulse[state.last] = state.impulse[state.last] + part * n;
    state.filled = state.filled + part;
    time = time - part;
    if (state.filled < state.kBin) continue;
    state.last = (state.last + 1) % Latency<S>::kLength;
    state.impulse[state.last] = state.filled = S(0);
  }
}

/// ∫n dt from `from` ago to `to` ago.
template <class S>
S latency_impulse(const Latency<S>& state, S from, S to) {
  constexpr int n = Latency<S>::kLength;
  constexpr S bin = Latency<S>::kBin;
  int back = to < state.filled ? 0 : 1 + static_cast<int>((to - state.filled) / bin);
  S end = back == 0 ? S(0) : state.filled + S(back - 1) * bin;
  S length = back == 0 ? state.filled : bin;
  S sum = S(0);
  for (bool first = true; back < n && end < from; ++back, first = false) {
    const S begin = end + length;
    const S all = state.impulse[(state.last + n - back) % n];
    const bool whole = !(first && end < to) && !(from < begin);
    sum = sum + (whole ? all : (min(begin, from) - max(end, to)) / length * all);
    end = begin;
    length = bin;
  }
  return sum;
}

/// Integration from one fix to the next, in `count` steps of h.
template <class S>
struct LatencySteps {
  int count;
  S h;
  S kept_r;                      ///< share of the yaw rate left by one step's damping
  S kept_n;                      ///< share of the step's change of it left
  S of_b;                        ///< change of the yaw rate by b in one step
  Eigen::Matrix<S, 3, 1> noise;  ///< variance of x that all steps add
};
template <class S>
LatencySteps<S> latency_steps(const LatencyParams<S>& params, S dt) {
  const int count = 1 + static_cast<int>(dt / params.step);
  const S h = dt / S(count);
  const S half = S(0.5) * h * params.d;
  const S kept_n = S(1) / (S(1) + half);
  return {count,
          h,
          (S(1) - half) / (S(1) + half),
          kept_n,
          kept_n * h,
          S(count) * h * Eigen::Matrix<S, 3, 1>{params.q_r, params.q_b, params.q_gamma}};
}

/// Predicts one hypothesis to `to` seconds ago and corrects it by the measured yaw rate z.
template <class S>
void hypothesis_correct(const LatencyParams<S>& params, const Latency<S>& state,
                        const LatencySteps<S>& steps, typename Latency<S>::Hypothesis& one, S to,
                        S z, S kept) {
  const auto& [count, h, kept_r, kept_n, of_b, noise] = steps;
  Eigen::Matrix<S, 1, 3> F{S(1), S(0), S(0)};  // first row; the others are the identity's
  for (int left = count; left > 0; --left) {
    const S end = to + S(left - 1) * h;
    const S of_gamma = kept_n * latency_impulse(state, end + h, end);
    one.x(0) = kept_r * one.x(0) + (of_b * one.x(1) + of_gamma * one.x(2));
    F = left == count
            ? Eigen::Matrix<S, 1, 3>{kept_r, of_b, of_gamma}
            : Eigen::Matrix<S, 1, 3>{kept_r * F(0), kept_r * F(1) + of_b, kept_r * F(2) + of_gamma};
  }
  const Eigen::Matrix<S, 1, 3> r = F * one.P;
  one.P.row(0) = r;
  one.P.col(0) = r.transpose();
  one.P(0, 0) = r.dot(F);
  one.P.diagonal() += noise;
  const S off = z - one.x(0);
  const S share = S(1) / (one.P(0, 0) + params.R);
  const Eigen::Matrix<S, 3, 1> gain = share * one.P.col(0);
  one.J = kept * one.J + share * off * off;
  one.x += gain * off;
  one.x(2) = clamp(one.x(2), params.gamma_min, S(3));
  const Eigen::Matrix<S, 1, 3> row = one.P.row(0);
  one.P -= gain * row;
}

/// Corrects all hypotheses by a fix with the yaw rate z.
template <class S>
void latency_correct(const LatencyParams<S>& params, Latency<S>& state, S z, S age, S dt) {
  const S kept = S(1) - dt / params.memory;
  LatencySteps<S> steps = latency_steps(params, dt);
  state.weight = kept * state.weight + S(1);
  S tau = S(0);
  for (auto& one : state.hypotheses) {
    hypothesis_correct(params, state, steps, one, age + tau, z, kept);
    tau = tau + params.h;
  }
  steps.noise(2) = S(0);
  LatencyParams<S> still = params;
  still.gamma_min = S(0);
  hypothesis_correct(still, state, steps, state.none, age, z, kept);
}

template <class S>
Late<S> latency_of(const LatencyParams<S>& params, const Latency<S>& state) {
  constexpr int n = Latency<S>::kHypotheses;
  int best = 0;
  for (int i = 1; i < n; ++i) {
    if (state.hypotheses[i].J < state.hypotheses[best].J) best = i;
  }
  const auto J = [&](int i) { return state.hypotheses[i].J; };
  const S before = best > 0 ? J(best - 1) : J(1);
  const S after = best + 1 < n ? J(best + 1) : J(n - 2);
  const S bend = before - S(2) * J(best) + after;
  const S off = best == 0 || best + 1 == n ? S(0) : S(0.5) * (before - after) / bend;
  const S scale = max(J(best), params.J_min * state.weight);
  const bool answers = params.D_min * scale < (state.none.J - J(best)) * state.weight;
  return {params.h * (S(best) + off), answers && params.A_min * scale < bend * state.weight};
}

}  // namespace flotilla::core
