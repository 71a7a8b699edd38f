// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "linux/scratch.hpp"
#include "linux/system/host_clock.hpp"

namespace flotilla::target {
namespace {

constexpr std::int64_t kNow_s = 1'790'000'000;

TEST_CASE("a host's clock counts as set if the network has set it or a real-time clock agrees") {
  const Scratch folder;
  const ClockEvidence evidence{folder / "synchronized", folder / "since_epoch"};
  CHECK_FALSE(clock_is_set(evidence, kNow_s));  // neither is there
  put(evidence.rtc, std::to_string(kNow_s - 60) + "\n");
  CHECK(clock_is_set(evidence, kNow_s));
  put(evidence.rtc, "42\n");  // it has no battery
  CHECK_FALSE(clock_is_set(evidence, kNow_s));
  put(evidence.rtc, "");
  CHECK_FALSE(clock_is_set(evidence, kNow_s));
  put(evidence.synchronized, "");
  CHECK(clock_is_set(evidence, kNow_s));
}

}  // namespace
}  // namespace flotilla::target
