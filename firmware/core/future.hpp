// SPDX-License-Identifier: MIT
// A root on a plan sends its predicted surge and yaw rate, every half second of it; receivers
// extrapolate an old reference along them.
//
//   u(t) = u_k + (u_(k+1) − u_k)(t − k T)/T, r(t) likewise      T = 0.5 s, constant after the last
//   ψ(t) = ψ_r + ∫ r        p(t) = p_r + ∫ R(ψ) [u v_r]ᵀ        from the reference's own time t_r on
//   u(t_r) = u_r, r(t_r) = r_r: the step between reference and future is spread to the next k T
//   |u_r − u(t_r)| > 0.1 m/s or |r_r − r(t_r)| > 0.06 rad/s: the root deviates from the future
//
//  symbol   meaning                                        unit         tested range
//  u_k r_k  sent, counted from the future's own time       m/s, rad/s   ±20, ±4
//  t_r      the reference's time, from the future's        s            −12 … 12
//
// Not in paper, whose agents know only the present motion of their leaders.
//
// Q16.16: tested within ±480 (p, m)
#pragma once

#include <array>
#include <cstddef>

#include "core/reference.hpp"

namespace flotilla::core {

inline constexpr std::size_t kFutureSamples = 24;  ///< after the first

template <class S>
struct Future {
  std::array<S, kFutureSamples + 1> u{}, r{};
};

/// The root's motion on its way along a future. `next`: sample ahead; t: from the future's time.
template <class S>
struct FutureWalk {
  Motion<S> motion{};
  std::size_t next = 0;
  S t{};
};

/// u(t) and r(t).
template <class S>
Nu<S> future_at(const Future<S>& future, S t) {
  std::size_t k = 0;
  while (k < kFutureSamples && !(t < S(0.5) * S(static_cast<int>(k + 1)))) ++k;
  if (k == kFutureSamples) return {future.u[k], S(0), future.r[k]};
  const S share = S(2) * max(t, S(0)) - S(static_cast<int>(k));
  return {future.u[k] + share * (future.u[k + 1] - future.u[k]), S(0),
          future.r[k] + share * (future.r[k + 1] - future.r[k])};
}

template <class S>
bool future_holds(const Future<S>& future, const Nu<S>& nu, S t_r) {
  const Nu<S> told = future_at(future, t_r);
  return t_r < S(0) || (abs(told.u - nu.u) < S(0.1) && abs(told.r - nu.r) < S(0.06));
}

template <class S>
FutureWalk<S> future_start(const ReferenceMotion<S>& at, S t_r) {
  FutureWalk<S> walk{{{}, at.psi, at.nu, {}}, 0, t_r};
  // Skips a sample so near that the velocity would jump to it.
  while (walk.next <= kFutureSamples && S(0.5) * S(static_cast<int>(walk.next)) < t_r + S(0.05)) {
    ++walk.next;
  }
  return walk;
}

/// The motion h seconds after the walk's time, towards the next sample.
template <class S>
Motion<S> future_motion(const Future<S>& future, const FutureWalk<S>& walk, S h) {
  const Motion<S>& from = walk.motion;
  ReferenceMotion<S> at{from.psi, from.nu, {}, S(0)};
  if (walk.next <= kFutureSamples) {
    const S left = S(0.5) * S(static_cast<int>(walk.next)) - walk.t;
    at.nu_dot = {(future.u[walk.next] - from.nu.u) / left, S(0),
                 (future.r[walk.next] - from.nu.r) / left};
  }
  Motion<S> to = reference_forward(ForesightLimits<S>{S(100), S(100)}, at, h);
  to.moved_n = {from.moved_n.x + to.moved_n.x, from.moved_n.y + to.moved_n.y};
  to.psi = wrap_pi(to.psi);
  return to;
}

/// Walks past all samples before t.
template <class S>
void future_forward(const Future<S>& future, FutureWalk<S>& walk, S t) {
  while (walk.next <= kFutureSamples) {
    const S until = S(0.5) * S(static_cast<int>(walk.next));
    if (t < until) return;
    walk.motion = future_motion(future, walk, until - walk.t);
    walk.t = until;
    ++walk.next;
  }
}

}  // namespace flotilla::core
