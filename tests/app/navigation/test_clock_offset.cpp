// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "app/navigation/clock_offset.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kHour_us = 3'600'000'000;

/// Their clock: offset and drift. The radio: least delay, and mean additional delay, each way.
struct Radio {
  std::int64_t offset_us = 0;  ///< our time − their time, at time 0
  double drift_ppm = 0;
  std::int64_t delay_us = 0;
  double jitter_us = 0;
  std::mt19937 random{61};

  std::int64_t theirs(std::int64_t ours) const {
    return ours - offset_us +
           static_cast<std::int64_t>(static_cast<double>(ours) * drift_ppm * 1e-6);
  }
  std::int64_t way_us() {
    if (jitter_us <= 0) return delay_us;
    return delay_us +
           static_cast<std::int64_t>(std::exponential_distribution<double>(1 / jitter_us)(random));
  }
  /// Messages at 20 Hz and one TIMESYNC exchange a second, in order of sending.
  void talk(ClockOffset& clock, std::int64_t from_us, std::int64_t until_us, bool timesync) {
    for (std::int64_t t = from_us; t < until_us; t += 50'000) {
      clock.heard(theirs(t), t + way_us());
      if (timesync && t % 1'000'000 == 0) {
        const std::int64_t read = t + way_us();
        clock.answered(t, theirs(read), read + way_us());
      }
    }
  }
  double error_ms(const ClockOffset& clock, std::int64_t now_us) const {
    return static_cast<double>(*clock.offset_us() - (now_us - theirs(now_us))) * 1e-3;
  }
};

TEST_CASE("the clock offset is unknown before the first message and after a reset") {
  ClockOffset clock;
  CHECK_FALSE(clock.offset_us());
  clock.answered(1, 2, 3);
  CHECK_FALSE(clock.offset_us());
  clock.heard(5, 7);
  CHECK(clock.offset_us());
  clock.reset();
  CHECK_FALSE(clock.offset_us());
}

TEST_CASE("without TIMESYNC, an offset of hours is known up to the shortest transit time") {
  for (const std::int64_t offset : {-5 * kHour_us, std::int64_t{0}, 7 * kHour_us}) {
    Radio radio{offset, 0, 20'000, 50'000.0};
    ClockOffset clock;
    radio.talk(clock, 0, 10'000'000, false);
    CHECK(radio.error_ms(clock, 10'000'000) >= 20);
    CHECK(radio.error_ms(clock, 10'000'000) < 25);
  }
}

TEST_CASE("TIMESYNC over a symmetric radio gives the exact offset, apart from the allowed drift") {
  Radio radio{3 * kHour_us, 0, 80'000, 0.0};
  ClockOffset clock;
  radio.talk(clock, 0, 3'000'000, true);
  CHECK(std::abs(radio.error_ms(clock, 3'000'000)) < 0.1);
}

TEST_CASE("100 ms jitter, 20 ppm clock drift: the offset's error stays below 60 ms for an hour") {
  for (const double drift : {-20.0, 20.0}) {
    Radio radio{-2 * kHour_us, drift, 10'000, 100'000.0};
    ClockOffset clock;
    for (std::int64_t t = 0; t < kHour_us; t += 10'000'000) {
      radio.talk(clock, t, t + 10'000'000, true);
      if (t > 0) REQUIRE(std::abs(radio.error_ms(clock, t + 10'000'000)) < 60);
    }
  }
}

TEST_CASE("steady radio, 20 ppm clock drift: the offset's error stays below 0.5 ms for an hour") {
  for (const double drift : {-20.0, 20.0}) {
    Radio radio{kHour_us, drift, 30'000, 0.0};
    ClockOffset clock;
    for (std::int64_t t = 0; t < kHour_us; t += 10'000'000) {
      radio.talk(clock, t, t + 10'000'000, true);
      REQUIRE(std::abs(radio.error_ms(clock, t + 10'000'000)) < 0.5);
    }
  }
}

TEST_CASE(
    "an answer bounds the offset, however long it took, if it shows the same clock as the stamps") {
  for (const std::int64_t delay_us : {0L, 2'400'000L, 10'000'000L, 15'000'000L}) {
    Radio radio{kHour_us, 0, delay_us, 0.0};
    ClockOffset clock;
    radio.talk(clock, 0, 3'000'000, true);
    CHECK(clock.was_answered());
    CHECK(std::abs(*clock.least_us() - (kHour_us - delay_us)) < 1000);
  }
}

TEST_CASE("answers that contradict the stamps remove the lower bound until answers agree again") {
  for (const std::int64_t apart_us : {-1'700'000'000'000'000L, -50'000'000L, 500'000L, kHour_us}) {
    Radio radio{0, 0, 10'000, 0.0};
    ClockOffset clock;
    radio.talk(clock, 0, 2'000'000, true);
    CHECK(clock.was_answered());
    for (std::int64_t t = 2'000'000; t < 9'000'000; t += 50'000) {
      clock.heard(radio.theirs(t), t + radio.way_us());
      if (t % 1'000'000 != 0) continue;
      clock.answered(t, radio.theirs(t) - apart_us, t + 20'000);
      CHECK_FALSE(clock.was_answered());
      CHECK(clock.offset_us());
    }
    radio.talk(clock, 9'000'000, 11'000'000, true);
    CHECK(clock.was_answered());
    CHECK(std::abs(radio.error_ms(clock, 11'000'000)) < 1);
  }
}

TEST_CASE(
    "a clock that is set forward is followed at once, one that is set back within two windows") {
  Radio radio{0, 0, 10'000, 0.0};
  ClockOffset clock;
  radio.talk(clock, 0, 20'000'000, true);
  radio.offset_us -= kHour_us;  // their clock shows an hour more
  radio.talk(clock, 20'000'000, 21'000'000, false);
  CHECK(std::abs(radio.error_ms(clock, 21'000'000)) <= 10.001);
  radio.talk(clock, 21'000'000, 40'000'000, true);
  radio.offset_us += 2 * kHour_us;
  radio.talk(clock, 40'000'000, 51'000'000, true);
  CHECK(std::abs(radio.error_ms(clock, 51'000'000)) <= 10.001);
}

TEST_CASE("a clock that is set ahead and back between two answers is known again") {
  Radio radio{0, 0, 10'000, 0.0};
  ClockOffset clock;
  radio.talk(clock, 0, 20'050'000, true);
  radio.offset_us -= kHour_us;
  radio.talk(clock, 20'050'000, 20'450'000, true);
  radio.offset_us += kHour_us;
  radio.talk(clock, 20'450'000, 23'000'000, true);
  CHECK(clock.was_answered());
  CHECK(std::abs(radio.error_ms(clock, 23'000'000)) < 1);
}

/// A sender whose messages take to_us, while ours take fro_us. Its clock gains by drift and steps.
/// Checks after each message that the message does not count as younger than it is.
struct Late {
  std::int64_t to_us, fro_us;
  double drift = 0;
  std::int64_t ahead_us = 0, set_us = 0;  ///< the clock was set ahead by that much, at that time
  std::int64_t now_us = 0;
  ClockOffset clock{};

  std::int64_t theirs(std::int64_t us) const {
    return us + static_cast<std::int64_t>(drift * static_cast<double>(us)) +
           (us < set_us ? 0 : ahead_us);
  }
  /// The true age of a message that arrives now, minus the greatest age that the clock allows.
  std::int64_t missing_us() const {
    return theirs(now_us - to_us) + *clock.least_us() - (now_us - to_us);
  }
  std::int64_t talk(double seconds) {
    std::int64_t worst_us = 0;
    for (const auto end_us = now_us + static_cast<std::int64_t>(1e6 * seconds); now_us < end_us;
         now_us += 50'000) {
      const std::int64_t sent_us = now_us - to_us;
      clock.heard(theirs(sent_us), now_us);
      if (now_us % 1'000'000 == 0) {
        clock.answered(sent_us - fro_us, theirs(sent_us), now_us);
      }
      if (clock.was_answered()) worst_us = std::max(worst_us, missing_us());
    }
    return worst_us;
  }
  void set_ahead(std::int64_t by_us) {
    const std::int64_t before_us = theirs(now_us);
    set_us = now_us;
    ahead_us = 0;
    ahead_us = before_us + by_us - theirs(now_us);
    now_us += to_us;
  }
};

TEST_CASE(
    "late messages do not look younger after their sender's clock was set ahead once or twice") {
  for (const auto& [to_us, fro_us, step_us] :
       {std::array{1'900'000L, 100'000L, 1'900'000L}, std::array{1'900'000L, 100'000L, 900'000L},
        std::array{5'000'000L, 5'000'000L, 9'900'000L},
        std::array{3'000'000L, 50'000L, 3'000'000L}}) {
    Late late{to_us, fro_us};
    CHECK(late.talk(20) <= 1000);
    for (int step = 0; step < 2; ++step) {
      late.set_ahead(step_us);
      CHECK(late.talk(20) <= 1000);
      CHECK(late.clock.was_answered());
    }
  }
}

TEST_CASE("late messages do not look younger while their sender's clock runs fast") {
  for (const auto& [drift, fro_us] :
       {std::pair{0.01, 1'200'000L}, std::pair{0.001, 100'000L}, std::pair{0.01, 0L}}) {
    Late late{1'200'000, fro_us, drift};
    CHECK(late.talk(600) <= 1000);
    CHECK(late.clock.was_answered());
  }
}

TEST_CASE("late messages do not count as prompt when their sender's clock is set ahead") {
  constexpr std::int64_t kLate_us = 10'000'000, kSet_us = 9'900'000, kEvery_us = 100'000;
  ClockOffset clock;
  Radio radio{.offset_us = kHour_us, .delay_us = 100'000};
  radio.talk(clock, 0, 20'000'000, true);
  const auto heard = [&](std::int64_t sent_us, std::int64_t set_us, std::int64_t delay_us) {
    const std::int64_t stamp = radio.theirs(sent_us) + set_us;
    clock.heard(stamp, sent_us + delay_us);
    return sent_us + delay_us - (stamp + *clock.least_us());
  };
  std::int64_t t = 20'000'000;
  for (; t < 40'000'000; t += kEvery_us) CHECK(heard(t, 0, kLate_us) >= kLate_us);
  const std::int64_t set_at = t;
  for (; t < 60'000'000; t += kEvery_us) CHECK(heard(t, kSet_us, kLate_us) >= kLate_us);

  SUBCASE("and an answer read by the old clock changes nothing") {
    clock.answered(set_at - kLate_us, radio.theirs(set_at - kEvery_us), t);
    CHECK(heard(t, kSet_us, kLate_us) >= kLate_us);
  }
  SUBCASE("nor does an answer that comes as late as they do") {
    clock.answered(t, radio.theirs(t + kLate_us) + kSet_us, t + 2 * kLate_us);
    CHECK(heard(t + kLate_us + kEvery_us, kSet_us, kLate_us) >= kLate_us);
  }
  SUBCASE("until both are prompt again") {
    t += 2 * kLate_us;
    heard(t, kSet_us, 100'000);
    const std::int64_t asked = t + 200'000;
    clock.answered(asked, radio.theirs(asked + 100'000) + kSet_us, asked + 200'000);
    CHECK(heard(asked + 300'000, kSet_us, 100'000) < 500'000);
  }
}

TEST_CASE("messages that were held up and come in time again are known by the next answer") {
  ClockOffset clock;
  Radio radio{.offset_us = kHour_us, .delay_us = 50'000};
  radio.talk(clock, 0, 20'000'000, true);
  clock.heard(radio.theirs(20'000'000), 22'000'000);
  clock.heard(radio.theirs(22'000'000), 22'050'000);
  CHECK(22'050'000 - (radio.theirs(22'000'000) + *clock.least_us()) > 1'900'000);
  clock.answered(22'100'000, radio.theirs(22'150'000), 22'200'000);
  CHECK(22'200'000 - (radio.theirs(22'150'000) + *clock.least_us()) < 200'000);
}

TEST_CASE("a clock that is set back and ahead again is known after 32 answers") {
  Late late{1'900'000, 100'000};
  late.talk(40);
  late.set_ahead(-1'900'000);
  late.talk(40);
  late.set_ahead(1'900'000);
  late.talk(33);
  CHECK(late.missing_us() <= 1000);
  CHECK(late.clock.was_answered());
}

TEST_CASE("when messages get faster, the offset keeps its lower bound without a new answer") {
  Late late{1'900'000, 100'000};
  late.talk(5);
  late.to_us = 100'000;
  late.clock.heard(late.theirs(late.now_us - late.to_us), late.now_us);
  CHECK(late.clock.was_answered());
}

TEST_CASE(
    "hours after the last answer, prompt messages still count as prompt, and late ones as late") {
  for (const double drift : {-50.0, 0.0, 50.0}) {
    CAPTURE(drift);
    Radio radio{kHour_us, drift, 30'000, 20'000.0};
    const auto greatest_age_us = [&](const ClockOffset& clock, std::int64_t sent_us) {
      return sent_us + radio.delay_us - (radio.theirs(sent_us) + *clock.least_us());
    };
    ClockOffset clock;
    radio.talk(clock, 0, 20'000'000, true);
    CHECK(clock.is_answered());
    radio.talk(clock, 20'000'000, 5 * kHour_us, false);
    CHECK(clock.was_answered());
    CHECK_FALSE(clock.is_answered());
    CHECK(greatest_age_us(clock, 5 * kHour_us) >= radio.delay_us);
    CHECK(greatest_age_us(clock, 5 * kHour_us) < 150'000);
    radio.delay_us = 700'000;
    radio.talk(clock, 5 * kHour_us, 5 * kHour_us + 600'000'000, false);
    CHECK(greatest_age_us(clock, 5 * kHour_us + 600'000'000) > 600'000);
  }
}

TEST_CASE("an answer counts as recent for a minute") {
  Radio radio;
  ClockOffset clock;
  radio.talk(clock, 0, 20'000'000, true);
  radio.talk(clock, 20'000'000, 78'000'000, false);
  CHECK(clock.is_answered());
  radio.talk(clock, 78'000'000, 81'000'000, false);
  CHECK_FALSE(clock.is_answered());
  radio.talk(clock, 81'000'000, 83'000'000, true);
  CHECK(clock.is_answered());
}

TEST_CASE("an answer of an hour ago counts no more than the drift since then allows") {
  ClockOffset c;
  c.heard(0, 0);
  c.answered(0, 0, 0);
  c.heard(kHour_us - 200'000, kHour_us);
  c.answered(kHour_us - 200'000, kHour_us, kHour_us);
  CHECK(*c.least_us() <= 0);
}

}  // namespace
}  // namespace flotilla::app
