// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <random>

#include "app/schedule.hpp"

namespace flotilla::app {
namespace {

TEST_CASE(
    "a message of 10 Hz is sent ten times a second at a tick rate of 64 Hz, and never too early") {
  Schedule schedule(100'000);
  int sent = 0;
  for (std::int64_t now = 0; now < 10'000'000; now += 15'625)
    sent += schedule.take_if_due(now) ? 1 : 0;
  CHECK(sent == 100);
}

TEST_CASE("a loop's jitter of less than half a tick skips no turn and repeats none") {
  constexpr std::uint32_t kSeed = 51;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  Schedule schedule(20'000, 5'000);
  int sent = 0;
  for (std::int64_t k = 0; k < 1000; ++k) {
    const auto jitter = std::uniform_int_distribution<std::int64_t>(-4000, 4000)(random);
    sent += schedule.take_if_due(k * 10'000 + (k == 0 ? 0 : jitter)) ? 1 : 0;
  }
  CHECK(sent == 500);
}

TEST_CASE("after a gap one message is sent, not all that were missed") {
  Schedule schedule(100'000);
  CHECK(schedule.take_if_due(0));
  CHECK(schedule.take_if_due(60'000'000));
  CHECK_FALSE(schedule.take_if_due(60'000'001));
  CHECK_FALSE(schedule.take_if_due(60'099'999));
  CHECK(schedule.take_if_due(60'100'000));
}

TEST_CASE("while time stands still there is one message; an interval of zero means none") {
  Schedule schedule(100'000), never(0);
  CHECK(schedule.take_if_due(5));
  for (int i = 0; i < 10; ++i) CHECK_FALSE(schedule.take_if_due(5));
  for (std::int64_t now = 0; now < 1'000'000; now += 1000) CHECK_FALSE(never.take_if_due(now));
}

}  // namespace
}  // namespace flotilla::app
