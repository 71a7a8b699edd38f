// SPDX-License-Identifier: MIT
#include "app/estimation/unit_latency.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/convert/convert_scalar.hpp"
#include "app/convert/times.hpp"

namespace flotilla::app {
namespace {

// Greatest latency that is compensated: with hulls half off their model, predicting over 0.3 s
// costs 0.2 m behind the S-curve (tests/loop/test_late_unit.py).
constexpr float kMaxLate_s = 0.35F;
constexpr std::int64_t kAsked_us = 1'200'000;  // TIMESYNC's period of 1 s, and time for the answer
constexpr float kSlewOfLag = 0.2F;             // s per s
constexpr float kLongest_s = 0.6F;             // between two fixes

}  // namespace

void UnitLatency::configure(const core::LatencyParams<float>& params, float yaw_inertia_kgm2,
                            std::optional<float> named_s) {
  params_ = params;
  yaw_inertia_kgm2_ = yaw_inertia_kgm2;
  if (std::exchange(named_s_, named_s) != named_s) forget();
  set_lag();
}

void UnitLatency::forget() {
  state_ = {};
  found_s_.reset();
  lag_s_ = 0;
  set_lag();
}

void UnitLatency::set_lag() {
  lag_us_.reset();
  if (named_s_ || found_s_) lag_us_ = convert::microseconds(named_s_.value_or(0) + lag_s_);
  uncompensated_s_ = found_s_ ? std::abs(*found_s_ - lag_s_) : kUnknown_s;
  bearable_ = named_s_.value_or(0) + found_s_.value_or(0) <= kMaxLate_s;
}

void UnitLatency::look_at_clock(bool waits, bool observes, std::int64_t now_us) {
  if (!waits || unanswered_us_ == 0) unanswered_us_ = now_us;
  estimates_ = observes && now_us - unanswered_us_ > kAsked_us;
  if (estimates_ || (!found_s_ && lag_s_ == 0)) return;
  forget();
}

void UnitLatency::push(float impulse_Nms, float time_s) {
  core::latency_forward(state_, impulse_Nms / (yaw_inertia_kgm2_ * time_s), time_s);
}

bool UnitLatency::correct(float r_radps, float dt_s, std::int64_t age_us) {
  if (!(0 < dt_s && dt_s < kLongest_s)) {
    state_ = {};
    return false;
  }
  const float age = std::max(convert::seconds<float>(age_us) - lag_s_, 0.0F);
  core::latency_correct(params_, state_, r_radps, age, dt_s);
  const auto late = core::latency_of(params_, state_);
  if (late.known) found_s_ = late.tau;
  if (!found_s_) return false;
  const float most = kSlewOfLag * dt_s;
  lag_s_ += std::clamp(std::min(*found_s_, kMaxLate_s) - lag_s_, -most, most);
  set_lag();
  return true;
}

}  // namespace flotilla::app
