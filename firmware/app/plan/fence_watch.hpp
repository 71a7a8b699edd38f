// SPDX-License-Identifier: MIT
// Watches whether the boat is inside its fence, and comes to rest before it leaves it.
//
//   s = u t_r + max(u²/(2 a), u T)        way to rest, straight on: braking, or without thrust
//   inside: c(p) > 0      stays: s < c(p), or the leg p … p + s v/|v| is clear
//
//  symbol  meaning                                  unit
//  u, v    speed over ground, as a vector           m/s
//  t_r     reaction time                            s
//  a, T    deceleration; the water's time constant  m/s², s
#pragma once

#include <cstdint>
#include <optional>

#include "app/plan/fence.hpp"

namespace flotilla::app {

/// As in FENCE_STATUS.
struct FenceReport {
  bool breached = false;
  std::uint16_t breaches = 0;
  std::uint32_t last_ms = 0;  ///< since start-up; 0: none
};

class FenceWatch {
 public:
  struct Seen {
    std::int64_t now_us = 0;
    std::optional<convert::Position> place{};  ///< if fresh, with a known origin
    core::Vec2<core::Q16> velocity_n{};        ///< over ground, m/s
  };

  /// Once a tick.
  void look(const Fence& fence, const Configuration::Stopping& stopping, const Seen& seen);

  /// Bit mask of courses (core::kCourses) on which the boat at this speed would leave the fence
  /// within twice its stopping distance or, if outside, go farther out. 0 off the map.
  static std::uint16_t closed_courses(const Fence& fence, const convert::Position& place,
                                      const Configuration::Stopping& stopping, Fence::Length speed);

  /// True inside and able to stop inside, or without a fence; false if the position is unknown.
  bool stays() const { return stays_; }
  bool is_outside() const { return report_.breached; }
  const FenceReport& report() const { return report_; }

 private:
  struct Last {
    Fence::Place place;
    Fence::Length clearance;
  };

  bool judge(const Fence& fence, const Fence::Place& place, const core::Vec2<core::Q16>& velocity_n,
             const Configuration::Stopping& stopping);
  void note(bool outside, std::int64_t now_us);

  std::optional<Last> last_;  // place whose clearance was computed last
  std::uint32_t drawn_ = 0;   // the map that it was computed with
  bool stays_ = true;
  FenceReport report_;
};

}  // namespace flotilla::app
