// SPDX-License-Identifier: MIT
// Tracks the boat, its leader and other vessels, and runs the control law.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/convert/convert_telemetry.hpp"
#include "app/guidance/fleet_reports.hpp"
#include "app/guidance/reference.hpp"
#include "app/guidance/sender.hpp"
#include "app/guidance/slot_claims.hpp"
#include "app/guidance/slot_follower.hpp"
#include "app/navigation/neighbours.hpp"
#include "app/navigation/time_requests.hpp"
#include "app/navigation/vessel_track.hpp"
#include "app/plan/plan_vessel.hpp"
#include "core/supervisor.hpp"

namespace flotilla::app {

/// Estimated disturbances, SI units.
struct Estimates {
  core::Tau<double> unknown;     ///< wrench that neither model nor propellers account for
  core::Vec2<double> current_n;  ///< of the water
};

template <class S>
class Guidance {
 public:
  Guidance(const Configuration& configuration, const convert::Law<S>& law);

  /// Applies changed parameters and the boat's system id.
  void configure(const Configuration& configuration, const convert::Law<S>& law,
                 std::uint8_t own_system);

  /// Takes any message; ignores those of unrelated vessels.
  void take(const link::Received& received, std::size_t link, std::int64_t now_us,
            link::Counters& counters, const Sender& sender);

  /// The boat's own unit is on a link other than this one.
  bool own_is_elsewhere(std::size_t link) const { return own_.is_elsewhere(link); }

  /// Makes the TIMESYNC requests to send; take() gets the answers.
  TimeRequests& time_requests() { return time_; }

  /// The conditions of the boat's own motion: fresh, plausible, in time.
  core::Conditions conditions(std::int64_t now_us) const {
    return own_.conditions(limits_.own_limit_us, now_us);
  }

  /// Conditions that depend on other vessels: leader, tree, clearance.
  core::Conditions heard(std::int64_t now_us) const;

  /// Call in every tick: advances the boat's motion by `since` s under the wrench `given`.
  void observe(std::int64_t now_us, S since, const core::Tau<S>& given, bool armed);

  /// Call on entering FORMATION, except from COAST: resets the law to the leader's present state.
  void start(std::int64_t now_us);

  /// Velocity and acceleration of a slot that moves in the shape, relative to the formation's root
  /// and in the slot's axes; its course may be opposite to the root's.
  void move_slot(bool moves, const std::array<float, 2>& mps, const std::array<float, 2>& mps2,
                 const std::array<float, 2>& soon_mps) {
    slot_moves_ = moves;
    slot_soon_v_ = {convert::scalar<S>(soon_mps[0]), convert::scalar<S>(soon_mps[1])};
    slot_v_ = {convert::scalar<S>(mps[0]), convert::scalar<S>(mps[1])};
    slot_a_ = {convert::scalar<S>(mps2[0]), convert::scalar<S>(mps2[1])};
  }
  bool slot_moves() const { return slot_moves_; }

  /// Bit mask of courses (core::kCourses) that the boat avoids while it yields.
  void close_courses(std::uint16_t closed) { closed_courses_ = closed; }
  /// Greatest speed while yielding, m/s.
  S fastest() const {
    const core::ControllerParams<S>& law = law_.controller;
    return S(0) < law.outer.u_max ? law.outer.u_max : law.separation.least;
  }

  /// System id of the leader.
  std::uint8_t leader() const { return leader_.system(); }

  /// A jump of the leader or the root was accepted since start().
  bool leader_jumped() const { return leader_.jumped() || reference_.jumped(); }

  /// Call on return from COAST to FORMATION: the leader may have come back somewhere else.
  void close_anew() { follower_.close_anew(); }

  /// One step of the law, dt after the last one, s.
  core::ControllerOutput<S> step(std::int64_t now_us, S dt);

  /// The same in COAST, behind the leader of the last step(), extrapolated. Requires can_coast():
  /// the boat's position relative to that leader is known.
  core::ControllerOutput<S> coast(std::int64_t now_us, S dt);
  bool can_coast() const;

  /// Call on entering a mode without a leader, then start_plan(). Resets the watch on the boat's
  /// response; the other two do not, or orders that come often would switch it off.
  void start_alone();
  /// The law follows a virtual vessel that sails the plan from the boat's place. The plan must not
  /// change before end_plan().
  void start_plan(const PlanOrder& order, const PlanDefaults& defaults);
  /// The vessel sails another plan, from its own place.
  void change_plan(const PlanOrder& order, const PlanDefaults& defaults);
  void end_plan() { reference_.lead(false); }

  /// One step of the law behind that vessel; paused: it slows down and waits.
  core::ControllerOutput<S> sail(Plan plan, bool paused, std::int64_t now_us, S dt);
  /// Changes the speed of that vessel's whole way.
  void set_speed(S mps) { plan_vessel_.set_speed(mps); }
  /// The same behind a vessel that is driven by velocity setpoints.
  core::ControllerOutput<S> drive(const core::Drive<S>& desired, bool paused, std::int64_t now_us,
                                  S dt);
  const PlanVessel<S>& plan_vessel() const { return plan_vessel_; }
  PlanVessel<S>& plan_vessel() { return plan_vessel_; }

  /// Whether the boat under the law keeps its slot, and whether it is in its slot. Both start anew
  /// when the boat enters FORMATION, or when its slot or leader changes.
  core::StationLoss station_loss() const { return follower_.station_loss(); }
  bool in_slot() const { return follower_.in_slot(); }
  S yaw_rate() const { return own_.motion().nu.r; }

  /// The reports of the tree's other boats.
  FleetReports& reports() { return reports_; }

  /// Other vessels' claims to the boat's slot.
  const SlotClaims& claims() const { return claims_; }

  /// The boat's error from its slot, without a step of the law.
  core::ControllerOutput<S> look(std::int64_t now_us) const;

  const core::ControllerParams<S>& law() const { return law_.controller; }
  Estimates estimates() const;
  const core::Vec2<S>& current_n() const { return own_.observer().c_n; }

  /// The boat's state at the current whole millisecond.
  convert::OwnState own_state(std::int64_t now_us) const;
  bool located() const { return own_.track().has_origin(); }
  const link::GpsGlobalOrigin& origin() const { return own_.anchor().origin; }
  convert::Position place() const { return own_.place(); }
  const core::Motion<S>& motion() const { return own_.motion(); }

  /// Motion since seen_from(), from the navigation unit alone, without the hull's model.
  core::Motion<S> seen_motion(std::int64_t now_us) const { return own_.track().motion(now_us); }
  const convert::Position& seen_from() const { return own_.track().position(); }

  /// Where the boat, or the vessel that it follows, comes to rest if it brakes now, straight ahead,
  /// and its present speed.
  Target stop_ahead(bool of_vessel) const;

  /// Whether the boat is so near to the vessel, half the distance at which it waits for the boat,
  /// that the vessel may sail another plan.
  bool is_near_vessel() const { return S(2) * follower_.off() < behind().far_m; }

  /// Depth in the tree, to be sent; nullopt if FS_SEP_M is 0.
  std::optional<double> depth() const;

  /// The reference for followers. `followed`: in FORMATION, or in a COAST still so short that
  /// followers keep the reference.
  std::optional<link::FormationReference> reference(std::int64_t now_us, bool followed) const {
    return reference_.message(now_us, followed);
  }
  std::uint32_t reference_news() const { return reference_.news(); }
  std::optional<link::FormationFuture> future(std::int64_t now_us) const {
    return reference_.future_message(now_us);
  }
  std::uint32_t future_news() const { return reference_.future_news(); }
  const TreePlace& tree_place() const { return reference_.place(); }
  std::optional<double> reference_age_s(std::int64_t now_us) const;

  /// Estimated latency of the navigation unit beyond NAV_LAG_S; nullopt before it is known, or if
  /// TIMESYNC bounds it.
  std::optional<double> latency_s() const;

  const UnitQuality& own_quality() const { return own_.quality(); }
  std::optional<link::GpsRawInt> gps(std::int64_t now_us) const { return own_.gps(now_us); }
  bool take_stranger() { return own_.take_stranger(); }

  /// nullopt if neither TIMESYNC nor an estimated latency gives it.
  std::optional<double> own_age_s(std::int64_t now_us) const;
  std::optional<double> leader_age_s(std::int64_t now_us) const;
  std::optional<double> leader_uncertainty_m(std::int64_t now_us) const {
    return leader_.uncertainty_m(now_us);
  }

  /// A system id that two vessels use: the boat's own, or the leader's.
  std::optional<std::uint8_t> doubled(std::int64_t now_us) const {
    if (own_.track().doubled(now_us)) return own_.track().system();
    return leader_.doubled(now_us) ? std::optional(leader_.system()) : std::nullopt;
  }

  /// A vessel whose messages come too late for the boat to keep clear of it.
  std::optional<std::uint8_t> late_neighbour(std::int64_t now_us) const {
    return neighbours_.watches() ? neighbours_.late(now_us) : std::nullopt;
  }

  /// An ODOMETRY in a frame without north was refused since the last call.
  bool take_frame_warning() {
    const bool own = own_.track().take_frame_warning(), leader = leader_.take_frame_warning();
    return own || leader;
  }

 private:
  void take_time(link::Address from, const link::Timesync& answer, std::size_t link,
                 std::int64_t now_us);
  Lead<S> lead(std::int64_t now_us) const;
  Lead<S> lead_of(const typename Reference<S>::Aim& aim) const;
  Lead<S> lead_of_plan() const;
  core::Vec2<S> leaders_error(std::int64_t now_us) const;
  BoatBehind<S> behind() const;
  core::ControllerOutput<S> follow_plan_vessel(std::int64_t now_us, S dt);
  core::ControllerOutput<S> step_law(std::int64_t now_us, S dt);
  core::ControllerOutput<S> step_law(const core::Traffic<S>* traffic, S dt);

  convert::Law<S> law_;
  bool slot_moves_ = false;
  std::uint16_t closed_courses_ = 0;
  core::Vec2<S> slot_v_{}, slot_a_{}, slot_soon_v_{};
  Configuration::Navigation limits_;
  convert::Reach reach_{0};  // greatest distance of the leader
  TimeRequests time_;
  OwnMotion<S> own_;
  VesselTrack<S> leader_;
  bool leaders_reference_ = false;  // the last step followed a relayed reference, not leader_
  PlanVessel<S> plan_vessel_;
  SlotFollower<S> follower_;
  Neighbours neighbours_;
  Reference<S> reference_;
  SlotClaims claims_;
  FleetReports reports_;
};

}  // namespace flotilla::app
