// SPDX-License-Identifier: MIT
// The boat: bytes, frames and the time in; bytes and frames out. No socket, no clock, no heap.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>

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

/// What only the boat's host can know.
struct HostReport {
  bool bus_up = true;            ///< the CAN interface is up and not bus-off
  bool parameters_saved = true;  ///< false after a fall to defaults, until they were saved
  std::uint32_t overruns = 0;    ///< control ticks that came more than a period late, so far
};

/// Why the host should save the parameters; the later reason counts.
enum class SaveRequest : std::uint8_t {
  kNone,
  kChanged,    ///< an operator has changed one
  kConfirmed,  ///< an operator has asked for it: those in force are the right ones
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

  /// For the host that is about to leave: the ticks after it send zeros and ArmingStatus 0.
  void disarm() {
    if (state_ != core::State::kDisarmed) enter(core::State::kDisarmed, 0, now_us_);
  }

  /// Holds until the next report; without one, all is well.
  void on_host(const HostReport& report) { host_ = report; }

  /// Telemetry on that link keeps to so many bytes a second; 0: no limit.
  void limit_link(std::size_t link, std::uint32_t bytes_per_s) { links_.limit(link, bytes_per_s); }

  /// Whether an operator has given reason to save the parameters since the last call.
  SaveRequest take_save_request() { return std::exchange(save_request_, SaveRequest::kNone); }

  link::NodeIdServer& node_ids() { return can_.node_ids(); }

  /// One control step. Everything the boat has to say leaves here.
  Output tick(std::int64_t now_us);

  Snapshot snapshot() const;
  core::State state() const { return state_; }
  const Parameters& parameters() const { return parameters_; }

 private:
  std::int64_t monotonic(std::int64_t now);
  core::Conditions conditions(std::int64_t now_us) const;
  void reckon(std::int64_t now_us);
  core::Encounter<S> encounter(std::int64_t now_us) const;
  void supervise(std::int64_t now_us);
  void answer(const PendingCommand& pending, std::int64_t now_us);
  void refuse(core::Request request, core::Conditions missing, std::int64_t now_us);
  void enter(core::State state, core::Conditions missing, std::int64_t now_us);
  void steer(std::int64_t now_us);
  void report(std::int64_t now_us);
  void report_slowly(std::int64_t now_us);
  link::Heartbeat heartbeat() const;

  Parameters parameters_;
  core::ControllerParams<S> law_;
  core::ControllerState<S> law_state_{};
  core::ControllerOutput<S> law_output_{};
  core::State state_ = core::State::kDisarmed;
  core::Conditions conditions_ = 0;
  bool starting_ = false;
  std::int64_t armed_us_ = 0;
  core::Reckoning<S> own_now_{};
  std::uint32_t own_messages_ = 0;
  SaveRequest save_request_ = SaveRequest::kNone;
  bool announce_ = false;  // a heartbeat at once: the state has changed

  VesselTrack<S> own_;
  VesselTrack<S> leader_;
  Thrusters<S> thrusters_;
  typename Thrusters<S>::Output thrust_{};
  CanNode can_;
  CanOutput can_output_;
  MavlinkLinks links_;
  HostReport host_;
  CommandQueue commands_;
  TimeRequests time_;
  link::Counters counters_;

  std::optional<std::int64_t> last_tick_us_;
  std::int64_t now_us_ = 0;
  std::int64_t clock_shift_us_ = 0;
  std::optional<std::int64_t> behind_since_us_;
  int idle_ticks_ = 0;  // in a row, in which time did not go on
  Schedule heartbeat_due_;
  Schedule state_due_;
  Schedule slow_due_;
  Schedule origin_due_;
  Schedule timesync_due_;
  Schedule complaint_due_;
  Schedule refusal_due_;
};

}  // namespace flotilla::app
