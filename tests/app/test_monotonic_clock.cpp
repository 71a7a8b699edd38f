// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <limits>

#include "app/boat/monotonic_clock.hpp"

namespace flotilla::app {
namespace {

TEST_CASE(
    "host's clock set back for half a second: the boat's clock stands still until it catches up") {
  MonotonicClock clock;
  link::Counters counters;
  CHECK(clock.take(5'000'000, counters) == 5'000'000);
  CHECK(clock.take(4'000'000, counters) == 5'000'000);
  CHECK(clock.take(4'500'000, counters) == 5'000'000);
  CHECK(counters.clock_went_back == 2);
  CHECK(clock.take(5'000'001, counters) == 5'000'001);
}

TEST_CASE(
    "host's clock behind for more than a second: the boat's clock runs on from its last time") {
  MonotonicClock clock;
  link::Counters counters;
  clock.take(5'000'000, counters);
  CHECK(clock.take(1'000'000, counters) == 5'000'000);
  CHECK(clock.take(2'000'000, counters) == 5'000'000);
  CHECK(clock.take(2'000'001, counters) == 5'000'000);
  CHECK(clock.take(2'000'011, counters) == 5'000'010);
  CHECK(clock.now_us() == 5'000'010);
}

TEST_CASE("a negative time, or one beyond any real clock, is clamped") {
  MonotonicClock clock;
  link::Counters counters;
  CHECK(clock.take(-1, counters) == 0);
  CHECK(clock.take(std::numeric_limits<std::int64_t>::max(), counters) ==
        MonotonicClock::kLatest_us);
}

}  // namespace
}  // namespace flotilla::app
