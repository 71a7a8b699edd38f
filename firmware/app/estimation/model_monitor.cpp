// SPDX-License-Identifier: MIT
#include "app/estimation/model_monitor.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace flotilla::app {
namespace {

constexpr int kLeastBlocks = 12;    // a minute
constexpr float kTurnShare = 0.6F;  // of LAW_R_MAX
// Greatest change per block of 5 s: 5 % of a propeller's thrust and 12 % of the drag in a minute.
constexpr float kBalanceStep = 0.004F, kDragStep = 0.01F;
constexpr float kMaxBalance = 0.3F, kLeastDrag = 0.4F, kMaxDrag = 2.5F;

/// An error of at least this size, above or below 0, is reported if its standard deviation is at
/// most `known`.
struct Limits {
  float above, below, known;
};
constexpr std::array<Limits, ModelMonitor::kNumbers> kLimits{
    {{0.025F, 0.025F, 0.02F}, {0.4F, 0.3F, 0.15F}, {0.75F, 0.4F, 0.15F}}};

/// A change of one of these discards the estimates. LEARN_APPLY and THR_BALANCE are first.
constexpr std::array<float Parameters::*, ModelMonitor::kOfModels> kOfModel{
    &Parameters::LEARN_APPLY, &Parameters::THR_BALANCE, &Parameters::VES_M11,
    &Parameters::VES_M22,     &Parameters::VES_M33,     &Parameters::VES_D11,
    &Parameters::VES_D22,     &Parameters::VES_D33,     &Parameters::VES_D11Q,
    &Parameters::VES_D33U,    &Parameters::THR_ARM,     &Parameters::THR_FWD_MAX,
    &Parameters::THR_REV_MAX, &Parameters::THR_EXPO};

constexpr std::size_t index_of(ModelMonitor::Number number) {
  return static_cast<std::size_t>(number);
}

}  // namespace

void ModelMonitor::configure(const Parameters& p, float r_max_radps) {
  bool same = true;
  for (std::size_t i = 0; i < kOfModel.size(); ++i) {
    same = std::exchange(numbers_[i], p.*kOfModel[i]) == p.*kOfModel[i] && same;
  }
  if (!same) {
    state_ = {};
    judged_ = {};
    balance_applied_ = 0;
    drag_applied_ = 1;
  }
  params_.m11 = p.VES_M11;
  params_.m22 = p.VES_M22;
  params_.m33 = p.VES_M33;
  params_.d11 = drag_applied_ * p.VES_D11;
  params_.d11q = drag_applied_ * p.VES_D11Q;
  params_.d33 = p.VES_D33;
  params_.d33u = p.VES_D33U;
  params_.a = p.THR_ARM;
  params_.r_max = kTurnShare * r_max_radps;
}

Parameters ModelMonitor::applied(const Parameters& p) const {
  Parameters out = p;
  out.THR_BALANCE = std::clamp(p.THR_BALANCE + balance_applied_, -0.5F, 0.5F);
  out.VES_D11 = drag_applied_ * p.VES_D11;
  out.VES_D11Q = drag_applied_ * p.VES_D11Q;
  return out;
}

bool ModelMonitor::take(const core::Impulse<float>& given, const core::Nu<float>& nu,
                        const core::SinCos<float>& heading, const core::Vec2<float>& current_n,
                        std::int64_t now_us) {
  const bool used =
      core::model_error_forward(params_, state_, {given.sum, nu, heading, current_n}, given.time);
  if (!used) return false;
  judge(Number::kBalance, core::balance_error(state_), balance_applied_, now_us);
  judge(Number::kDrag, core::drag_error(state_), drag_applied_, now_us);
  judge(Number::kYawDamping, core::yaw_damping_error(state_), 1, now_us);
  return apply();
}

void ModelMonitor::interrupt() { core::model_error_interrupt(state_); }

/// applied: the change of THR_BALANCE, or the factor, that the model already contains.
void ModelMonitor::judge(Number number, const core::Share<float>& error, float applied,
                         std::int64_t now_us) {
  const Limits& limits = kLimits[index_of(number)];
  Judged& one = judged_[index_of(number)];
  const bool sum = number == Number::kBalance;
  one.value = sum ? applied + error.value : applied * (1 + error.value) - 1;
  const float variance = sum ? error.variance : applied * applied * error.variance;
  const float size = std::abs(one.value);
  const float limit = one.value < 0 ? limits.below : limits.above;
  if (size < limit) {
    one.since_us.reset();
  } else if (!one.since_us) {
    one.since_us = now_us;
  }
  if (size < limit / 2) one.wrong = false;
  const float spare = size - limit;
  if (state_.blocks < kLeastBlocks || variance > limits.known * limits.known) return;
  if (spare < 0 || spare * spare < 4 * variance || size * size < 16 * variance) return;
  if (one.wrong && std::abs(one.value - one.told) < limits.below) return;
  one.wrong = one.fresh = true;
  one.told = one.value;
}

/// Moves part of each reported error, at most one step, from the filters into the model.
bool ModelMonitor::apply() {
  const auto step = [&](Number number, float error, float most) {
    const Judged& one = judged_[index_of(number)];
    return one.wrong ? std::clamp(error, -most, most) : 0;
  };
  float balance = 0, drag = 0;
  const float choice = numbers_[0];
  if (choice >= 1) {
    balance = step(Number::kBalance, core::balance_error(state_).value, kBalanceStep);
    balance = std::clamp(balance_applied_ + balance, -kMaxBalance, kMaxBalance) - balance_applied_;
  }
  if (choice >= 2) {
    drag = step(Number::kDrag, core::drag_error(state_).value, kDragStep);
    drag = std::clamp(drag_applied_ * (1 + drag), kLeastDrag, kMaxDrag) / drag_applied_ - 1;
  }
  if (balance == 0 && drag == 0) return false;
  balance_applied_ += balance;
  drag_applied_ *= 1 + drag;
  core::model_error_applied(state_, balance, drag);
  return true;
}

float ModelMonitor::value_of(Number number) const {
  const float value = judged_[index_of(number)].value;
  return number == Number::kBalance ? numbers_[1] + value : 1 + value;
}

std::optional<ModelMonitor::Finding> ModelMonitor::take_finding() {
  for (std::size_t i = 0; i < kNumbers; ++i) {
    if (!std::exchange(judged_[i].fresh, false)) continue;
    const auto number = static_cast<Number>(i);
    return Finding{number, value_of(number), judged_[i].since_us.value_or(0)};
  }
  return std::nullopt;
}

std::optional<float> ModelMonitor::told(Number number) const {
  if (!judged_[index_of(number)].wrong) return std::nullopt;
  return value_of(number);
}

}  // namespace flotilla::app
