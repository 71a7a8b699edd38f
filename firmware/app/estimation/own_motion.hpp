// SPDX-License-Identifier: MIT
// The boat's own motion: from its navigation unit, and from the thrust given between its messages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "app/estimation/response_monitor.hpp"
#include "app/estimation/unit_latency.hpp"
#include "app/estimation/unit_quality.hpp"
#include "app/navigation/vessel_track.hpp"
#include "app/parameters/configuration.hpp"
#include "core/estimation/observer.hpp"
#include "core/supervisor.hpp"

namespace flotilla::app {

template <class S>
class OwnMotion {
 public:
  /// unit: NAV_COMPID.
  OwnMotion(std::uint8_t system, std::uint8_t component, std::uint8_t unit);

  /// Applies changed parameters and the boat's system id.
  void configure(const convert::Law<S>& law, const Configuration::Navigation& navigation,
                 std::uint8_t own_system);

  /// Takes any message. States of the boat itself are accepted only on NAV_LINK or, if that names
  /// no link, on the first link with a good state while disarmed, so that nobody can forge them by
  /// radio. After half a minute of silence, a disarmed boat accepts them on another link instead.
  void take(const link::Received& received, std::size_t link, std::int64_t now_us,
            link::Counters& counters);

  /// Whether messages of this link may come from the boat's own unit.
  bool may_be_own(std::size_t link, std::int64_t now_us) const;
  /// The boat's own unit is on a link other than this one.
  bool is_elsewhere(std::size_t link) const;

  /// The navigation unit's states.
  VesselTrack<S>& track() { return track_; }
  const VesselTrack<S>& track() const { return track_; }
  const UnitLatency& latency() const { return latency_; }
  /// States with the boat's id were ignored, because they may be another vessel's: they came on
  /// another link than the first ones, or the first ones came while the boat was armed.
  bool take_stranger() { return std::exchange(stranger_, false); }
  const UnitQuality& quality() const { return quality_; }
  /// The unit's last GPS_RAW_INT, unless it is two seconds old.
  std::optional<link::GpsRawInt> gps(std::int64_t now_us) const;

  /// Predicts the motion over `since`, s, under the wrench given, and corrects it by a new fix. A
  /// disarmed boat may be carried about, so it is tracked like a leader.
  void observe(const convert::Law<S>& law, const core::Tau<S>& given, S since, bool armed,
               std::int64_t now_us);

  /// Sets the velocity that the law desires; restarts the check of the response.
  void desire(const core::Nu<S>& nu_star) { response_.desire(nu_star); }
  void begin() { response_.reset(); }

  /// Motion since the anchor, a position of the last message; the current and unknown forces.
  const convert::Position& anchor() const { return anchor_; }
  const core::Motion<S>& motion() const { return observer_.motion; }
  const core::Observer<S>& observer() const { return observer_; }
  convert::Position place() const;

  /// The conditions that depend on the boat's state alone; a state older than limit_us is not
  /// fresh.
  core::Conditions conditions(std::int64_t limit_us, std::int64_t now_us) const;

 private:
  void set_limits(const convert::Law<S>& law) {
    track_.set_limits(armed_ ? law.afloat : law.carried);
  }
  void carry(std::int64_t now_us);
  void push_moment();
  bool update_latency(const core::TrackMessage<S>& fix, std::int64_t age_us);
  core::ObserverParams<S> adjusted_for_latency(const core::ObserverParams<S>& params) const;

  VesselTrack<S> track_;
  std::optional<std::uint8_t> named_link_, link_;  // NAV_LINK; the link that brings the states
  core::Observer<S> observer_{};
  convert::Position anchor_;
  bool armed_ = false;
  bool stranger_ = false;
  UnitLatency latency_;
  core::Impulse<S> moment_{};  // given since latency_ last took one
  S since_fix_{};              // since the fix that latency_ took last
  UnitQuality quality_;
  link::GpsRawInt gps_{};
  std::optional<std::int64_t> gps_us_;
  UnitQuality::Limits limits_;
  ResponseMonitor<S> response_;
};

}  // namespace flotilla::app
