// SPDX-License-Identifier: MIT
// Filters one vessel's motion from its states, and keeps the last state as a fix for other filters.
#pragma once

#include <optional>
#include <utility>

#include "core/estimation/track.hpp"

namespace flotilla::app {

template <class S>
class MotionFilter {
 public:
  /// Off: each state replaces the estimate unfiltered.
  void set_smoothing(bool smooths) {
    smooths_ = smooths;
    track_.nu_dot = track_.nu_ddot = {};
  }
  bool smooths() const { return smooths_; }

  /// On: the filter takes at most one state in 45 ms; those between replace the estimate
  /// unfiltered. There are no fixes.
  void stand_by(bool on) {
    if (std::exchange(stands_by_, on) != on) begin_decimation();
  }

  /// Takes a state; its dt is the time since the last one, or 0 if no motion led to it. resumes:
  /// the last one came from another source.
  void take(const core::TrackMessage<S>& state, bool resumes) {
    if (stands_by_ && !resumes && S(0) < state.dt) {
      take_seldom(state);
      return;
    }
    const core::TrackParams<S> params{};
    if (resumes || !smooths_) {
      core::track_resume(params, track_, state);
    } else {
      core::track_update(params, track_, state);
    }
    if (stands_by_) begin_decimation();
    // Of several states between two ticks the last one counts, with dt over all of them.
    const bool led = track_.dt > S(0) && (!fix_ || fix_->dt > S(0));
    const S since = led ? track_.dt + (fix_ ? fix_->dt : S(0)) : S(0);
    fix_ = core::TrackMessage<S>{state.psi, state.nu, since};
  }

  /// No motion leads to the next state.
  void forget() { track_ = {}; }

  const core::TrackState<S>& track() const { return track_; }
  std::optional<core::TrackMessage<S>> take_fix() { return std::exchange(fix_, std::nullopt); }

 private:
  void begin_decimation() {
    filtered_ = track_;
    since_ = S(0);
  }

  void take_seldom(const core::TrackMessage<S>& state) {
    since_ = since_ + state.dt;
    if (since_ < S(0.045)) {
      track_.psi = state.psi;
      track_.nu = state.nu;
      return;
    }
    core::track_update(core::TrackParams<S>{}, filtered_, {state.psi, state.nu, since_});
    track_ = filtered_;
    since_ = S(0);
  }

  bool smooths_ = true, stands_by_ = false;
  core::TrackState<S> track_;
  core::TrackState<S> filtered_;  // last output of the filter, kept in stand-by
  S since_{};                     // since the state of filtered_
  std::optional<core::TrackMessage<S>> fix_;
};

}  // namespace flotilla::app
