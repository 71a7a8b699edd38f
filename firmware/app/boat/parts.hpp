// SPDX-License-Identifier: MIT
// Read-only references to a boat's parts, for its conditions, reports and snapshots.
#pragma once

#include "app/boat/conditions.hpp"
#include "app/estimation/model_monitor.hpp"
#include "app/operator/host_report.hpp"
#include "app/operator/vehicle.hpp"
#include "app/propulsion/thrusters.hpp"

namespace flotilla::app {

template <class S>
struct Parts {
  const Vehicle& vehicle;
  const Supervisor& supervisor;
  const Guidance<S>& guidance;
  const ModelMonitor& learnt;
  const FailsafeLimits& limits;
  const FenceWatch& fence_watch;
  const CanNode& can;
  const HostReport& host;
  const core::Conditions& met;  ///< conditions of this tick
  const core::ControllerOutput<S>& law;
  const typename Thrusters<S>::Output& thrust;
  const link::Counters& counters;

  core::State state() const { return supervisor.state(); }
  const Configuration& configuration() const { return vehicle.configuration(); }

  /// The states of the boat and of its leader are fresh.
  bool seen() const {
    constexpr core::Conditions kSeen = core::kOwnFresh | core::kLeaderFresh;
    return (met & kSeen) == kSeen;
  }
  /// The boat is in FORMATION, or sails alone: in AUTO, GUIDED, LOITER or RTL.
  bool keeps_slot() const {
    return state() == core::State::kFormation || core::sails_alone(state());
  }
};

}  // namespace flotilla::app
