// SPDX-License-Identifier: MIT
// The supervisor's conditions that depend on ESCs, voltage, position and the operator's choices;
// the others come from Vehicle, Pilot and the host.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/operator/telemetry.hpp"
#include "app/propulsion/can_node.hpp"

namespace flotilla::app {

/// FS_LEADER_ACT and FS_GCS_ACT as conditions.
core::Conditions choices_of(const Configuration::Failsafes& failsafes);

/// Whether both ESCs are online and obey, and no other node commands them.
core::Conditions propulsion_of(const CanNode& can, const Configuration::Propulsion& propulsion,
                               std::int64_t now_us);

/// Debounces a condition: takes a new value once it has lasted 2 s; initially false.
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

/// The operator's limits FS_BATT_V and FS_FENCE_M. An unknown voltage or position violates them.
class FailsafeLimits {
 public:
  struct Seen {
    std::int64_t now_us = 0;
    bool armed = false;
    std::optional<convert::Position> place{};  ///< if needed, fresh, with a known origin
    std::array<std::optional<link::EscStatus>, 2> escs{};
  };

  /// Whether look() needs the position.
  bool asks_place(const Configuration::Failsafes& failsafes, bool armed) const {
    return !home_ || (armed && !was_armed_) || failsafes.fence_m;
  }

  /// Once a tick.
  void look(const Configuration::Failsafes& failsafes, const Seen& seen);

  core::Conditions conditions() const { return met_; }

  /// The first known position; after arming, the position where the boat was last armed.
  std::optional<Home> home() const { return home_; }

 private:
  bool inside(float fence_m, const Seen& seen) const;

  core::Conditions met_ = 0;
  Settled battery_good_;
  std::optional<convert::Position> left_from_;
  std::optional<Home> home_;  // left_from_ as a global position
  bool was_armed_ = false;
};

}  // namespace flotilla::app
