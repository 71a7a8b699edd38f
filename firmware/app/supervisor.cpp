// SPDX-License-Identifier: MIT
#include "app/supervisor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace flotilla::app {
namespace {

using core::Request;
using core::State;

constexpr std::int64_t kSticksSilent_us = 500'000, kRepeated_us = 2'000'000;
constexpr std::int64_t kArmedZeros_us = 200'000;

/// Within a tenth of neutral: gamepads do not return to exactly 0.
bool at_neutral(const Sticks& sticks) {
  return std::abs(sticks.surge) <= 0.1 && std::abs(sticks.yaw) <= 0.1;
}

}  // namespace

std::uint8_t Supervisor::mode() const {
  switch (state_) {
    case State::kManual:
      return mode::kManual;
    case State::kFormation:
    case State::kCoast:
      return mode::kFormation;
    case State::kAuto:
      return mode::kAuto;
    case State::kGuided:
      return mode::kGuided;
    case State::kLoiter:
      return mode::kLoiter;
    case State::kReturn:
      return mode::kReturn;
    case State::kDisarmed:
    case State::kHold:
    case State::kTest:
    case State::kFault:
      break;
  }
  return mode::kHold;
}

bool Supervisor::sticks_fresh(std::int64_t now_us) const {
  return sticks_us_ && now_us - *sticks_us_ < kSticksSilent_us;
}

core::Conditions Supervisor::conditions(std::int64_t now_us) const {
  core::Conditions met = 0;
  if (sticks_fresh(now_us)) met |= core::kSticksFresh | (centred_ ? core::kSticksCentred : 0);
  if (test_ && now_us < test_end_us_) met |= core::kTestRunning;
  return met;
}

Supervisor::Decision Supervisor::apply_conditions(core::Conditions conditions,
                                                  std::int64_t now_us) {
  conditions_ = conditions;
  const Situation now{state_, conditions};
  if (stays_ == now) return {};
  const core::Response response = core::response_to(choices_, state_, conditions_);
  const core::Verdict verdict = core::supervise(state_, Request::kNone, conditions_, response);
  if (!verdict.granted) stays_ = now;
  return decide(verdict, now_us);
}

Supervisor::Decision Supervisor::request(Request request, std::int64_t now_us) {
  const core::Verdict verdict = core::supervise(state_, request, conditions_);
  if (verdict.granted) {
    if (request == Request::kManual) intended_mode_ = mode::kManual;
    if (request == Request::kHold || request == Request::kTerminate) intended_mode_ = mode::kHold;
    if (request == Request::kFormation) intended_mode_ = mode::kFormation;
    if (request == Request::kAuto) intended_mode_ = mode::kAuto;
    if (request == Request::kGuided) intended_mode_ = mode::kGuided;
    if (request == Request::kLoiter) intended_mode_ = mode::kLoiter;
    if (request == Request::kReturn) intended_mode_ = mode::kReturn;
  }
  return decide(verdict, now_us);
}

Supervisor::Decision Supervisor::request_test(const MotorTest& test, std::int64_t now_us) {
  const core::Verdict verdict =
      core::supervise(state_, Request::kTest, conditions_ | core::kTestRunning);
  if (verdict.granted) {
    test_ = test;
    test_end_us_ = now_us + test.duration_us;
    conditions_ |= core::kTestRunning;
  }
  return decide(verdict, now_us);
}

bool Supervisor::is_repeated(const MotorTest& test, bool repeated, std::int64_t now_us) const {
  if (test_ != test) return false;
  const bool over = state_ == State::kHold && now_us - test_end_us_ < kRepeated_us;
  return state_ == State::kTest || (repeated && over);
}

void Supervisor::take_sticks(const Sticks& sticks, link::Address from, std::int64_t now_us,
                             bool wins) {
  const bool fresh = sticks_fresh(now_us), manual = state_ == State::kManual;
  const bool others = sticks_from_ != from;
  const bool held = fresh && others && !wins, lost = !fresh && manual;
  if (held || lost) return;
  centred_ = (manual && centred_ && !others) || at_neutral(sticks);
  sticks_ = sticks;
  sticks_from_ = from;
  sticks_us_ = now_us;
}

bool Supervisor::may_drive(core::Conditions conditions, std::int64_t now_us) const {
  return core::may_drive(state_, conditions) && now_us - armed_us_ >= kArmedZeros_us;
}

Supervisor::Decision Supervisor::decide(const core::Verdict& verdict, std::int64_t now_us) {
  const State was = std::exchange(state_, verdict.granted ? verdict.state : state_);
  const bool changed = state_ != was;
  if (changed) {
    centred_ = at_neutral(sticks_);
    if (was == State::kTest) test_end_us_ = std::min(test_end_us_, now_us);
    if (state_ == State::kDisarmed) intended_mode_ = mode::kHold;
    if (core::armed(state_) && !core::armed(was)) armed_us_ = now_us;
    coast_us_ = state_ == State::kCoast ? std::optional(now_us) : std::nullopt;
  }
  return {verdict.granted, changed, verdict.missing};
}

}  // namespace flotilla::app
