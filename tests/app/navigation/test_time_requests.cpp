// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "app/navigation/time_requests.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("an answer counts for one of the last 32 requests, and for no other number") {
  TimeRequests time;
  CHECK_FALSE(time.sent_us({1, 0}).has_value());
  for (std::int64_t second = 0; second < 100; ++second) {
    const std::int64_t now_us = 1'234'567 + second * 1'000'000;
    const link::Timesync request = time.ask(now_us, 7);
    CHECK(request.tc1 == 0);
    for (std::int64_t ago = 0; ago <= second && ago < 40; ++ago) {
      const std::int64_t sent_us = now_us - ago * 1'000'000;
      const auto found = time.sent_us({55, request.ts1 - ago * 1'000'000'000});
      CHECK(found == (ago < 32 ? std::optional(sent_us) : std::nullopt));
    }
    CHECK_FALSE(time.sent_us({55, request.ts1 + 1}).has_value());
  }
}

TEST_CASE("two boats that ask in the same microsecond ask with different numbers") {
  for (std::uint8_t system = 2; system < 255; ++system) {
    TimeRequests ours, theirs;
    ours.ask(5'000'000, 1);
    CHECK_FALSE(ours.sent_us({55, theirs.ask(5'000'000, system).ts1}).has_value());
  }
}

TEST_CASE("an answer gives the time the request was read, its sender, and his number") {
  const link::Timesync answer = TimeRequests::answer_to({0, -42}, {9, 8}, 1'000'001);
  CHECK(answer.tc1 == 1'000'001'000);
  CHECK(answer.ts1 == -42);
  CHECK(answer.target == link::Address{9, 8});
}

}  // namespace
}  // namespace flotilla::app
