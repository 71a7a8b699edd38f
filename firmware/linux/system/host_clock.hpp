// SPDX-License-Identifier: MIT
// Whether the system's clock can be trusted: without a real-time clock it starts at the time of the
// last shutdown.
#pragma once

#include <cstdint>
#include <filesystem>

namespace flotilla::target {

struct ClockEvidence {
  /// Exists once systemd-timesyncd has set the clock since boot.
  std::filesystem::path synchronized = "/run/systemd/timesync/synchronized";
  /// The real-time clock, s since 1970. Without a battery it starts at 0.
  std::filesystem::path rtc = "/sys/class/rtc/rtc0/since_epoch";
};

/// True if the network has set the system's clock, or the real-time clock agrees with it within a
/// minute. May block.
bool clock_is_set(const ClockEvidence& evidence, std::int64_t unix_s);

}  // namespace flotilla::target
