// SPDX-License-Identifier: MIT
// The boat's own motion: from its navigation unit, and from the thrust given between its messages.
#pragma once

#include <cstdint>

#include "app/guidance/response_monitor.hpp"
#include "app/guidance/unit_latency.hpp"
#include "app/navigation/vessel_track.hpp"
#include "core/estimation/observer.hpp"
#include "core/supervisor.hpp"

namespace flotilla::app {

template <class S>
class OwnMotion {
 public:
  OwnMotion(std::uint8_t system, std::uint8_t component);

  /// Applies changed parameters and the own system id. lag_s: NAV_LAG_S, if it names one.
  void configure(const convert::Law<S>& law, std::optional<float> lag_s, std::uint8_t own_system);

  /// The navigation unit's states.
  VesselTrack<S>& track() { return track_; }
  const VesselTrack<S>& track() const { return track_; }
  const UnitLatency& latency() const { return latency_; }

  /// Predicts the motion over `since`, s, under the wrench given, and corrects it by a new fix. A
  /// disarmed boat may be carried about, so it is tracked like a leader.
  void observe(const convert::Law<S>& law, const core::Tau<S>& given, S since, bool armed,
               std::int64_t now_us);

  /// The velocity that the law desires; and it begins anew.
  void desire(const core::Nu<S>& nu_star) { response_.desire(nu_star); }
  void begin() { response_.reset(); }

  /// Motion since the anchor, a position of the last message; the current and unknown forces.
  const convert::Position& anchor() const { return anchor_; }
  const core::Motion<S>& motion() const { return observer_.motion; }
  const core::Observer<S>& observer() const { return observer_; }
  convert::Position place() const;

  /// The conditions that depend on the own state alone; states older than limit_us are not fresh.
  core::Conditions conditions(std::int64_t limit_us, std::int64_t now_us) const;

 private:
  void set_limits(const convert::Law<S>& law) {
    track_.set_limits(armed_ ? law.afloat : law.carried);
  }
  void carry(std::int64_t now_us);
  core::ObserverParams<S> careful(const core::ObserverParams<S>& params) const;

  VesselTrack<S> track_;
  core::Observer<S> observer_{};
  convert::Position anchor_;
  bool armed_ = false;
  UnitLatency latency_;
  ResponseMonitor<S> response_;
};

}  // namespace flotilla::app
