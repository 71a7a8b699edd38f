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
// at rest, reveals nothing. The law's response to noise gives enough excitation; the boat makes no
// extra turns. Propeller lag counts as latency; predicting over it does no harm. Each filter
// estimates γ and b, so that a model error of one half does not look like latency.
#pragma once

#include <Eigen/Core>

#include "core/estimation/latency_params.hpp"

namespace flotilla::core {

/// Filter i is element i of each array, so that processors compute several filters at once.
template <class S>
struct Latency {
  static constexpr int kHypotheses = 11;  ///< 0 … 0.5 s
  static constexpr int kLength = 64;
  static constexpr S kBin = S(0.02);  ///< s
  /// The last filter assumes that the boat does not respond, γ = 0.
  using Filters = Eigen::Array<S, kHypotheses + 1, 1>;
  struct {
    Filters r = all(S(0)), b = all(S(0)), gamma = responding(S(1));
  } x;
  struct {
    Filters rr = all(S(0.1)), rb = all(S(0)), rgamma = all(S(0));
    Filters bb = all(S(0.1)), bgamma = all(S(0)), gammagamma = responding(S(0.25));
  } P;  ///< symmetric
  Filters J = all(S(0));
  S impulse[kLength]{};  ///< ∫n dt of the last bins, a ring buffer
  int last = 0;          ///< the bin being filled
  S filled{};            ///< time in that bin, s
  S weight{};            ///< Σλ

  static Filters all(S number) { return Filters::Constant(number); }
  /// `number` for each latency, 0 for the boat that does not respond.
  static Filters responding(S number) {
    Filters numbers = all(number);
    numbers(kHypotheses) = S(0);
    return numbers;
  }
};

/// `known` is false while τ cannot be observed, as in a boat that hardly responds to its moments.
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
    const S all = state.impulse[static_cast<unsigned>(state.last + n - back) % n];
    const bool whole = !(first && end < to) && !(from < begin);
    sum = sum + (whole ? all : (min(begin, from) - max(end, to)) / length * all);
    end = begin;
    length = bin;
  }
  return sum;
}

/// Integrates all filters from the last fix, dt before, to this one.
template <class S>
void latency_predict(const LatencyParams<S>& params, Latency<S>& state, S age, S dt) {
  using Filters = typename Latency<S>::Filters;
  constexpr int n = Latency<S>::kHypotheses;
  auto& x = state.x;
  auto& P = state.P;

  // In `count` steps of h.
  const int count = 1 + static_cast<int>(dt / params.step);
  const S h = dt / S(count);
  const S half = S(0.5) * h * params.d;
  const S kept_n = S(1) / (S(1) + half);           // of a step's change of the yaw rate
  const S kept_r = (S(1) - half) / (S(1) + half);  // of the yaw rate
  const S of_b = kept_n * h;                       // change of the yaw rate by b
  S F_r = S(1), F_b = S(0);  // with F_gamma the first row of F; the others are the identity's
  Filters F_gamma = state.all(S(0));
  for (int left = count; left > 0; --left) {
    Filters of_gamma;
    S end = age + S(left - 1) * h;
    for (int i = 0; i < n; ++i, end = end + params.h) {
      of_gamma(i) = kept_n * latency_impulse(state, end + h, end);
    }
    of_gamma(n) = of_gamma(0);
    x.r = kept_r * x.r + (of_b * x.b + of_gamma * x.gamma);
    F_r = kept_r * F_r;
    F_b = kept_r * F_b + of_b;
    F_gamma = kept_r * F_gamma + of_gamma;
  }

  // P ← F P Fᵀ + Q
  const auto by_F = [&](const Filters& r, const Filters& b, const Filters& gamma) -> Filters {
    return F_r * r + (F_b * b + F_gamma * gamma);
  };
  const S time = S(count) * h;
  const Filters F_P = by_F(P.rr, P.rb, P.rgamma);
  P.rb = by_F(P.rb, P.bb, P.bgamma);
  P.rgamma = by_F(P.rgamma, P.bgamma, P.gammagamma);
  P.rr = by_F(F_P, P.rb, P.rgamma) + time * params.q_r;
  P.bb += time * params.q_b;
  P.gammagamma += state.responding(time * params.q_gamma);
}

/// Corrects all filters by a fix with the yaw rate z.
template <class S>
void latency_correct(const LatencyParams<S>& params, Latency<S>& state, S z, S age, S dt) {
  using Filters = typename Latency<S>::Filters;
  latency_predict(params, state, age, dt);
  auto& x = state.x;
  auto& P = state.P;
  const S kept = S(1) - dt / params.memory;
  state.weight = kept * state.weight + S(1);

  // x ← x + K (z − r̂), P ← P − K P_r, with the gain K = P_rᵀ / (P_rr + R)
  const Filters off = z - x.r;
  const Filters share = S(1) / (P.rr + params.R);
  const Filters K_r = share * P.rr, K_b = share * P.rb, K_gamma = share * P.rgamma;
  state.J = kept * state.J + share * off * off;
  x.r += K_r * off;
  x.b += K_b * off;
  x.gamma = (x.gamma + K_gamma * off).max(state.responding(params.gamma_min)).min(S(3));
  P.gammagamma -= K_gamma * P.rgamma;
  P.bgamma -= K_b * P.rgamma;
  P.bb -= K_b * P.rb;
  P.rgamma -= K_r * P.rgamma;
  P.rb -= K_r * P.rb;
  P.rr -= K_r * P.rr;
}

template <class S>
Late<S> latency_of(const LatencyParams<S>& params, const Latency<S>& state) {
  constexpr int n = Latency<S>::kHypotheses;
  const auto& J = state.J;
  int best = 0;
  J.template head<n>().minCoeff(&best);
  const S before = best > 0 ? J(best - 1) : J(1);
  const S after = best + 1 < n ? J(best + 1) : J(n - 2);
  const S bend = before - S(2) * J(best) + after;
  const S off = best == 0 || best + 1 == n ? S(0) : S(0.5) * (before - after) / bend;
  const S scale = max(J(best), params.J_min * state.weight);
  const bool answers = params.D_min * scale < (J(n) - J(best)) * state.weight;
  return {params.h * (S(best) + off), answers && params.A_min * scale < bend * state.weight};
}

}  // namespace flotilla::core
