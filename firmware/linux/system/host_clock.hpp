// SPDX-License-Identifier: MIT
// Whether the system's clock can be trusted. A computer without a real-time clock begins where it
// ended.
#pragma once

#include <cstdint>
#include <filesystem>

namespace flotilla::target {

struct ClockEvidence {
  /// There since systemd-timesyncd has set the clock after the start.
  std::filesystem::path synchronized = "/run/systemd/timesync/synchronized";
  /// The real-time clock, s since 1970. One without a battery begins at 0.
  std::filesystem::path rtc = "/sys/class/rtc/rtc0/since_epoch";
};

/// The network has set it, or the real-time clock agrees with it within a minute. May block.
bool clock_is_set(const ClockEvidence& evidence, std::int64_t unix_s);

}  // namespace flotilla::target
