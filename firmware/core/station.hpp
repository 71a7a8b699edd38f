// SPDX-License-Identifier: MIT
// Whether a boat under the law keeps its station: it is in its slot or gets nearer to it.
//
//   in     |e| ≤ n, until |e| > 1.5 n                kept    in for 3 s, 15 s while the bow turns to
//                                                           the slot's heading; until it yields
//   b ← n while in, else the smallest |e| since, in steps of 0.1 m or more
//   b_y ← max(b_y, |e|) while it yields, else with b, and smaller in the same steps
//   t ← 0 while in or where b decreases, t − 0.5 s where b_y does, else t + w h,   w = 2 at a limit
//   left   kept and |e| > D for 1 s         spins   |r| > 1.2 r_max for 2 s, less 0.3 of the rest
//   stuck  t > max(60 s, 8π/r_max), ≤ 900 s  well    in and |r| ≤ r_max for 1 s; ends these three
//
//  symbol  meaning                                            unit     tested range
//  e       distance from the slot                             m        0 … 1000
//  D       FS_SLOT_M; 0: off                                  m        0.5 … 100
//  n       radius of the slot: D/5; max(D/5, 1.6 Δ) at rest   m
//  Δ       look-ahead, as in approach.hpp                     m
//  r_max   limit of the desired yaw rate; 0: none             rad/s    0 … 4
//  h       control step                                       s        0 … 1
//
// Not in paper. A boat that still closes up may be far away, so its progress is judged, not its
// distance. At a limit of speed, yaw rate or thrust it must make progress in half the time, which
// is enough for two whole turns. While it yields to another vessel, t stands still. After that it
// closes up from its present place: regaining the distance lost by yielding reduces t, but does not
// reset it.
//
// Q16.16: tested within ±1,000 (distance, m)
#pragma once

#include "core/scalar/scalar.hpp"

namespace flotilla::core {

template <class S>
struct StationParams {
  S D{};
  S Delta{};
  S r_max{};
  S leave_s = S(1);
  S keep_s = S(3);
  S spin_s = S(2);
  S stuck_s = S(60);
  S step = S(0.1);
  S regain_s = S(0.5);
};

/// Why a boat does not keep its station.
enum class StationLoss : unsigned char { kNo, kLeft, kSpins, kStuck };

template <class S>
struct StationState {
  StationLoss loss = StationLoss::kNo;
  bool in = false;
  bool kept = false;
  bool started = false;
  S nearest{};  ///< b
  S away{};     ///< b_y
  S in_s{}, far_s{}, spinning_s{}, idle_s{}, well_s{};
};

template <class S>
struct StationInput {
  S distance{};  ///< |e|
  S r{};
  bool limited = false;  ///< at a limit of speed, yaw rate or thrust
  bool yields = false;   ///< to another vessel
  bool at_rest = false;  ///< the slot is at rest
  bool turns = false;    ///< the slot makes way, and the bow is far from its heading
};

/// Counts h while `so`, up to 1000 s; otherwise resets.
template <class S>
void count_while(S& time, bool so, S h) {
  time = so ? min(time + h, S(1000)) : S(0);
}

template <class S>
void note_progress(const StationParams<S>& params, StationState<S>& state,
                   const StationInput<S>& in, S near, S h) {
  const bool nearer = in.distance < state.nearest - params.step;
  if (state.in || nearer || !state.started) {
    state.nearest = state.away = max(in.distance, near);
    if (state.started) state.idle_s = S(0);
    state.started = true;
  } else if (in.yields) {
    state.away = max(state.away, in.distance);
  } else if (in.distance < state.away - params.step) {
    state.away = in.distance;
    state.idle_s = max(state.idle_s - params.regain_s, S(0));
  } else {
    count_while(state.idle_s, true, in.limited ? S(2) * h : h);
  }
}

/// Call when the slot has another place: the boat closes up again. Its idle and spinning times
/// continue.
template <class S>
void station_moved(StationState<S>& state) {
  state.in = state.kept = state.started = false;
  state.in_s = state.far_s = S(0);
}

/// Advances by h seconds. The caller resets the state when FORMATION begins, and when the slot or
/// the leader changes.
template <class S>
void station_forward(const StationParams<S>& params, StationState<S>& state,
                     const StationInput<S>& in, S h) {
  if (!(S(0) < params.D)) {
    state = {};
    return;
  }
  const S slot = S(0.2) * params.D;
  const S near = in.at_rest ? max(slot, S(1.6) * params.Delta) : slot;
  state.in = in.distance <= (state.in ? S(1.5) * near : near);
  count_while(state.in_s, state.in, in.turns ? S(0.2) * h : h);
  state.kept = (state.kept || params.keep_s < state.in_s) && !in.yields;
  note_progress(params, state, in, near, h);
  count_while(state.far_s, state.kept && params.D < in.distance, h);
  const bool turns = S(0) < params.r_max && S(1.2) * params.r_max < abs(in.r);
  state.spinning_s =
      turns ? min(state.spinning_s + h, S(1000)) : max(state.spinning_s - S(0.3) * h, S(0));
  const bool calm = !(S(0) < params.r_max && params.r_max < abs(in.r));
  count_while(state.well_s, state.in && calm, h);
  if (state.loss != StationLoss::kNo) {
    if (S(1) < state.well_s) state.loss = StationLoss::kNo;
  } else if (params.leave_s < state.far_s) {
    state.loss = StationLoss::kLeft;
  } else if (params.spin_s < state.spinning_s) {
    state.loss = StationLoss::kSpins;
  } else if (params.stuck_s < state.idle_s) {
    state.loss = StationLoss::kStuck;
  }
}

}  // namespace flotilla::core
