// SPDX-License-Identifier: MIT
// The safety decision: the boat's state, what was requested and granted, and whether it may drive. The
// rules are core/supervisor.hpp's table; here is what the table needs to remember.
#pragma once

#include <cstdint>
#include <optional>

#include "app/parameters.hpp"
#include "core/supervisor.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// Shares of full thrust ahead and of full moment to starboard.
struct Sticks {
  double surge = 0, yaw = 0;
};

struct MotorTest {
  bool stbd = false;
  double share = 0;  ///< of the greatest thrust, negative astern
  std::int64_t duration_us = 0;
  bool operator==(const MotorTest&) const = default;
};

class Supervisor {
 public:
  struct Decision {
    bool granted;
    bool changed;              ///< the state
    core::Conditions missing;  ///< as core::Verdict's
  };

  core::State state() const { return state_; }

  /// One of `mode`: of the state, and as last requested.
  std::uint8_t mode() const;
  std::uint8_t intended_mode() const { return intended_mode_; }

  const Sticks& sticks() const { return sticks_; }
  const std::optional<MotorTest>& motor_test() const { return test_; }  ///< the last one

  /// Since when in COAST; nothing in other states.
  std::optional<std::int64_t> coasting_since_us() const { return coast_us_; }

  /// The conditions that sticks and motor test make.
  core::Conditions conditions(std::int64_t now_us) const;

  /// Applies the automatic transitions. Requests are judged by these conditions until the next call.
  Decision apply_conditions(core::Conditions conditions, std::int64_t now_us);

  Decision request(core::Request request, std::int64_t now_us);
  Decision request_test(const MotorTest& test, std::int64_t now_us);

  /// This test runs, or has just ended and its answer was lost: it is neither prolonged nor run again.
  bool is_repeated(const MotorTest& test, bool repeated, std::int64_t now_us) const;

  /// Ignored while another operator holds the sticks: the first keeps them until silent for 0.5 s,
  /// in MANUAL until HOLD has followed.
  void take_sticks(const Sticks& sticks, link::Address from, std::int64_t now_us,
                   bool wins = false);

  /// Thrust is allowed. The first 0.2 s after arming are zeros, which ESCs need to see.
  bool may_drive(core::Conditions conditions, std::int64_t now_us) const;

 private:
  bool sticks_fresh(std::int64_t now_us) const;
  Decision decide(const core::Verdict& verdict, std::int64_t now_us);

  core::State state_ = core::State::kDisarmed;
  core::Conditions conditions_ = 0;
  std::uint8_t intended_mode_ = mode::kHold;
  Sticks sticks_;
  link::Address sticks_from_{};
  std::optional<std::int64_t> sticks_us_;
  bool centred_ = false;  // core::kSticksCentred, while they are fresh
  std::optional<MotorTest> test_;
  std::int64_t test_end_us_ = 0;
  std::int64_t armed_us_ = 0;
  std::optional<std::int64_t> coast_us_;
};

}  // namespace flotilla::app
