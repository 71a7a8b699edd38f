// SPDX-License-Identifier: MIT
// The boat: bytes, frames and the time in; bytes and frames out. No socket, no clock, no heap.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "app/can_node.hpp"
#include "app/commands.hpp"
#include "app/mavlink_links.hpp"
#include "app/thrusters.hpp"
#include "app/time_requests.hpp"
#include "app/vessel_track.hpp"

namespace flotilla::app {

/// What an observer may want to plot, SI units, of the last tick.
struct Snapshot {
  core::State state;
  core::Conditions conditions;
  std::optional<double> own_age_s, leader_age_s;
  bool error_known;  ///< own and leader's state are fresh
  core::Error<double> error;
  core::Nu<double> nu_star;
  core::Tau<double> asked, given;
  core::Thrust<double> thrust_N;
  bool surge_limited, yaw_limited, slew_limited;
  link::Counters counters;
};

/// S: scalar of the law, float or double.
template <class S>
class Boat {
 public:
  /// Valid until the next tick.
  struct Output {
    const MavlinkLinks* links;
    std::span<const link::CanFrame> can;
  };

  /// Parameters must be valid and free of contradiction; links: 1 … kMaxLinks.
  Boat(const Parameters& parameters, std::size_t links);

  /// Any bytes, in any chunks. Times are this boat's own monotonic clock, from 0 on. One that goes
  /// back is counted and stands still; one that stays behind for a second is followed from there.
  void on_mavlink(std::span<const std::uint8_t> data, std::int64_t now_us, std::size_t link);
  void on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now_us);

  /// One control step. Everything the boat has to say leaves here.
  Output tick(std::int64_t now_us);

  Snapshot snapshot() const;
  core::State state() const { return state_; }
  const Parameters& parameters() const { return parameters_; }

 private:
  std::int64_t monotonic(std::int64_t now);
  core::Conditions conditions(std::int64_t now_us) const;
  core::Encounter<S> encounter(std::int64_t now_us) const;
  void supervise();
  void answer(const PendingCommand& pending);
  void enter(core::State state, core::Conditions missing);
  void steer(std::int64_t now_us);
  void report(std::int64_t now_us);
  link::Heartbeat heartbeat() const;

  Parameters parameters_;
  core::ControllerParams<S> law_;
  core::ControllerState<S> law_state_{};
  core::ControllerOutput<S> law_output_{};
  core::State state_ = core::State::kDisarmed;
  core::Conditions conditions_ = 0;
  bool starting_ = false;
  bool announce_ = false;  // a heartbeat at once: the state has changed

  VesselTrack<S> own_;
  VesselTrack<S> leader_;
  Thrusters<S> thrusters_;
  typename Thrusters<S>::Output thrust_{};
  CanNode can_;
  CanOutput can_output_;
  MavlinkLinks links_;
  CommandQueue commands_;
  TimeRequests time_;
  link::Counters counters_;

  std::optional<std::int64_t> last_tick_us_;
  std::int64_t now_us_ = 0;
  std::int64_t clock_shift_us_ = 0;
  std::optional<std::int64_t> behind_since_us_;
  Schedule heartbeat_due_;
  Schedule state_due_;
  Schedule origin_due_;
  Schedule timesync_due_;
  Schedule complaint_due_;
};

}  // namespace flotilla::app
