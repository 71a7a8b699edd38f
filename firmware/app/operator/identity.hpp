// SPDX-License-Identifier: MIT
// The boat's MAVLink identity: a vehicle of its own, or an autopilot's companion.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "app/parameters/configuration.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// A companion takes the system id of the only autopilot heard within 3 s of the first one; if it
/// hears several it keeps the configured id. It never takes the leader's. An armed boat keeps its
/// id.
/// Source: mavlink.io, MAVLink ID assignment.
class Identity {
 public:
  explicit Identity(const Configuration::Start& start)
      : self_{start.system, start.component},
        companion_(start.companion),
        ardupilot_(start.ardupilot) {}

  link::Address self() const { return self_; }
  bool companion() const { return companion_; }

  /// MAV_AUTOPILOT of the heartbeat.
  std::uint8_t autopilot() const {
    if (companion_) return link::mav::kAutopilotInvalid;
    return ardupilot_ ? link::mav::kAutopilotArdupilot : link::mav::kAutopilotGeneric;
  }

  /// Whether a message for this target is for us, alone or among others.
  bool addressed(link::Address target) const {
    return (target.system == 0 || target.system == self_.system) &&
           (target.component == 0 || target.component == self_.component);
  }

  /// Whether a request to this target is for the autopilot whose companion we are: if it is for
  /// the whole system.
  bool is_for_autopilot(link::Address target) const { return companion_ && target.component == 0; }

  void heard(link::Address from, const link::Heartbeat& heartbeat, std::uint8_t leader,
             std::int64_t now_us) {
    if (!companion_ || latched_ || !is_autopilot(from, heartbeat)) return;
    if (from.system == leader) return;
    several_ = several_ || (first_us_ && from.system != autopilot_);
    autopilot_ = from.system;
    if (!first_us_) first_us_ = now_us;
  }

  /// Call when another sender has used our ids.
  void heard_twice(std::int64_t now_us) {
    doubled_ = true;
    doubled_us_ = now_us;
  }
  /// Another sender has used our ids within the last ten seconds.
  bool doubled(std::int64_t now_us) const { return now_us - doubled_us_ < 10'000'000; }
  /// The same, since the last call.
  bool take_doubled() { return std::exchange(doubled_, false); }

  /// Whether the system id has just changed.
  bool latch(bool armed, std::int64_t now_us) {
    if (latched_ || !first_us_ || now_us - *first_us_ < kListen_us) return false;
    latched_ = true;
    if (several_ || armed || autopilot_ == self_.system) return false;
    self_.system = autopilot_;
    return true;
  }

 private:
  static constexpr std::int64_t kListen_us = 3'000'000;

  static bool is_autopilot(link::Address from, const link::Heartbeat& heartbeat) {
    return from.system != 0 && from.component == link::mav::kComponentAutopilot &&
           heartbeat.type != link::mav::kTypeGcs &&
           heartbeat.autopilot != link::mav::kAutopilotInvalid;
  }

  link::Address self_;
  bool companion_, ardupilot_;
  bool latched_ = false;
  bool several_ = false;
  bool doubled_ = false;
  std::uint8_t autopilot_ = 0;
  std::optional<std::int64_t> first_us_;
  std::int64_t doubled_us_ = std::numeric_limits<std::int64_t>::min() / 2;
};

}  // namespace flotilla::app
