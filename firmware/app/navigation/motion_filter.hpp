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
  /// Off: each state is believed as it is.
  void set_smoothing(bool smooths) {
    smooths_ = smooths;
    track_.nu_dot = track_.nu_ddot = {};
  }
  bool smooths() const { return smooths_; }

  /// Takes a state, dt after the last one, 0 if no motion led to it; resumes: the last one came
  /// from another source.
  void take(const core::TrackMessage<S>& state, bool resumes) {
    const core::TrackParams<S> params{};
    if (resumes || !smooths_) {
      core::track_resume(params, track_, state);
    } else {
      core::track_update(params, track_, state);
    }
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
  bool smooths_ = true;
  core::TrackState<S> track_;
  std::optional<core::TrackMessage<S>> fix_;
};

}  // namespace flotilla::app
