// SPDX-License-Identifier: MIT
// Latency of the boat's own navigation unit, if no TIMESYNC bounds its clock.
#pragma once

#include <cstdint>
#include <optional>

#include "core/estimation/latency.hpp"

namespace flotilla::app {

/// Estimates the latency beyond the configured one and compensates for it slowly. In float for
/// every law: products of its variances are below Q16's resolution.
class UnitLatency {
 public:
  /// named_s: NAV_LAG_S, if it is set; a change of it discards the estimate.
  void configure(const core::LatencyParams<float>& params, float yaw_inertia_kgm2,
                 std::optional<float> named_s);

  /// Call once a tick. waits: the unit sends states, and no TIMESYNC bounds its clock. observes: if
  /// false, nothing is estimated, because the law takes each fix as it is, as in the paper.
  void look_at_clock(bool waits, bool observes, std::int64_t now_us);
  bool estimates() const { return estimates_; }

  /// The impulse of the moment given for `time_s`, N m s.
  void push(float impulse_Nms, float time_s);

  /// Takes a fix with the yaw rate r, dt_s after the last one, 0 after a gap; age_us includes
  /// lag_us(). True if lag_us() has changed.
  [[nodiscard]] bool correct(float r_radps, float dt_s, std::int64_t age_us);

  /// Another unit is in use: discards the estimate.
  void forget();

  /// The boat was disarmed: discards the moments given.
  void restart() { state_ = {}; }

  /// Compensated latency, including the configured one; nothing while none is known.
  std::optional<std::int64_t> lag_us() const { return lag_us_; }

  /// Estimated latency beyond the configured one, s; nothing while it is unknown.
  std::optional<float> found_s() const { return found_s_; }

  /// Latency that is not compensated, s; assumed until one is estimated.
  float uncompensated_s() const { return uncompensated_s_; }

  /// All of the latency can be compensated.
  bool is_bearable() const { return bearable_; }

 private:
  // Assumed latency of a unit while none has been estimated.
  static constexpr float kUnknown_s = 0.3F;

  void set_lag();

  core::LatencyParams<float> params_;
  float yaw_inertia_kgm2_ = 1;
  std::optional<float> named_s_;
  core::Latency<float> state_{};
  std::int64_t unanswered_us_ = 0;  // since when TIMESYNC has not bounded its clock; 0: not checked
  bool estimates_ = false;
  std::optional<float> found_s_;
  float lag_s_ = 0;  // the compensated part of it
  // set_lag() derives these three:
  std::optional<std::int64_t> lag_us_;
  float uncompensated_s_ = kUnknown_s;
  bool bearable_ = true;
};

}  // namespace flotilla::app
