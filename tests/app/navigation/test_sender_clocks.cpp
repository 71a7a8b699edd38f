// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cstdlib>

#include "app/navigation/sender_clocks.hpp"

namespace flotilla::app {
namespace {

constexpr link::Address kMaker{1, 1};
constexpr std::int64_t kHour_us = 3'600'000'000;

/// Their clock is ahead_us ahead of ours; messages take delay_us each way.
struct Sender {
  link::Address from;
  std::int64_t ahead_us = 0, delay_us = 0;

  std::uint32_t stamp(std::int64_t us) const {
    return static_cast<std::uint32_t>((us + ahead_us) / 1000);
  }
  std::optional<SenderClocks::Stamp> speak(SenderClocks& clocks, std::int64_t us,
                                           std::uint8_t rank = 1) const {
    return clocks.heard(from, rank, stamp(us), us + delay_us);
  }
  void answer(SenderClocks& clocks, std::int64_t us) const {
    clocks.answered(from, us, us + delay_us + ahead_us, us + 2 * delay_us);
  }
};

TEST_CASE("TIMESYNC gives the time of sending, whatever the delay and the sender's clock") {
  for (const std::int64_t ahead_us : {0L, 7'200'000'000L, 4'294'967'000'000L}) {
    SenderClocks clocks;
    const Sender sender{kMaker, ahead_us, 200'000};
    sender.speak(clocks, 1'000'000);
    CHECK(sender.speak(clocks, 1'100'000)->us >= 1'290'000);  // unknown latency counts as 0
    CHECK_FALSE(sender.speak(clocks, 1'100'000)->timed);
    sender.answer(clocks, 1'200'000);
    for (std::int64_t us = 2'000'000; us < 9'000'000; us += 100'000) {
      const auto left = sender.speak(clocks, us);
      REQUIRE(left);
      CHECK(left->timed);
      CHECK(std::abs(left->us - us) < 2000);
      CHECK(left->least_us <= left->us - 195'000);  // one way may take the whole round trip
      if (us % 1'000'000 == 0) sender.answer(clocks, us);
    }
  }
}

TEST_CASE("no message is dated later than its arrival") {
  SenderClocks clocks;
  const Sender sender{kMaker, 0, 0};
  sender.speak(clocks, 1'000'000);
  clocks.answered(kMaker, 1'000'000, 900'000, 1'200'000);
  CHECK(sender.speak(clocks, 1'300'000)->us <= 1'300'000);
}

TEST_CASE("a configured latency is subtracted until TIMESYNC measures it") {
  SenderClocks clocks;
  clocks.set_lag(300'000);
  const Sender sender{kMaker, 0, 0};
  sender.speak(clocks, 1'000'000);
  const auto left = sender.speak(clocks, 1'100'000);
  CHECK(left->timed);
  CHECK(std::abs(left->us - 800'000) < 2000);
  sender.answer(clocks, 1'150'000);
  CHECK(std::abs(sender.speak(clocks, 1'200'000)->us - 1'200'000) < 2000);
}

TEST_CASE("a restarted sender is heard with its new clock") {
  SenderClocks clocks;
  const Sender before{kMaker, 500'000'000, 0}, after{kMaker, 0, 0};
  before.speak(clocks, 1'000'000);
  CHECK(std::abs(after.speak(clocks, 2'000'000)->us - 2'000'000) < 1000);
}

TEST_CASE("a message overtaken on a slower link is recognised as such") {
  SenderClocks clocks;
  const Sender fast{kMaker, 0, 20'000}, slow{kMaker, 0, 1'700'000};
  for (std::int64_t us = 10'000'000; us < 15'000'000; us += 100'000) {
    const auto first = fast.speak(clocks, us);
    REQUIRE(first);
    CHECK_FALSE(first->overtaken);
    CHECK(std::abs(first->us - us) <= 20'000);  // late copies do not count as a restarted clock
    if (us % 200'000 == 0) fast.answer(clocks, us);
    const auto copy = slow.speak(clocks, us - 1'700'000);
    REQUIRE(copy);
    CHECK(copy->overtaken);
    CHECK(copy->us <= us - 1'600'000);
  }
}

TEST_CASE("when the fast link is lost, messages of the slow one keep their true age") {
  SenderClocks clocks;
  clocks.set_lag(0);
  const Sender fast{kMaker, kHour_us, 0}, slow{kMaker, kHour_us, 6'000'000};
  for (std::int64_t us = 10'000'000; us < 40'000'000; us += 100'000) {
    if (us < 15'000'000) fast.speak(clocks, us);
    const auto copy = slow.speak(clocks, us - 6'000'000);
    REQUIRE(copy);
    REQUIRE((copy->overtaken || copy->us <= us - 5'980'000));
  }
}

TEST_CASE("with more senders than entries, those nearest to the root are kept") {
  SenderClocks clocks;
  const auto speak = [&](std::uint8_t system, std::uint8_t rank, std::int64_t us) {
    return Sender{{system, 1}, 0, 0}.speak(clocks, us, rank).has_value();
  };
  for (std::uint8_t system = 1; system <= 4; ++system) CHECK(speak(system, 5, 1'000'000));
  CHECK_FALSE(speak(9, 5, 1'000'000));
  CHECK_FALSE(speak(9, 6, 1'000'000));
  CHECK(speak(9, 4, 1'000'000));
  CHECK(speak(10, 0, 1'000'000));  // the leader
  CHECK(speak(10, 0, 1'100'000));
  // A silent sender makes room.
  CHECK_FALSE(speak(20, 9, 1'100'000));
  CHECK(speak(20, 9, 4'200'000));
}

}  // namespace
}  // namespace flotilla::app
