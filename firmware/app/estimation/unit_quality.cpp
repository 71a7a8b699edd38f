// SPDX-License-Identifier: MIT
#include "app/estimation/unit_quality.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
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

constexpr std::uint16_t kUnknownHdop = UINT16_MAX;

/// A limit of 0 is off; NaN (unknown) exceeds no limit.
bool beyond(float value, float limit) { return limit > 0 && value > limit; }

/// Of a message: one with a limit of its own, and the estimator's test ratios; NaN: unknown.
using Quantities = std::array<float, 4>;
Quantities quantities(const link::GpsRawInt& m) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  return {m.eph == kUnknownHdop ? kUnknown : static_cast<float>(m.eph) / 100};
}
Quantities quantities(const link::EstimatorStatus& m) {
  return {m.pos_horiz_accuracy, m.vel_ratio, m.pos_horiz_ratio, m.mag_ratio};
}
Quantities quantities(const link::EkfStatusReport& m) {
  return {0, m.velocity_variance, m.pos_horiz_variance, m.compass_variance};
}
Quantities quantities(const link::Odometry&) { return {}; }  // judge() looks at the covariance

/// A bit for each quantity for which this is true.
std::uint8_t bits_of(const Quantities& all, auto is) {
  std::uint8_t bits = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (is(i)) bits = static_cast<std::uint8_t>(bits | 1U << i);
  }
  return bits;
}

Verdict judge(const link::GpsRawInt& m, const Configuration::Quality& limits) {
  if (m.fix_type < limits.fix) return "GPS fix type";
  if (m.eph != kUnknownHdop && beyond(static_cast<float>(m.eph) / 100, limits.hdop))
    return "GPS HDOP";
  return "";
}

Verdict judge(unsigned flags, std::initializer_list<float> ratios,
              const Configuration::Quality& limits) {
  constexpr unsigned kNeeded = kAttitude | kVelocity | kPlace;
  constexpr unsigned kBad = kConstantPlace | kGlitchOrUninitialised | kGpsGlitch;
  if ((flags & kNeeded) != kNeeded || (flags & kBad) != 0) {
    return "estimator flags";
  }
  if (std::ranges::any_of(ratios, [&](float x) { return beyond(x, limits.ratio); }))
    return "estimator test ratios";
  return "";
}

Verdict judge(const link::EstimatorStatus& m, const Configuration::Quality& limits) {
  if (beyond(m.pos_horiz_accuracy, limits.accuracy_m)) return "position accuracy";
  return judge(m.flags, {m.vel_ratio, m.pos_horiz_ratio, m.mag_ratio}, limits);
}

Verdict judge(const link::EkfStatusReport& m, const Configuration::Quality& limits) {
  return judge(m.flags, {m.velocity_variance, m.pos_horiz_variance, m.compass_variance}, limits);
}

Verdict judge(const link::Odometry& m, const Configuration::Quality& limits) {
  const float north = m.pose_covariance[0], east = m.pose_covariance[6];  // of 6 × 6, m²
  if (!(north > 0) || !(east > 0)) return std::nullopt;
  const float limit = limits.accuracy_m * limits.accuracy_m;
  return beyond(north, limit) || beyond(east, limit) ? "position accuracy" : "";
}

}  // namespace

void UnitQuality::take(const link::Received& received, const Limits& limits, std::int64_t now_us) {
  if (received.from.component != component_) *this = {};
  component_ = received.from.component;
  const link::Message& message = received.message;
  const auto look = [&]<class M>(std::size_t kind, const M* m) {
    if (m == nullptr) return;
    // While the quantity that was beyond its limit is unknown, the message proves nothing.
    if (poor_[kind] != 0) {
      const Quantities told = quantities(*m);
      const auto unknown = bits_of(told, [&](std::size_t i) { return std::isnan(told[i]); });
      if ((poor_[kind] & unknown) != 0) return;
    }
    const auto stricter = Limits{limits.fix, kBetter * limits.hdop, kBetter * limits.accuracy_m,
                                 kBetter * limits.ratio};
    const Limits& now = bad_[kind] ? stricter : limits;
    const Verdict verdict = judge(*m, now);
    if (!verdict) return;
    told_ = true;
    bad_[kind] = !verdict->empty();
    poor_[kind] = 0;
    if (bad_[kind]) {
      fault_ = *verdict;
      const Quantities told = quantities(*m);
      poor_[kind] = bits_of(told, [&](std::size_t i) {
        return beyond(told[i], i > 0 ? now.ratio : kind == 0 ? now.hdop : now.accuracy_m);
      });
    }
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
