// SPDX-License-Identifier: MIT
// Runs the control law behind another vessel, and smooths a change to a different vessel.
#pragma once

#include <cstdint>

#include "app/estimation/own_motion.hpp"
#include "app/guidance/tree_place.hpp"
#include "core/coast.hpp"
#include "core/reference.hpp"
#include "core/station.hpp"

namespace flotilla::app {

/// The vessel that the law follows: the leader, or the formation's root in its place.
template <class S>
struct Lead {
  std::uint8_t leader = 0;
  Branch branch{};  ///< 0, 0: the leader itself
  convert::Position position;
  core::Motion<S> motion;
  core::Vec2<S> offset_n{};  ///< fixed north-east part of the slot; `slot` holds the rest
  core::SlotParams<S> slot;
  S root_psi{};  ///< the root's heading; `motion` has the slot's own while the slot moves
};

template <class S>
core::ControllerInput<S> controller_input(const Lead<S>& lead, const OwnMotion<S>& own,
                                          const core::Vessel<S>& vessel);

template <class S>
class SlotFollower {
 public:
  /// Call on entering a state, except on return from COAST: resets the law to the leader's present
  /// state.
  void start() {
    starting_ = true;
    station_ = {};
  }

  /// Call when the vessel that the boat follows starts elsewhere. The time for which the boat has
  /// spun continues.
  void restart() {
    starting_ = true;
    core::station_moved(station_);
  }

  /// Call on return from COAST to FORMATION: the leader may have come back somewhere else.
  void close_anew() { station_ = {}; }

  /// Follows `next` from now on, dt after the last step, s.
  void follow(const convert::Law<S>& law, const OwnMotion<S>& own, const Lead<S>& next, S dt);

  /// Advances the timer of shift() by dt; true if shift() is due. Call in every step.
  bool advance_shift_timer(S dt);

  /// Shifts the slot slowly by the leader's offset e_L from its own slot, m, north-east.
  void shift(const core::Vec2<S>& e_L);

  /// One step of the law, whose slot is lead().slot; traffic: nullptr to ignore other vessels.
  core::ControllerOutput<S> step(const convert::Law<S>& law, const OwnMotion<S>& own,
                                 const core::Traffic<S>* traffic, S dt);

  /// In COAST: extrapolates the vessel that is followed.
  void coast(S coast_s, S dt);

  /// Judges whether the boat keeps its station. error: from the slot, as the leader last reported.
  void judge(const convert::Law<S>& law, const core::ControllerOutput<S>& out,
             const core::FormationError<S>& error, S r, S dt);

  const Lead<S>& lead() const { return lead_; }

  /// Distance from the slot in the last step.
  S off() const { return core::hypot(error_.e.x, error_.e.y); }
  core::StationLoss station_loss() const { return station_.loss; }
  bool in_slot() const { return station_.in; }

 private:
  Lead<S> lead_;  // of the last step
  bool starting_ = false;
  core::ControllerState<S> state_{};
  core::StationState<S> station_{};
  core::CoastState<S> coast_{};      // of lead_.motion
  core::FormationError<S> error_{};  // of the last step
  core::Vec2<S> shift_n_{};          // of the slot, towards the leader's actual position
  S shift_s_{};                      // since shift_n_ was updated
  core::Blend<S> blend_{};           // fades out the step from a change of lead
};

}  // namespace flotilla::app
