// SPDX-License-Identifier: MIT
#include "app/estimation/unit_quality.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>

namespace flotilla::app {
namespace {

constexpr std::int64_t kSettled_us = 1'000'000, kNever = std::numeric_limits<std::int64_t>::max();
constexpr float kBetter = 0.8F;

// Bits that ESTIMATOR_STATUS and EKF_STATUS_REPORT share, and bits that only one of them has.
constexpr unsigned kAttitude = 1, kVelocity = 2, kPlace = 16;
constexpr unsigned kConstantPlace = 128, kGlitchOrUninitialised = 1024, kGpsGlitch = 32768;

/// The quantity of a message that is beyond its limit, empty if none is; nothing if the message
/// reports no quantity.
using Verdict = std::optional<std::string_view>;

constexpr std::string_view kHdop = "GPS HDOP", kAccuracy = "position accuracy",
                           kRatios = "estimator test ratios";
constexpr std::uint16_t kUnknownHdop = UINT16_MAX;

/// A limit of 0 is off; NaN (unknown) exceeds no limit.
bool beyond(float value, float limit) { return limit > 0 && value > limit; }

/// Whether the message does not tell the quantity that was beyond its limit.
bool hides(const link::GpsRawInt& m, std::string_view fault) {
  return fault == kHdop && m.eph == kUnknownHdop;
}
bool hides(const link::EstimatorStatus& m, std::string_view fault) {
  return (fault == kAccuracy && std::isnan(m.pos_horiz_accuracy)) ||
         (fault == kRatios && std::isnan(m.vel_ratio + m.pos_horiz_ratio + m.mag_ratio));
}
bool hides(const link::EkfStatusReport& m, std::string_view fault) {
  return fault == kRatios &&
         std::isnan(m.velocity_variance + m.pos_horiz_variance + m.compass_variance);
}
bool hides(const link::Odometry&, std::string_view) { return false; }  // judge() tells

Verdict judge(const link::GpsRawInt& m, const Configuration::Quality& limits) {
  if (m.fix_type < limits.fix) return "GPS fix type";
  if (m.eph != kUnknownHdop && beyond(static_cast<float>(m.eph) / 100, limits.hdop)) return kHdop;
  return "";
}

Verdict judge(unsigned flags, std::initializer_list<float> ratios,
              const Configuration::Quality& limits) {
  constexpr unsigned kNeeded = kAttitude | kVelocity | kPlace;
  constexpr unsigned kBad = kConstantPlace | kGlitchOrUninitialised | kGpsGlitch;
  if ((flags & kNeeded) != kNeeded || (flags & kBad) != 0) {
    return "estimator flags";
  }
  if (std::ranges::any_of(ratios, [&](float x) { return beyond(x, limits.ratio); })) return kRatios;
  return "";
}

Verdict judge(const link::EstimatorStatus& m, const Configuration::Quality& limits) {
  if (beyond(m.pos_horiz_accuracy, limits.accuracy_m)) return kAccuracy;
  return judge(m.flags, {m.vel_ratio, m.pos_horiz_ratio, m.mag_ratio}, limits);
}

Verdict judge(const link::EkfStatusReport& m, const Configuration::Quality& limits) {
  return judge(m.flags, {m.velocity_variance, m.pos_horiz_variance, m.compass_variance}, limits);
}

Verdict judge(const link::Odometry& m, const Configuration::Quality& limits) {
  const float north = m.pose_covariance[0], east = m.pose_covariance[6];  // of 6 × 6, m²
  if (!(north > 0) || !(east > 0)) return std::nullopt;
  const float limit = limits.accuracy_m * limits.accuracy_m;
  return beyond(north, limit) || beyond(east, limit) ? kAccuracy : "";
}

}  // namespace

void UnitQuality::take(const link::Received& received, const Limits& limits, std::int64_t now_us) {
  if (received.from.component != component_) *this = {};
  component_ = received.from.component;
  const link::Message& message = received.message;
  const auto look = [&]<class M>(std::size_t kind, const M* m) {
    if (m == nullptr || (bad_[kind] && hides(*m, fault_))) return;
    const auto stricter = Limits{limits.fix, kBetter * limits.hdop, kBetter * limits.accuracy_m,
                                 kBetter * limits.ratio};
    const Verdict verdict = judge(*m, bad_[kind] ? stricter : limits);
    if (!verdict) return;
    told_ = true;
    bad_[kind] = !verdict->empty();
    if (bad_[kind]) fault_ = *verdict;
    const bool any = std::ranges::any_of(bad_, [](bool bad) { return bad; });
    if (any) {
      good_from_us_ = kNever;
    } else if (good_from_us_ == kNever) {
      good_from_us_ = now_us + kSettled_us;
    }
  };
  look(0, std::get_if<link::GpsRawInt>(&message));
  look(1, std::get_if<link::EstimatorStatus>(&message));
  look(2, std::get_if<link::EkfStatusReport>(&message));
  look(3, std::get_if<link::Odometry>(&message));
}

}  // namespace flotilla::app
