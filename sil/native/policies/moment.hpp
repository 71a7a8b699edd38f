// SPDX-License-Identifier: MIT
// Observation of a boat in one tick: its input since the previous tick, its output, and the
// internal state that its output does not show. Plain data; times are by the boat's own clock, µs.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

#include "app/operator/mavlink_links.hpp"
#include "app/parameters.hpp"
#include "core/allocation.hpp"
#include "core/supervisor.hpp"

namespace flotilla::policies {

/// Longer ago than any limit, without overflow in a difference.
constexpr std::int64_t kNever_us = std::numeric_limits<std::int64_t>::min() / 4;

/// Actions that a boat must only take on request.
enum class Ask : std::uint8_t {
  kArm,
  kArmAllowed,
  kManual,
  kFormation,
  kAuto,
  kGuided,
  kLoiter,
  kReturn,
  kTest,
  kTerminate,
  kAck
};
constexpr std::size_t kAsks = 11;

/// Number of requests, or of actions, by kind.
class Asked {
 public:
  std::uint32_t& operator[](Ask what) { return counts_[static_cast<std::size_t>(what)]; }
  std::uint32_t operator[](Ask what) const { return counts_[static_cast<std::size_t>(what)]; }

 private:
  std::array<std::uint32_t, kAsks> counts_{};
};

/// How far other clocks are ahead of the boat's; nothing if unknown.
struct Clocks {
  std::optional<std::int64_t> own_us, leader_us;
};

/// Input since the previous tick.
struct Heard {
  bool own = false, leader = false;      ///< a message of that system
  bool sticks = false, neutral = false;  ///< of any operator; within a tenth of neutral
  bool disarm = false;                   ///< in any form, to any system
  bool stop = false;           ///< a command to disarm this boat, with no termination behind it
  bool controller = false;     ///< another node commands or arms ESCs
  bool stop_switch = false;    ///< a Button or SafetyState of any value
  bool rebooted = false;       ///< an ESC's node
  std::array<bool, 2> escs{};  ///< status from port, from starboard
};

/// Output on the boat's bus in a tick.
struct OnBus {
  std::uint8_t commands = 0, armings = 0, statuses = 0, others = 0;  ///< complete transfers
  std::uint8_t frames = 0;
  bool whole = true;           ///< only complete transfers with good checksums
  bool ours = true;            ///< from CAN_NODE
  bool counted = true;         ///< transfer ids are consecutive
  bool strangers_idle = true;  ///< no ESC but the two is commanded
  bool told_before = true;     ///< ArmingStatus precedes RawCommand
  std::int16_t loudest = 0;    ///< greatest magnitude of all commands
  std::uint8_t size = 0;       ///< ESCs in the RawCommand
};

/// Output on its links in a tick.
struct OnLinks {
  bool whole = true;           ///< complete frames, back to back
  bool ours = true;            ///< under our ids, or those of a system that was received
  bool others_first = true;    ///< forwarded messages precede our own
  bool counted = true;         ///< sequence numbers are consecutive
  bool finite = true;          ///< floating-point numbers
  bool punctual = true;        ///< times are of this tick or the one before
  bool states_word = false;    ///< a text begins with the state's name
  bool places = false;         ///< a message with the boat's position
  bool beats = false;          ///< a heartbeat on every link
  std::uint8_t gravest = 255;  ///< least severity number of texts (lower is worse)
  std::uint8_t mode = 0, flags = 0, status = 0;  ///< of the last heartbeat
  std::uint16_t longest = 0;                     ///< most bytes on a link
};

/// Values that rules compare with one tick later.
struct Seen {
  std::int64_t now_us = 0;
  core::State state = core::State::kDisarmed;
  std::uint8_t arming = 0;  ///< last value sent
  std::uint8_t health = 0;  ///< of the last NodeStatus, health and mode: 0 is OK and operational
  /// Damaged or incomplete input within the last half second: the boat's reception is uncertain.
  bool torn = false;
  bool has_stop_switch = false;  ///< on the bus, at any time so far
  core::Conditions met = 0;
  std::uint32_t now_ms = 0;  ///< as in telemetry
  std::uint32_t uptime_s = 0;
  core::Thrust<float> thrust_N{};  ///< of the commands, as the boat reports it
  std::optional<double> own_age_s, leader_age_s;
  Asked done;
  std::int16_t port = 0, stbd = 0;  ///< raw commands, −8192 … 8191

  bool in(core::State s) const { return state == s; }
  bool armed() const { return core::armed(state); }
  bool by_law() const { return core::law_drives(state); }
  bool follows() const { return core::follows(state); }
  bool waits() const { return in(core::State::kLoiter) || in(core::State::kReturn); }
  bool has(core::Conditions all) const { return (met & all) == all; }
  float loudest_N() const;
};

struct Moment : Seen {
  std::int64_t dt_us = 0;
  std::uint32_t before_ms = 0;  ///< now_ms of the previous tick
  bool in_range = true;         ///< parameters
  bool locked_change = false;   ///< a parameter that is locked while armed has changed
  const app::Parameters* p = nullptr;

  Heard heard;
  OnBus bus;
  OnLinks links;

  Asked asked;
  std::int64_t state_us = 0;  ///< start of this state
  std::int64_t armed_us = kNever_us;
  std::int64_t arming_us = 0, status_us = 0;  ///< last sent
  std::int64_t beat_us = 0, timesync_us = 0;  ///< oldest among the links
  bool slow_link = false;
  std::int64_t own_us = kNever_us, leader_us = kNever_us, sticks_us = kNever_us,
               neutral_us = kNever_us;
  std::int64_t controller_us = kNever_us, reboot_us = kNever_us;
  Clocks clocks;            ///< of the navigation unit and the leader
  bool in_fleet = false;    ///< a fleet's table was heard
  std::uint8_t leader = 0;  ///< system id of the vessel followed, by FORM_LEADER or that table
  std::int64_t own_true_us = kNever_us, leader_true_us = kNever_us;  ///< of the newest state heard
  std::array<std::int64_t, 2> esc_us{kNever_us, kNever_us};

  std::int64_t since(std::int64_t then_us) const { return now_us - then_us; }
  double since_s(std::int64_t then_us) const { return static_cast<double>(since(then_us)) * 1e-6; }
  /// Whether it was within the limit; input since the previous tick counts as now.
  bool within(double limit_s, std::int64_t then_us) const { return since_s(then_us) <= limit_s; }
  bool pushes() const { return bus.loudest != 0; }
  bool was_asked(Ask what) const { return torn || done[what] <= asked[what]; }
};

inline float Seen::loudest_N() const {
  return std::max(std::abs(thrust_N.port), std::abs(thrust_N.stbd));
}

}  // namespace flotilla::policies
