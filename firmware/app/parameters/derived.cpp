// SPDX-License-Identifier: MIT
#include "app/parameters/derived.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace flotilla::app {
namespace {

// The paper's vessel: its mass, and the default length of a boat of that mass.
constexpr float kMass_kg = 1.012F, kLength_m = 1.3F;
constexpr float kLoop_s = 0.018F;  // a little less than two ticks at 100 Hz
constexpr float kSurgeRatio = 4.1844F, kYawRatio = 1.8102F;
constexpr float kObserver = 1.0F, kObserverMost_radps = 2.0F;
constexpr float kYawRateMost_radps = 0.8F, kMomentShare = 0.6F, kAnySpeed_mps = 1.5F;

/// By Newton's method: the microcontroller's image has no mathematical library.
float root(float x) {
  float r = std::max(x, 1.0F);
  for (int i = 0; i < 20; ++i) r = (r + x / r) / 2;
  return r;
}

float lag_s(const Parameters& p) {
  constexpr float kOfMass_s = 0.02F, kMax_s = 0.5F;
  const float unknown = kOfMass_s * (root(p.VES_M11 / kMass_kg) - 1);
  return kLoop_s + (p.THR_LAG < 0 ? std::clamp(unknown, 0.0F, kMax_s) : p.THR_LAG);
}

/// Rounds to three decimals, so that an operator reads 10 where the result is 9.99998.
float rounded(float gain) {
  constexpr float kMax = 10'000;
  const float thousandths = 1000 * std::clamp(gain, 0.0F, kMax);
  return static_cast<float>(static_cast<std::int32_t>(thousandths + 0.5F)) / 1000;
}

float current_radps(const Parameters& p) {
  constexpr float kLeast_radps = 0.1F, kMax = 6;
  const float drift_s = p.VES_M22 / p.VES_D22;
  return kLeast_radps * std::max(1.0F, std::min(drift_s, kMax / drift_s));
}

float greatest_speed_mps(const Parameters& p) {
  return p.LAW_U_MAX > 0 ? p.LAW_U_MAX : kAnySpeed_mps;
}

float look_ahead_m(const Parameters& p, float yaw_s) {
  constexpr float kLeast_m = 1, kMax_m = 100;
  const float damped = std::max(kLeast_m, 2 * greatest_speed_mps(p) * yaw_s);
  return std::min({p.BOAT_LEN / kLength_m, damped, kMax_m});
}

float yaw_rate_radps(const Parameters& p) {
  const float moment = p.THR_ARM * (p.THR_FWD_MAX + p.THR_REV_MAX) * (1 - std::abs(p.THR_BALANCE));
  const float speed = greatest_speed_mps(p) / 2;
  const float held = kMomentShare * moment / (p.VES_D33 + p.VES_D33U * speed);
  return std::min(kYawRateMost_radps * std::min(kLength_m / p.BOAT_LEN, 1.0F), held);
}

struct Loop {
  float m, d, k;
  std::string_view gain, name, outer;
  float k_outer;
  float time_s() const { return m / (d + k); }
};

std::optional<GainFault> gain_fault_of(const Loop& loop, const Parameters& p) {
  const float time_s = loop.time_s(), lag = lag_s(p);
  const float damped = loop.m + loop.d * lag;
  const float least_s = loop.m * loop.m * lag / (damped * damped);
  if (!(p.THR_LAG < 0) && time_s < least_s) {
    return GainFault{loop.gain, loop.k, time_s, loop.name, "THR_LAG", least_s, true};
  }
  if (loop.k_outer * time_s <= 1) return std::nullopt;
  return GainFault{loop.gain, loop.k, time_s, loop.name, loop.outer, 1 / loop.k_outer, false};
}

}  // namespace

std::optional<GainFault> gain_fault(const Parameters& given) {
  const Parameters p = derived(given);
  const Loop surge{p.VES_M11, p.VES_D11, p.LAW_KDU, "LAW_KDU", "surge loop", "LAW_KX", p.LAW_KX};
  const Loop yaw{p.VES_M33, p.VES_D33, p.LAW_KDR, "LAW_KDR", "yaw loop", "LAW_KPSI", p.LAW_KPSI};
  if (const auto found = gain_fault_of(surge, p)) return found;
  if (const auto found = gain_fault_of(yaw, p)) return found;
  const float omega = p.LAW_OBS_BW, lag = lag_s(p);
  if (p.THR_LAG < 0 || omega * lag <= 1) return std::nullopt;
  return GainFault{"LAW_OBS_BW", omega, 1 / omega, "observer", "THR_LAG", lag, true};
}

Parameters derived(const Parameters& p) {
  const float lag = lag_s(p), surge_s = kSurgeRatio * lag, yaw_s = kYawRatio * lag;
  const auto unless_set = [](float& gain, float value) {
    if (gain < 0) gain = value;
  };
  Parameters out = p;
  unless_set(out.LAW_KDU, rounded(p.VES_M11 / surge_s - p.VES_D11));
  unless_set(out.LAW_KDR, rounded(p.VES_M33 / yaw_s - p.VES_D33));
  unless_set(out.LAW_OBS_BW, std::min(kObserverMost_radps, kObserver / surge_s));
  unless_set(out.LAW_CUR_BW, current_radps(p));
  unless_set(out.LAW_XT_DIST, look_ahead_m(p, yaw_s));
  unless_set(out.LAW_R_MAX, yaw_rate_radps(p));
  return out;
}

}  // namespace flotilla::app
