// SPDX-License-Identifier: MIT
#include "linux/system/host_clock.hpp"

#include <cstdlib>
#include <fstream>
#include <system_error>

namespace flotilla::target {

bool clock_is_set(const ClockEvidence& evidence, std::int64_t unix_s) {
  std::error_code ignored;
  if (std::filesystem::exists(evidence.synchronized, ignored)) return true;
  std::int64_t rtc_s = 0;
  std::ifstream(evidence.rtc) >> rtc_s;
  return std::abs(rtc_s - unix_s) <= 60;
}

}  // namespace flotilla::target
