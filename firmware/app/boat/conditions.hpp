// SPDX-License-Identifier: MIT
// The supervisor's conditions: those of ESCs, voltage and position, and the complete set, which
// includes those of Vehicle, Guidance and the host.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "app/debounced.hpp"
#include "app/operator/telemetry/telemetry.hpp"
#include "app/propulsion/can_node.hpp"

namespace flotilla::app {

template <class S>
struct Parts;

/// Inputs to the conditions computed by Boat.
struct Judged {
  core::Conditions heard = 0;
  bool in_range = false;     ///< no overflow of the law's scalar
  bool slot_astern = false;  ///< following the slot would require sailing astern
  bool voyage_lost = false;
  bool rally_near = false;  ///< a rally point is permitted and near enough to return to
};

/// Whether both ESCs are online and obey, and no other node commands them.
core::Conditions propulsion_of(const CanNode& can, const Configuration::Propulsion& propulsion,
                               std::int64_t now_us);

/// The operator's limits FS_BATT_V and FS_FENCE_M, and the place to return to. An unknown voltage
/// or position violates its limit.
class FailsafeLimits {
 public:
  struct Seen {
    std::int64_t now_us = 0;
    bool armed = false;
    std::optional<convert::Position> place{};  ///< if needed, fresh, with a known origin
    bool sure = false;                         ///< place is good enough to be home
    std::array<std::optional<link::EscStatus>, 2> escs{};
  };

  /// Whether look() needs the position.
  bool asks_place(const Configuration::Failsafes& failsafes, bool armed,
                  std::int64_t now_us) const {
    return asks_home_ || (armed && !was_armed_) || failsafes.fence_m || now_us >= home_due_us_;
  }

  /// Once a tick.
  void look(const Configuration::Failsafes& failsafes, const Seen& seen);

  core::Conditions conditions() const { return met_; }

  /// Where the boat was first located since the start or, later, since it was last armed; or where
  /// the plan set it.
  std::optional<Home> home() const { return home_; }
  bool home_near() const { return home_near_; }
  /// Whether home was set after the tick of arming, perhaps at another place; true once.
  [[nodiscard]] bool take_late_home() { return std::exchange(late_home_, false); }
  void set_home(const convert::GlobalPoint& place);

 private:
  bool inside(float fence_m, const Seen& seen) const;

  core::Conditions met_ = 0;
  Debounced battery_good_;
  std::optional<convert::Position> left_from_;
  std::optional<Home> home_;  // left_from_ as a global position
  bool was_armed_ = false;
  bool late_home_ = false;
  bool asks_home_ = true;   // the next sure position becomes home
  bool home_near_ = false;  // judged once a second
  std::int64_t home_due_us_ = 0;
};

/// The conditions that depend on messages, frames, the host and parameters alone: within a tick
/// they change only with a parameter. kClear also depends on the boat's place, but is read before
/// its motion advances in the tick.
template <class S>
core::Conditions heard_of(const Parts<S>& boat, std::int64_t now_us);

/// All conditions.
template <class S>
core::Conditions conditions_of(const Parts<S>& boat, const Judged& judged, std::int64_t now_us);

}  // namespace flotilla::app
