// SPDX-License-Identifier: MIT
// The boat: bytes, frames and the time in; bytes and frames out. No socket, no clock, and where it is
// given its storage no heap.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "app/conditions.hpp"
#include "app/guidance/pilot.hpp"
#include "app/operator/storage.hpp"
#include "app/operator/vehicle.hpp"
#include "app/propulsion/can_node.hpp"
#include "app/propulsion/thrusters.hpp"
#include "app/supervisor.hpp"

namespace flotilla::app {

/// What an observer may want to plot, SI units, of the last tick.
struct Snapshot {
  core::State state;
  core::Conditions conditions;
  std::optional<double> own_age_s, leader_age_s, leader_uncertainty_m;
  std::optional<double> reference_age_s;  ///< of the formation's reference, where it is followed
  Estimates estimates;
  bool error_known;  ///< own and leader's state are fresh
  core::Error<double> error;
  core::Nu<double> nu_star;
  core::Tau<double> asked, given;
  core::Thrust<double> thrust_N;
  core::Limits limits;                 ///< that acted
  core::TooFast<double> slot_needs;    ///< beyond LAW_U_MAX, LAW_R_MAX, 0: no more
  bool yielding;                       ///< to another vessel
  bool in_slot;                        ///< in FORMATION; else it closes up
  std::optional<double> separation_m;  ///< predicted, of the nearest vessel
  link::Counters counters;
};

/// What only the boat's host can know.
struct HostReport {
  bool bus_up = true;             ///< the CAN interface is up and not bus-off
  bool parameters_saved = true;   ///< false while they are defaults that nobody saved
  std::uint32_t overruns = 0;     ///< control ticks that came more than a period late, so far
  std::int64_t unix_us = 0;       ///< now, µs since 1970; 0: unknown
  bool save_failed = false;       ///< the last try to write the parameters
  bool stop_pressed = false;      ///< a stop switch that is wired to the host
  std::uint8_t closed_links = 0;  ///< a bit for each MAVLink link whose device could not be opened
  bool clock_is_set = true;  ///< unix_us is right; else a guess, until the navigation unit tells
};

/// S: scalar of the law, float, double or core::Q16.
template <class S>
class Boat {
 public:
  /// Valid until the next tick.
  struct Output {
    const MavlinkLinks* links;
    std::span<const link::CanFrame> can;
  };

  /// Parameters must be valid and free of contradiction; links: 1 … as many as there is storage for,
  /// which outlives the boat. Where boats share an outbox, an output is valid until the next tick of
  /// any of them.
  Boat(const Parameters& parameters, std::size_t links, const Storage& storage);

  /// With ample storage of its own, from the heap; links: 1 … kMaxLinks.
  Boat(const Parameters& parameters, std::size_t links)
      : Boat(parameters, links, std::make_unique<AmpleStorage>()) {}

  Boat(Boat&&) = delete;  // its vehicle refers to its other parts

  /// Any bytes, in any chunks. Times are this boat's own monotonic clock, from 0 on. One that goes
  /// back is counted and stands still; one that stays behind for a second is followed from there.
  void on_mavlink(std::span<const std::uint8_t> data, std::int64_t now_us, std::size_t link);

  /// This link carries datagrams; others are serial lines, perhaps to a radio.
  void set_datagrams(std::size_t link) { links_.set_datagrams(link); }

  /// For a host that hears datagrams: no message goes on in the next one. Elsewhere a message may
  /// come in pieces, but not for longer than 0.3 s.
  void end_of_datagram(std::int64_t now_us, std::size_t link);

  void on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now_us);

  /// For the host that is about to leave: the ticks after it send zeros and ArmingStatus 0.
  void disarm() { vehicle_.disarm(); }

  /// Holds until the next report; without one, all is well.
  void on_host(const HostReport& report) {
    host_ = report;
    set_clock();
  }

  /// The key of all links, the clock, and the last signing_timestamp() of an earlier run, in the
  /// units of link::signing_time(). Links sign and look at signatures as their policy says, kOff at
  /// first.
  void secure(const link::SigningKey& key, std::uint64_t clock, std::uint64_t stored) {
    links_.signing().start(key, clock, stored);
  }
  void set_policy(std::size_t link, SigningPolicy policy) { links_.set_policy(link, policy); }

  /// To be kept over a restart, at least once a minute.
  std::uint64_t signing_timestamp() const { return links_.signing().timestamp(); }

  /// Telemetry on that link keeps to so many bytes a second; 0: no limit.
  void limit_link(std::size_t link, std::uint32_t bytes_per_s) {
    links_.bucket(link).limit(bytes_per_s);
  }

  /// Whether a message of somebody else was accepted since the last call: a host answers only those.
  Heard take_heard() { return vehicle_.take_heard(); }

  /// What was asked since the last call of the parameters on the disk.
  SaveRequest take_save_request() { return vehicle_.take_save_request(); }

  /// For a host that simulates what is around the boat: it shall judge the failures that operators
  /// want to inject, and take what it has accepted after each tick. No other host asks for it.
  void let_failures_be_injected(FailureJudge judge) { vehicle_.let_failures_be_injected(judge); }
  std::optional<Failure> take_failure() { return vehicle_.take_failure(); }

  link::NodeIdServer& node_ids() { return can_.node_ids(); }

  /// One control step. Everything the boat has to say leaves here.
  Output tick(std::int64_t now_us);

  Snapshot snapshot() const;
  core::State state() const { return supervisor_.state(); }

  /// Parts of the snapshot, for who looks at every tick; time as the boat counts it.
  std::int64_t now_us() const { return now_us_; }
  core::Conditions conditions() const { return conditions_; }
  const core::Thrust<S>& thrust() const { return thrust_.thrust; }
  const Pilot<S>& pilot() const { return pilot_; }
  const link::Counters& counters() const { return counters_; }

  /// As set; those that need a restart are in force from the next one on.
  const Parameters& parameters() const { return vehicle_.parameters(); }

  /// Who it is on MAVLink now.
  link::Address self() const { return vehicle_.self(); }

 private:
  Boat(const Parameters& parameters, std::size_t links, std::unique_ptr<AmpleStorage> own)
      : Boat(parameters, links, Storage(own->room, own->outbox)) {
    own_storage_ = std::move(own);
  }

  const Configuration& configuration() const { return vehicle_.configuration(); }
  std::int64_t monotonic(std::int64_t now);
  void take_all(std::size_t link, std::int64_t now_us);
  void learn_time(std::size_t link, const link::SystemTime& time, std::int64_t now_us);
  void set_clock();
  void give_up(std::size_t link, std::int64_t now_us);
  core::Conditions conditions(std::int64_t now_us) const;
  bool coasts_on(std::int64_t now_us) const;
  void look_at_limits(std::int64_t now_us);
  void supervise(std::int64_t now_us);
  void configure();
  void note_state(std::int64_t now_us);
  void note_range();
  bool seen() const {
    constexpr core::Conditions kSeen = core::kOwnFresh | core::kLeaderFresh;
    return (conditions_ & kSeen) == kSeen;
  }
  bool in_slot() const { return state() == core::State::kFormation && pilot_.in_slot(); }
  core::Thrust<S> desired_thrust(std::int64_t now_us, S dt);
  void steer(std::int64_t now_us);
  Report report(std::int64_t now_us);
  std::optional<double> separation_m() const;
  std::optional<link::FormationReference> reference(std::int64_t now_us) const;
  void complain(std::int64_t now_us);
  void complain_of_slot(std::int64_t now_us);
  void complain_of_time(std::int64_t now_us);
  void complain_of_station();
  void complain_of_place(std::int64_t now_us);
  void complain_of_depth(std::int64_t now_us);
  void tell_latency();
  void tell(std::int64_t now_us);

  std::unique_ptr<AmpleStorage> own_storage_;  // none where it was given some
  CanOutput& can_output_;
  Supervisor supervisor_;
  MavlinkLinks links_;
  Pilot<S> pilot_;
  Vehicle vehicle_;
  float tick_rate_Hz_;
  int max_idle_ticks_ = 0;
  core::ControllerOutput<S> law_output_{};
  core::State last_state_ = core::State::kDisarmed;
  core::Conditions conditions_ = 0;
  core::Conditions choices_ = 0;  // of the operator
  bool fits_ = true;              // parameters, into the scalar
  bool overflow_ = false;         // of some number since the last tick began
  bool in_range_ = true;
  Limits limits_;

  Thrusters<S> thrusters_;
  typename Thrusters<S>::Output thrust_{};
  CanNode can_;
  HostReport host_;
  std::optional<std::int64_t> learnt_unix_us_;  // when the boat's clock was 0
  bool save_failed_ = false;                    // as told to the operator
  link::Counters counters_;
  link::Received received_;  // the last message: kept, since to begin one anew zeroes it all

  std::optional<std::int64_t> last_tick_us_;
  std::int64_t now_us_ = 0;
  std::int64_t clock_shift_us_ = 0;
  std::optional<std::int64_t> behind_since_us_;
  int idle_ticks_ = 0;  // in a row, in which time did not go on
  Schedule complaint_due_, slot_complaint_due_, place_complaint_due_;
  Schedule unsaved_complaint_due_, closed_complaint_due_;
  Schedule double_due_, time_complaint_due_, quality_due_, late_due_;
  Settled slot_too_fast_, slot_astern_, untimed_;
  core::Astray astray_ = core::Astray::kNo;  // as told to the operator
  bool latency_told_ = false;
  bool deep_ = false;  // deeper in the tree than is certified
};

}  // namespace flotilla::app
