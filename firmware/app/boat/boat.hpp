// SPDX-License-Identifier: MIT
// The boat without I/O: MAVLink bytes, CAN frames and the time in; bytes and frames out. It uses no
// socket, no clock and, with storage from its owner, no heap.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "app/boat/alone.hpp"
#include "app/boat/conditions.hpp"
#include "app/boat/learner.hpp"
#include "app/boat/learnt_time.hpp"
#include "app/boat/membership.hpp"
#include "app/boat/monotonic_clock.hpp"
#include "app/boat/parts.hpp"
#include "app/boat/report.hpp"
#include "app/boat/scalar_range.hpp"
#include "app/boat/ticks.hpp"
#include "app/guidance/guidance.hpp"
#include "app/operator/storage.hpp"
#include "app/operator/telemetry/warnings.hpp"
#include "app/operator/vehicle.hpp"
#include "app/propulsion/can_node.hpp"
#include "app/propulsion/thrusters.hpp"
#include "app/supervisor.hpp"

namespace flotilla::app {

/// S: scalar of the law: float, double or core::Q16.
template <class S>
class Boat {
 public:
  /// Valid until the next tick.
  struct Output {
    const MavlinkLinks* links;
    std::span<const link::CanFrame> can;
  };

  /// Parameters must be valid and free of contradiction. links: 1 … the number that `storage` has
  /// room for; `storage` must outlive the boat. If boats share an outbox, an output is valid only
  /// until the next tick of any of them.
  Boat(const Parameters& parameters, std::size_t links, const Storage& storage);

  /// Allocates ample storage on the heap; links: 1 … kMaxLinks.
  Boat(const Parameters& parameters, std::size_t links)
      : Boat(parameters, links, std::make_unique<AmpleStorage>()) {}

  Boat(Boat&&) = delete;  // its vehicle refers to its other parts

  /// Takes any bytes, in any chunks. now_us is the boat's monotonic clock and starts at 0. A time
  /// that goes back is counted and replaced by the last one; if the clock stays behind for 1 s, the
  /// boat follows it from there.
  void on_mavlink(std::span<const std::uint8_t> data, std::int64_t now_us, std::size_t link);

  /// Declares a datagram link; the others are serial lines, perhaps to a radio.
  void set_datagrams(std::size_t link) { links_.set_datagrams(link); }

  /// Call after each received datagram: no message continues in the next one. On other links a
  /// message may arrive in pieces, within 0.3 s.
  void end_of_datagram(std::int64_t now_us, std::size_t link);

  void on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now_us);

  /// Call before the host exits: later ticks send zero thrust and ArmingStatus 0.
  void disarm() { vehicle_.disarm(); }

  /// Takes a report that is valid until the next one. Before the first report the boat assumes that
  /// all is well.
  void on_host(const HostReport& report) {
    host_ = report;
    set_clock();
  }

  /// Sets the key of all links, the clock, and the last signing_timestamp() of an earlier run, both
  /// in units of link::signing_time(). Each link signs and checks by its policy, initially kOff.
  void secure(const link::SigningKey& key, std::uint64_t clock, std::uint64_t stored) {
    links_.signing().start(key, clock, stored);
  }
  void set_policy(std::size_t link, SigningPolicy policy) { links_.set_policy(link, policy); }

  /// The host stores this every few seconds and passes it to secure() after a restart.
  std::uint64_t signing_timestamp() const { return links_.signing().timestamp(); }

  /// Limits telemetry on that link; 0: no limit. At most 5,760 bytes/s (57,600 Bd): slow telemetry
  /// is sent every 4 s.
  void limit_link(std::size_t link, std::uint32_t bytes_per_s) {
    vehicle_.limit_link(link, bytes_per_s);
  }

  /// The best message accepted from another sender since the last call, for hosts that send only to
  /// peers whose messages were accepted.
  Heard take_heard() { return vehicle_.take_heard(); }

  /// Whether, and why, the host should save the parameters; covers the time since the last call.
  SaveRequest take_save_request() { return vehicle_.take_save_request(); }

  /// Only for a host that simulates the boat's surroundings: `judge` accepts or rejects the
  /// failures that operators inject; the host takes accepted ones after each tick.
  void let_failures_be_injected(FailureJudge judge) { vehicle_.let_failures_be_injected(judge); }
  std::optional<Failure> take_failure() { return vehicle_.take_failure(); }

  link::NodeIdServer& node_ids() { return can_.node_ids(); }

  /// The stored plan, fence or rally points, for the host to save. The id changes with the items;
  /// it is 0 if none are stored.
  Plan stored(Stored kind) const { return vehicle_.missions().stored(kind); }
  std::uint32_t stored_id(Stored kind) const { return vehicle_.missions().id(kind); }
  /// At the start: restores saved items, unless they are not sound.
  PlanFault restore(Stored kind, Plan items) {
    return vehicle_.missions().restore(kind, items, configuration().plan);
  }
  /// At the start: the saved fence cannot be restored. It is lost until an operator has sent or
  /// cleared the fence; the host reports this.
  void lose_fence() { vehicle_.missions().lose_fence(); }
  bool fence_is_lost() const { return vehicle_.missions().fence_is_lost(); }

  /// For a host that keeps logs: it opens the service once at the start, and after each tick it
  /// brings, at once or later, the list or the bytes that request() asks for.
  LogService& logs() { return vehicle_.logs(); }

  /// One control step; returns all output.
  Output tick(std::int64_t now_us);

  Snapshot snapshot() const;
  core::State state() const { return supervisor_.state(); }

  /// Cheap enough for every tick, unlike snapshot(). now_us(): the boat's monotonic clock.
  std::int64_t now_us() const { return clock_.now_us(); }
  core::Conditions conditions() const { return conditions_; }
  const core::Thrust<S>& thrust() const { return thrust_.thrust; }
  const Guidance<S>& guidance() const { return guidance_; }
  const link::Counters& counters() const { return counters_; }

  /// The parameters as set; some changes take effect only at the next start.
  const Parameters& parameters() const { return vehicle_.parameters(); }

  /// The present MAVLink system and component id.
  link::Address self() const { return vehicle_.self(); }

 private:
  Boat(const Parameters& parameters, std::size_t links, std::unique_ptr<AmpleStorage> own)
      : Boat(parameters, links, Storage(own->room, own->outbox)) {
    own_storage_ = std::move(own);
  }

  const Configuration& configuration() const { return vehicle_.configuration(); }
  void take_all(std::size_t link, std::int64_t now_us);
  bool is_namesakes_rc(std::size_t link) const;
  void learn_time(std::size_t link, const link::SystemTime& time, std::int64_t now_us);
  void set_clock();
  void give_up(std::size_t link, std::int64_t now_us);

  void supervise(std::int64_t now_us);
  void configure();
  core::Conditions conditions(std::int64_t now_us) const;
  void apply_conditions(std::int64_t now_us);
  void note_state(std::int64_t now_us);
  void consult_fleet(std::int64_t now_us);

  void steer(std::int64_t now_us);
  core::Thrust<S> desired_thrust(std::int64_t now_us, S dt);
  void drive_by_hand();
  void learn(std::int64_t now_us, S dt);
  void look_at_limits(std::int64_t now_us);
  void look_at_fence(const std::optional<convert::Position>& place, std::int64_t now_us);

  void report_last_tick();
  void tell(std::int64_t now_us);

  std::unique_ptr<AmpleStorage> own_storage_;  // null if the caller owns it
  CanOutput& can_output_;
  Supervisor supervisor_;
  MavlinkLinks links_;
  Guidance<S> guidance_;
  Vehicle vehicle_;
  core::ControllerOutput<S> law_output_{};
  core::State last_state_ = core::State::kDisarmed;
  core::Conditions heard_ = 0;  // of this tick
  core::Conditions conditions_ = 0;
  ScalarRange<S> range_;
  FailsafeLimits limits_;
  FenceWatch fence_watch_;
  Debounced slot_astern_;

  Thrusters<S> thrusters_;
  typename Thrusters<S>::Output thrust_{};
  CanNode can_;
  HostReport host_;
  LearntTime learnt_time_;
  link::Counters counters_;
  link::Received received_;  // reused: a new one for each message would be zeroed each time

  MonotonicClock clock_;
  Ticks ticks_;

  Membership fleet_;
  Learner<S> learner_;
  Warnings<S> warnings_;
  Alone<S> alone_;
  const Parts<S> parts_;  // refers to the members above
};

}  // namespace flotilla::app
