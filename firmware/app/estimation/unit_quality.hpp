// SPDX-License-Identifier: MIT
// The quality of the navigation unit's estimate, as the unit itself reports it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "app/parameters/configuration.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// The last message of each kind counts until the next of that kind, however long that takes. A
/// unit that sends none is judged by its states alone.
class UnitQuality {
 public:
  using Limits = Configuration::Quality;

  /// Takes a message of the unit: GPS_RAW_INT, ESTIMATOR_STATUS, EKF_STATUS_REPORT, or ODOMETRY
  /// with its covariance; ignores others. Another component is another unit.
  void take(const link::Received& received, const Limits& limits, std::int64_t now_us);

  /// All messages have been good for a second. A value over its limit makes its message bad, until
  /// every value of that message is below 0.8 of its limit.
  bool good(std::int64_t now_us) const { return now_us >= good_from_us_; }

  /// The quantity that is, or last was, beyond its limit; empty if none ever was.
  std::string_view fault() const { return fault_; }

  /// At least one such message was received.
  bool told() const { return told_; }

 private:
  static constexpr std::size_t kKinds = 4;

  std::uint8_t component_ = 0;
  bool told_ = false;
  std::array<bool, kKinds> bad_{};
  std::array<std::uint8_t, kKinds> poor_{};  // bits of the quantities beyond their limits
  std::string_view fault_;
  std::int64_t good_from_us_ = 0;
};

}  // namespace flotilla::app
