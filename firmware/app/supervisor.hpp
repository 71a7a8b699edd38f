// SPDX-License-Identifier: MIT
// The safety decision: the boat's state, the outcome of requests, and whether it may drive. The
// rules are the table of core/supervisor.hpp; this class adds the memory that they need.
#pragma once

#include <cstdint>
#include <optional>

#include "app/parameters.hpp"
#include "core/supervisor.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// Stick positions, −1 … 1: shares of full thrust ahead and of full moment to starboard.
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
    bool changed;              ///< the state has changed
    core::Conditions missing;  ///< as in core::Verdict
  };

  core::State state() const { return state_; }

  /// Mode numbers of namespace mode: of the present state, and of the last granted mode request.
  std::uint8_t mode() const;
  std::uint8_t intended_mode() const { return intended_mode_; }

  /// Disarmed, or in HOLD or FAULT by request and not because of a failure.
  bool is_stopped_by_request() const {
    const bool rests = state_ == core::State::kHold || state_ == core::State::kFault;
    return state_ == core::State::kDisarmed || (rests && intended_mode_ == mode::kHold);
  }

  const Sticks& sticks() const { return sticks_; }
  const std::optional<MotorTest>& motor_test() const { return test_; }  ///< the last one

  /// Time at which COAST began; nothing in other states.
  std::optional<std::int64_t> coasting_since_us() const { return coast_us_; }

  /// Sets the reactions to losses.
  void choose(const core::Choices& choices) {
    choices_ = choices;
    stays_.reset();
  }

  /// The conditions that depend on the sticks and the motor test.
  core::Conditions conditions(std::int64_t now_us) const;

  /// Applies the automatic transitions. Later requests are judged by these conditions, too.
  [[nodiscard]] Decision apply_conditions(core::Conditions conditions, std::int64_t now_us);

  /// Removes conditions until the next apply_conditions(): requests are judged without them.
  void withdraw(core::Conditions missing) { conditions_ &= ~missing; }

  [[nodiscard]] Decision request(core::Request request, std::int64_t now_us);
  [[nodiscard]] Decision request_test(const MotorTest& test, std::int64_t now_us);

  /// Whether this test is running or, if the request is a retransmission, ended in HOLD less than
  /// 2 s ago: it is then neither prolonged nor run again.
  bool is_repeated(const MotorTest& test, bool repeated, std::int64_t now_us) const;

  /// Takes stick positions; ignores them while another operator holds the sticks, unless `wins`. An
  /// operator holds them until silent for 0.5 s, and in MANUAL until the state has changed to HOLD:
  /// in MANUAL, sticks that were silent for 0.5 s are not taken again, whoever sends them.
  void take_sticks(const Sticks& sticks, link::Address from, std::int64_t now_us,
                   bool wins = false);

  /// Whether thrust is allowed. Not in the first 0.2 s after arming: ESCs must see zeros first.
  bool may_drive(core::Conditions conditions, std::int64_t now_us) const;

 private:
  bool sticks_fresh(std::int64_t now_us) const;
  Decision decide(const core::Verdict& verdict, std::int64_t now_us);

  struct Situation {
    core::State state;
    core::Conditions conditions;
    bool operator==(const Situation&) const = default;
  };

  core::State state_ = core::State::kDisarmed;
  core::Conditions conditions_ = 0;
  core::Choices choices_;
  std::optional<Situation> stays_;  // the last one without an automatic transition
  std::uint8_t intended_mode_ = mode::kHold;
  Sticks sticks_;
  link::Address sticks_from_{};
  std::optional<std::int64_t> sticks_us_;
  bool centred_ = false;  // core::kSticksCentred while the sticks are fresh
  std::optional<MotorTest> test_;
  std::int64_t test_end_us_ = 0;
  std::int64_t armed_us_ = 0;
  std::optional<std::int64_t> coast_us_;
};

}  // namespace flotilla::app
