// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "app/navigation/namesake.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000, kStart_us = 9'000 * kSecond_us;

/// The time of a clock that started `began_s` after the boat's.
std::uint32_t clock_ms(std::int64_t now_us, std::int64_t began_s) {
  return static_cast<std::uint32_t>((now_us - began_s * kSecond_us) / 1000);
}

TEST_CASE(
    "a second vessel with the same id is noticed in 2 s, and forgotten 10 s after it leaves") {
  for (const std::int64_t apart_s : {-8000, -6, 6, 8000}) {
    Namesake leader;
    std::int64_t now_us = kStart_us;
    for (int k = 0; k < 40; ++k, now_us += kSecond_us / 10) {
      CHECK_FALSE(leader.seen(now_us));
      leader.hear(clock_ms(now_us, 0), now_us);
    }
    for (int k = 0; k < 4; ++k, now_us += kSecond_us / 2) {
      leader.hear(clock_ms(now_us, apart_s), now_us);
      leader.hear(clock_ms(now_us, 0), now_us);
    }
    CAPTURE(apart_s);
    CHECK(leader.seen(now_us));
    const std::int64_t last_us = now_us - kSecond_us / 2;
    CHECK(leader.seen(last_us + 10 * kSecond_us - 1));
    CHECK_FALSE(leader.seen(last_us + 10 * kSecond_us));
  }
}

TEST_CASE("one vessel's reboots, late messages, clock drift and 49-day wrap are no second vessel") {
  Namesake leader;
  std::int64_t began_s = 0, now_us = kStart_us;
  for (int k = 0; k < 100'000; ++k, now_us += kSecond_us / 10) {
    if (k % 1000 == 999) began_s = now_us / kSecond_us;
    std::uint32_t drifted_ms = clock_ms(now_us, began_s) + static_cast<std::uint32_t>(k / 100);
    if (k < 500) drifted_ms -= 9'020'000;  // turns at k = 200
    leader.hear(drifted_ms, now_us);
    if (k % 170 == 5) leader.hear(drifted_ms - 7'000, now_us);  // a message that was delayed by 7 s
    if (k % 200 == 7) leader.hear(drifted_ms - 4'000, now_us);
    REQUIRE_FALSE(leader.seen(now_us));
  }
}

}  // namespace
}  // namespace flotilla::app
