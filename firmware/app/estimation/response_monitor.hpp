// SPDX-License-Identifier: MIT
// Whether the boat moves as the thrust given would move it.
#pragma once

#include <utility>

#include "core/controller.hpp"
#include "core/estimation/thrust_response.hpp"

namespace flotilla::app {

template <class S>
class ResponseMonitor {
 public:
  /// Restarts the check: the boat counts as responding until the opposite is observed.
  void reset() {
    state_ = {};
    answers_ = true;
  }
  bool answers() const { return answers_; }

  /// Velocity of a fix, and the velocity that the law desires.
  void take_fix(const core::Nu<S>& nu) { fix_ = nu; }
  void desire(const core::Nu<S>& nu_star) { desired_ = nu_star; }

  /// The wrench given for `since`, s. Averages over 50 ms: the thrust response takes half a second.
  /// held: the boat has never moved, so that it may be held in place; it gets 5 s, once.
  void push(const core::ControllerParams<S>& law, const core::Tau<S>& given, S since, bool held) {
    core::impulse_forward(impulse_, given, since);
    if (impulse_.time < S(0.05)) return;
    core::ThrustResponseParams<S> params{.vessel = law.vessel, .propellers = law.propellers};
    if (held && !waited_) params.patience = S(5);
    if (std::exchange(held_, held) && !held) state_.failing = S(0);
    core::thrust_response_forward(params, state_, fix_, std::exchange(desired_, fix_),
                                  {impulse_.sum.X / impulse_.time, impulse_.sum.N / impulse_.time},
                                  core::min(impulse_.time, S(1)));
    answers_ = core::answers(params, state_);
    waited_ = held && (waited_ || !answers_);
    impulse_ = {};
  }

 private:
  core::ThrustResponse<S> state_{};
  bool answers_ = true, held_ = true;
  bool waited_ = false;         // in vain, for a boat that may be held
  core::Impulse<S> impulse_{};  // since the last average
  core::Nu<S> fix_{};
  core::Nu<S> desired_{};  // without the law, the velocity of the last fix
};

}  // namespace flotilla::app
