// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "app/navigation/stamp_filter.hpp"

namespace flotilla::app {
namespace {

using Verdict = StampFilter::Verdict;
constexpr std::int64_t kHour_us = 3'600'000'000, kPeriod_us = 100'000;

/// Has accepted the stamp of an hour, at 1 s.
StampFilter after_an_hour() {
  StampFilter filter;
  filter.accept(kHour_us, 0, 1'000'000);
  return filter;
}

TEST_CASE("the first stamp is accepted whatever it is, as is the first one after a reset") {
  StampFilter filter;
  for (const std::int64_t stamp_us : {std::int64_t{0}, kHour_us, std::int64_t{5}}) {
    CHECK(filter.judge(stamp_us, 1'000'000) == Verdict::kNext);
    filter.accept(stamp_us, 0, 1'000'000);
    CHECK(filter.judge(stamp_us, 1'000'000) == Verdict::kLate);
    filter.forget();
  }
}

TEST_CASE(
    "a stamp that is not newer is late; over 1 s off, the clock was set; over 10 min, it wrapped") {
  const StampFilter filter = after_an_hour();
  const auto judged = [&](std::int64_t later_us, std::int64_t after_us) {
    return filter.judge(kHour_us + later_us, 1'000'000 + after_us);
  };
  CHECK(judged(0, 50'000) == Verdict::kLate);
  CHECK(judged(-kHour_us, 50'000) == Verdict::kLate);
  CHECK(judged(1, 50'000) == Verdict::kNext);
  CHECK(judged(1'050'000, 50'000) == Verdict::kNext);
  CHECK(judged(1'050'001, 50'000) == Verdict::kSet);
  CHECK(judged(1, 1'000'002) == Verdict::kSet);
  CHECK(judged(600'050'000, 50'000) == Verdict::kSet);
  CHECK(judged(600'050'001, 50'000) == Verdict::kWrapped);
  CHECK(judged(kHour_us, kHour_us) == Verdict::kNext);  // an hour of silence is no leap
}

TEST_CASE("a vessel has rebooted when old stamps advance and nothing newer came for a second") {
  StampFilter filter = after_an_hour();
  for (std::int64_t t = kPeriod_us; t <= 1'000'000; t += kPeriod_us) {
    REQUIRE(filter.judge(t, 1'000'000 + t) == Verdict::kLate);
    filter.refuse(t);
  }
  CHECK(filter.judge(1'000'000, 2'100'000) == Verdict::kLate);  // repeated
  CHECK(filter.judge(900'000, 2'100'000) == Verdict::kLate);    // goes back
  CHECK(filter.judge(kHour_us, 2'100'000) == Verdict::kLate);   // the last good one, late
  CHECK(filter.judge(1'100'000, 2'100'000) == Verdict::kRestarted);
}

TEST_CASE("old stamps are only late, unless a reboot explains them or they go back over a minute") {
  const auto judged = [](std::int64_t back_us, std::int64_t silent_us) {
    StampFilter filter = after_an_hour();
    const std::int64_t stamp_us = kHour_us + silent_us - back_us;
    filter.refuse(stamp_us - kPeriod_us);
    return filter.judge(stamp_us, 1'000'000 + silent_us);
  };
  CHECK(judged(6'000'000, 2'000'000) == Verdict::kLate);
  CHECK(judged(59'000'000, 50'000'000) == Verdict::kLate);
  CHECK(judged(63'000'000, 2'000'000) == Verdict::kRestarted);
  StampFilter young;
  young.accept(9'000'000, 0, 10'000'000);
  young.refuse(1'000'000);
  CHECK(young.judge(1'100'000, 11'050'000) == Verdict::kLate);
  CHECK(young.judge(1'100'000, 11'100'000) == Verdict::kRestarted);
}

TEST_CASE("the first old stamp is no reboot, however long the vessel was silent") {
  CHECK(after_an_hour().judge(5, kHour_us) == Verdict::kLate);
}

TEST_CASE("three late states in order, and none accepted: states count as regularly late") {
  StampFilter filter = after_an_hour();
  for (const std::int64_t stamp_us : {3, 4, 2, 3}) {
    filter.refuse(stamp_us);
    CHECK_FALSE(filter.regularly_late());
  }
  filter.refuse(4);
  CHECK(filter.regularly_late());
  filter.accept(kHour_us + 1, 0, 1'100'000);
  CHECK_FALSE(filter.regularly_late());
}

}  // namespace
}  // namespace flotilla::app
