// SPDX-License-Identifier: MIT
// What can be seen of a boat in one tick: what it heard since the tick before, what it says, and,
// of its inside, what nothing outside tells. Plain data; times are the boat's own, µs.
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

/// Longer ago than any limit, and no overflow in a difference.
constexpr std::int64_t kNever_us = std::numeric_limits<std::int64_t>::min() / 4;

/// What somebody may ask that a boat must not do unasked.
enum class Ask : std::uint8_t { kArm, kArmAllowed, kManual, kFormation, kTest, kTerminate, kAck };
constexpr std::size_t kAsks = 7;

/// How often; asked and done.
class Asked {
 public:
  std::uint32_t& operator[](Ask what) { return counts_[static_cast<std::size_t>(what)]; }
  std::uint32_t operator[](Ask what) const { return counts_[static_cast<std::size_t>(what)]; }

 private:
  std::array<std::uint32_t, kAsks> counts_{};
};

/// Since the tick before.
struct Heard {
  bool own = false, leader = false;  ///< a message of that system
  bool sticks = false;
  bool disarm = false;      ///< in any form, for anybody
  bool stop = false;        ///< a command to disarm, for this boat and nothing after it undoes it
  bool controller = false;  ///< another node commands or arms ESCs
  bool rebooted = false;    ///< an ESC's node
  std::array<bool, 2> escs{};  ///< status of the port, the starboard one
};

/// What the boat puts on its bus in a tick.
struct OnBus {
  std::uint8_t commands = 0, armings = 0, statuses = 0, others = 0;  ///< whole transfers
  std::uint8_t frames = 0;
  bool whole = true;           ///< nothing but whole transfers with good checksums
  bool ours = true;            ///< from CAN_NODE
  bool counted = true;         ///< transfer ids count on
  bool strangers_idle = true;  ///< no ESC is commanded but the two
  bool told_before = true;     ///< ArmingStatus came before RawCommand
  std::int16_t loudest = 0;    ///< of all commands, without sign
  std::uint8_t size = 0;       ///< ESCs in the RawCommand
};

/// What it says over its links in a tick.
struct OnLinks {
  bool whole = true;           ///< frames, one behind the other
  bool ours = true;            ///< under our ids, or somebody's who was heard
  bool others_first = true;    ///< what is handed on comes before our own
  bool counted = true;         ///< sequence numbers count on
  bool finite = true;          ///< floating-point numbers
  bool punctual = true;        ///< times are of this tick or, of positions, of its millisecond
  bool states_word = false;    ///< a sentence that begins with the state's name
  bool places = false;         ///< where the boat is
  bool beats = false;          ///< a heartbeat on every link
  std::uint8_t gravest = 255;  ///< severity of sentences, less is worse
  std::uint8_t mode = 0, flags = 0, status = 0;  ///< of the last heartbeat
  std::uint16_t longest = 0;                     ///< bytes on a link
};

/// What rules look back to, a tick later.
struct Seen {
  std::int64_t now_us = 0;
  core::State state = core::State::kDisarmed;
  std::uint8_t arming = 0;  ///< as told last
  std::uint8_t health = 0;  ///< of the node, and mode: 0 is well and operational
  /// Bytes did not come as whole, good messages within the last half second: what was heard is not
  /// certain.
  bool torn = false;
  core::Conditions met = 0;
  std::uint32_t now_ms = 0;  ///< as telemetry has it
  std::uint32_t uptime_s = 0;
  core::Thrust<float> thrust_N{};  ///< of the commands, as the boat accounts for it
  std::optional<double> own_age_s, leader_age_s;
  Asked done;
  std::int16_t port = 0, stbd = 0;  ///< raw commands, −8192 … 8191

  bool in(core::State s) const { return state == s; }
  bool armed() const { return core::armed(state); }
  bool by_law() const { return core::law_drives(state); }
  bool has(core::Conditions all) const { return (met & all) == all; }
  float loudest_N() const;
};

struct Moment : Seen {
  std::int64_t dt_us = 0;
  std::uint32_t before_ms = 0;  ///< now_ms of the tick before
  bool in_range = true;         ///< parameters
  bool locked_change = false;   ///< of one that is not to change while armed
  const app::Parameters* p = nullptr;

  Heard heard;
  OnBus bus;
  OnLinks links;

  Asked asked;
  std::int64_t state_us = 0;  ///< since when in this state
  std::int64_t armed_us = kNever_us;
  std::int64_t arming_us = 0, status_us = 0;  ///< when told last
  std::int64_t beat_us = 0, timesync_us = 0;  ///< of that link where it is longest ago
  std::int64_t own_us = kNever_us, leader_us = kNever_us, sticks_us = kNever_us;
  std::int64_t controller_us = kNever_us, reboot_us = kNever_us;
  std::array<std::int64_t, 2> esc_us{kNever_us, kNever_us};

  std::int64_t since(std::int64_t then_us) const { return now_us - then_us; }
  double since_s(std::int64_t then_us) const { return static_cast<double>(since(then_us)) * 1e-6; }
  /// Not longer ago than that; what came at any time since the tick before counts as of now.
  bool within(double limit_s, std::int64_t then_us) const { return since_s(then_us) <= limit_s; }
  bool pushes() const { return bus.loudest != 0; }
  bool was_asked(Ask what) const { return torn || done[what] <= asked[what]; }
};

inline float Seen::loudest_N() const {
  return std::max(std::abs(thrust_N.port), std::abs(thrust_N.stbd));
}

}  // namespace flotilla::policies
