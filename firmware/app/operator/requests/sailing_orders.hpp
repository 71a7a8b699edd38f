// SPDX-License-Identifier: MIT
// Orders of operators and scripts to a boat that sails alone: a target, velocities, a pause.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "app/plan/errand.hpp"
#include "core/drive.hpp"

namespace flotilla::app {

class SailingOrders {
 public:
  /// Sets a target for GUIDED, instead of velocities, and ends a pause. The same target again ends
  /// no pause that has just begun, because it may be a late copy: then false.
  [[nodiscard]] bool go_to(const Target& target, std::int64_t now_us) {
    paused_ = ordered_ == target && was_just_paused(now_us);
    ordered_ = target_ = target;
    drive_.reset();
    return !paused_;
  }

  /// Takes a script's setpoint for GUIDED: a new target, velocities, or neither. The target that an
  /// operator ordered before counts as a new one from now on.
  void set(const std::optional<Target>& target, const std::optional<core::Drive<double>>& drive,
           std::int64_t now_us) {
    ordered_.reset();
    if (target) target_ = target;
    drive_ = drive;
    drive_us_ = now_us;
  }

  /// A target that GUIDED has not begun to sail to yet.
  const std::optional<Target>& target() const { return target_; }
  std::optional<Target> take_target() { return std::exchange(target_, std::nullopt); }

  /// The velocities that a script has set for GUIDED; nothing once it is silent for three seconds.
  std::optional<core::Drive<double>> drive(std::int64_t now_us) const {
    constexpr std::int64_t kSilent_us = 3'000'000;
    return now_us - drive_us_ < kSilent_us ? drive_ : std::nullopt;
  }

  /// Pauses the plan or the errand, or resumes it.
  void pause(bool paused, std::int64_t now_us) {
    paused_ = paused;
    if (paused) paused_us_ = now_us;
  }
  /// In the last five seconds, by an order or by the plan.
  bool was_just_paused(std::int64_t now_us) const {
    return paused_ && now_us - paused_us_ < 5'000'000;
  }
  bool is_paused() const { return paused_; }

  /// Call when the boat has entered another state: pause and velocities no longer apply.
  void enter_state() {
    paused_ = false;
    drive_.reset();
  }

 private:
  bool paused_ = false;
  std::optional<Target> target_, ordered_;
  std::optional<core::Drive<double>> drive_;
  std::int64_t drive_us_ = 0, paused_us_ = 0;
};

}  // namespace flotilla::app
