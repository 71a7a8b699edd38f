// SPDX-License-Identifier: MIT
// What the supervisor is told of ESCs, voltage, place and the operator's choices; Vehicle, Pilot and
// the host say the rest.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/operator/telemetry.hpp"
#include "app/propulsion/can_node.hpp"

namespace flotilla::app {

/// FS_LEADER_ACT and FS_GCS_ACT.
core::Conditions choices_of(const Configuration::Failsafes& failsafes);

/// What the bus tells of both propellers' ESCs, and of others that would drive them.
core::Conditions propulsion_of(const CanNode& can, const Configuration::Propulsion& propulsion,
                               std::int64_t now_us);

/// Becomes what it is told when that has been so for two seconds; false at first.
class Settled {
 public:
  void look(bool now, std::int64_t now_us) {
    if (now == is_) {
      differs_since_us_.reset();
    } else if (!differs_since_us_) {
      differs_since_us_ = now_us;
    } else if (now_us - *differs_since_us_ >= kWait_us) {
      is_ = now;
      differs_since_us_.reset();
    }
  }
  bool is() const { return is_; }

 private:
  static constexpr std::int64_t kWait_us = 2'000'000;
  bool is_ = false;
  std::optional<std::int64_t> differs_since_us_;
};

/// The operator's limits, FS_BATT_V and FS_FENCE_M: what is not known does not keep to them.
class Limits {
 public:
  struct Seen {
    std::int64_t now_us = 0;
    bool armed = false;
    std::optional<convert::Position> place{};  ///< where it is asked for, fresh and has an origin
    std::array<std::optional<link::EscStatus>, 2> escs{};
  };

  /// Whether look() makes use of the place.
  bool asks_place(const Configuration::Failsafes& failsafes, bool armed) const {
    return !home_ || (armed && !was_armed_) || failsafes.fence_m;
  }

  /// Once a tick.
  void look(const Configuration::Failsafes& failsafes, const Seen& seen);

  core::Conditions conditions() const { return met_; }

  /// Where the boat was first seen, then where it was last armed.
  std::optional<Home> home() const { return home_; }

 private:
  bool inside(float fence_m, const Seen& seen) const;

  core::Conditions met_ = 0;
  Settled battery_good_;
  std::optional<convert::Position> left_from_;
  std::optional<Home> home_;  // the same place on the globe
  bool was_armed_ = false;
};

}  // namespace flotilla::app
