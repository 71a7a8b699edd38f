// SPDX-License-Identifier: MIT
// Tracks the boat and its leader, estimates the forces on the boat, and runs the control law.
#pragma once

#include <cstdint>
#include <optional>

#include "app/convert/convert_telemetry.hpp"
#include "app/guidance/reference.hpp"
#include "app/guidance/slot_claims.hpp"
#include "app/navigation/neighbours.hpp"
#include "app/navigation/time_requests.hpp"
#include "app/navigation/vessel_track.hpp"
#include "core/coast.hpp"
#include "core/estimation/latency.hpp"
#include "core/estimation/thrust_response.hpp"
#include "core/station.hpp"
#include "core/supervisor.hpp"

namespace flotilla::app {

/// Estimated disturbances, SI units.
struct Estimates {
  core::Tau<double> unknown;     ///< wrench that neither model nor propellers account for
  core::Vec2<double> current_n;  ///< of the water
};

template <class S>
class Pilot {
 public:
  explicit Pilot(const Parameters& p);

  /// Applies changed parameters and the own system id.
  void configure(const Parameters& p, std::uint8_t own_system);

  /// Takes any message; ignores those of unrelated vessels.
  void take(const link::Received& received, std::size_t link, std::int64_t now_us,
            link::Counters& counters);

  /// Whoever sends TIMESYNC requests asks here; the answers are messages to take().
  TimeRequests& time_requests() { return time_; }

  /// The conditions that depend on states: fresh, plausible, near each other, clear of other
  /// vessels. sails: the law drives.
  core::Conditions conditions(std::int64_t now_us, const Parameters& p, bool sails) const;

  /// Predicts the own motion over `since`, s, under the wrench given, and corrects it by a new fix.
  /// A disarmed boat may be carried about, so it is tracked like a leader.
  void observe(std::int64_t now_us, S since, const core::Tau<S>& given, bool armed);

  /// Enters FORMATION from a mode other than COAST: resets the law to the leader's present state.
  void start(std::int64_t now_us);

  /// Returns from COAST to FORMATION: the leader may have come back somewhere else.
  void close_anew() { station_ = {}; }

  /// One step of the law, dt after the last one, s.
  core::ControllerOutput<S> step(std::int64_t now_us, S dt);

  /// The same in COAST, behind the extrapolated leader of the last step(); possible while the own
  /// position relative to it is known.
  core::ControllerOutput<S> coast(std::int64_t now_us, S dt);
  bool can_coast() const;

  /// Whether the boat under the law keeps its slot, and is in it, since FORMATION was entered or
  /// the slot or leader changed.
  core::Astray astray() const { return station_.astray; }
  bool in_slot() const { return station_.in; }
  S yaw_rate() const { return motion_.motion.nu.r; }

  /// Other claims to the own slot.
  const SlotClaims& claims() const { return claims_; }

  /// The boat's error from its slot, without a step of the law.
  core::ControllerOutput<S> look(std::int64_t now_us) const;

  const core::ControllerParams<S>& law() const { return law_; }
  Estimates estimates() const;

  /// The own state at the current whole millisecond.
  convert::OwnState own_state(std::int64_t now_us) const;
  bool located() const { return own_.has_origin(); }
  const link::GpsGlobalOrigin& origin() const { return anchor_.origin; }
  convert::Position place() const;

  /// Depth in the tree, to be sent; nothing if FS_SEP_M is 0.
  std::optional<double> depth() const;

  /// The reference for followers; followed: the law drives.
  std::optional<link::FormationReference> reference(std::int64_t now_us, bool followed) const {
    return reference_.message(now_us, followed);
  }
  std::uint32_t reference_news() const { return reference_.news(); }
  const TreePlace& tree_place() const { return reference_.place(); }
  std::optional<double> reference_age_s(std::int64_t now_us) const;

  /// Estimated latency of the navigation unit beyond NAV_LAG_S; nothing before it is known, or if
  /// TIMESYNC bounds it.
  std::optional<double> latency_s() const;

  /// Nothing where TIMESYNC does not tell it and no latency is known.
  std::optional<double> own_age_s(std::int64_t now_us) const;
  std::optional<double> leader_age_s(std::int64_t now_us) const;
  std::optional<double> leader_uncertainty_m(std::int64_t now_us) const {
    return leader_.uncertainty_m(now_us);
  }

  /// An ODOMETRY in a frame without north was refused since the last call.
  bool take_frame_complaint() {
    const bool own = own_.take_frame_complaint(), leader = leader_.take_frame_complaint();
    return own || leader;
  }

 private:
  /// The vessel that the law follows: the leader, or the formation's root in its place.
  struct Lead {
    std::uint8_t leader = 0;
    Branch branch{};  ///< 0, 0: the leader itself
    convert::Position position;
    core::Motion<S> motion;
    core::Vec2<S> offset_n{};  ///< fixed north-east part of the slot; `slot` holds the rest
    core::SlotParams<S> slot;
  };

  Lead lead(std::int64_t now_us) const;
  core::ControllerInput<S> controller_input(const Lead& lead) const;
  void follow(const Lead& next, S dt);
  static bool same_slot(const Lead& a, const Lead& b);
  void shift_slot(std::int64_t now_us, S dt);
  core::ControllerOutput<S> step_among_others(const core::ControllerInput<S>& in,
                                              std::int64_t now_us, S dt);
  void keep_station(const core::ControllerOutput<S>& out, const core::FormationError<S>& error,
                    S dt);
  core::ControllerOutput<S> step_behind(const Lead& lead, std::int64_t now_us, S dt);
  bool may_be_own(std::size_t link, std::int64_t now_us) const;
  void take_time(link::Address from, const link::Timesync& answer, std::int64_t now_us);
  void set_limits(const Parameters& p);
  void set_link(const Parameters& p);
  void weigh(const core::Tau<S>& given, S since);
  void find_latency(const core::TrackMessage<S>& fix, std::int64_t now_us);
  void look_at_clock(std::int64_t now_us);
  core::ObserverParams<S> careful_observer() const;
  void set_latency(const Parameters& p);
  void set_lag();
  void forget_latency();

  core::ControllerParams<S> law_;
  core::StationParams<S> keeping_;
  core::StationState<S> station_{};
  core::ControllerState<S> state_{};
  Lead lead_;                        // of the last step
  core::CoastState<S> coast_{};      // of its motion
  core::FormationError<S> error_{};  // of the last step
  core::Vec2<S> shift_n_{};          // of the slot, towards the leader's actual position
  S shift_s_{};                      // since shift_n_ was updated
  core::Blend<S> blend_{};           // fades out the step from a change of lead
  S coast_s_;                        // how long COAST lasts
  core::ObserverParams<S> observer_;
  core::Observer<S> motion_{};
  // float for every S: products of its variances are below Q16's resolution.
  core::LatencyParams<float> latency_params_;
  core::Latency<float> latency_{};
  std::int64_t unanswered_us_ = 0;  // since when TIMESYNC has not bounded its clock; 0: not checked
  float fix_s_ = 0;                 // since the last fix used for the latency
  bool finds_latency_ = false;
  std::optional<float> found_;  // latency beyond NAV_LAG_S, s
  float lag_s_ = 0;             // the compensated part of it
  float known_lag_s_ = 0;       // NAV_LAG_S; 0 where that is unknown
  bool lag_named_ = false;      // it is not
  float inertia_ = 1;           // VES_M33
  core::PlausibilityLimits<S> afloat_, carried_;
  bool armed_ = false;
  core::ThrustResponse<S> answer_{};
  bool answers_ = true;
  core::Tau<S> pushed_{};  // impulse since the last weigh(), N s, N m s
  S pushed_s_{};
  core::Nu<S> told_{};        // velocity of the last fix
  core::Nu<S> desired_{};     // as the law desires; without it, of the last fix
  convert::Position anchor_;  // origin of motion_.motion.moved_n
  bool starting_ = false;
  TimeRequests time_;
  VesselTrack<S> own_;
  std::optional<std::size_t> named_link_, own_link_;  // NAV_LINK; by which own states come
  VesselTrack<S> leader_;
  Neighbours neighbours_;
  Reference<S> reference_;
  SlotClaims claims_;
};

}  // namespace flotilla::app
