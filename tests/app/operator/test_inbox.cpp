// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "app/operator/requests/inbox.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
constexpr std::size_t kHolds = 24;

PendingRequest pending(const RequestMessage& message, std::uint8_t link = 0,
                       std::int64_t read_us = 0) {
  return {read_us, message, {255, 190}, {1, 1}, link};
}
PendingRequest command(std::uint16_t id, float first = 0) {
  return pending(link::CommandLong{id, {first, 0, 0, 0, 0, 0, 0}, {1, 1}, 0});
}
/// A stop discards all requests that were kept.
template <class Answer>
bool take(Inbox& inbox, Answer answer) {
  return inbox.take_each(answer, [](const PendingRequest&) { return true; });
}
std::vector<PendingRequest> all(Inbox& inbox) {
  std::vector<PendingRequest> out;
  take(inbox, [&](const PendingRequest& pending) {
    out.push_back(pending);
    return Inbox::Taken::kAnswered;
  });
  return out;
}
std::uint16_t id_of(const PendingRequest& pending) { return command_of(pending.message)->id; }

TEST_CASE("requests are queued in order with link and time of reading; one too many is counted") {
  Inbox inbox;
  link::Counters counters;
  for (std::uint16_t i = 0; i < kHolds + 3; ++i) {
    PendingRequest one = command(i);
    one.link = static_cast<std::uint8_t>(i % 4U);
    one.read_us = i * 1000;
    inbox.push(one, counters);
  }
  const auto pending = all(inbox);
  REQUIRE(pending.size() == kHolds);
  for (std::uint16_t i = 0; i < kHolds; ++i) {
    CHECK(id_of(pending[i]) == i);
    CHECK(pending[i].link == i % 4U);
    CHECK(pending[i].read_us == i * 1000);
  }
  CHECK(counters.requests_dropped == 3);
  CHECK(all(inbox).empty());
  inbox.push(command(77), counters);
  const auto next = all(inbox);
  REQUIRE(next.size() == 1);
  CHECK(id_of(next[0]) == 77);
  CHECK(counters.requests_dropped == 3);
}

TEST_CASE("requests that are not answered in this tick keep their order for the next") {
  constexpr std::uint32_t kSeed = 9;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  using enum Inbox::Taken;
  Inbox inbox;
  link::Counters counters;
  std::vector<std::uint16_t> waiting;
  int lasts = 0, dropped = 0;
  for (std::uint16_t next = 0; next < 20'000;) {
    for (auto n = random() % 12; n > 0; --n) {
      if (waiting.size() < kHolds) {
        waiting.push_back(next);
      } else {
        ++dropped;
      }
      inbox.push(pending(link::CommandLong{next++, {1, 0, 0, 0, 0, 0, 0}, {1, 1}, 0}), counters);
    }
    std::vector<std::uint16_t> seen, kept;
    bool last = false;
    const bool said_last = take(inbox, [&](const PendingRequest& pending) {
      REQUIRE_FALSE(last);  // no request is answered after the last
      seen.push_back(id_of(pending));
      const auto chance = random() % 8;
      last = chance == 0;
      if (last) return kLast;
      if (chance < 6) return kAnswered;
      kept.push_back(id_of(pending));
      return kKept;
    });
    REQUIRE(said_last == last);
    lasts += last ? 1 : 0;
    REQUIRE(seen.size() <= waiting.size());
    REQUIRE(std::equal(seen.begin(), seen.end(), waiting.begin()));
    if (!last) REQUIRE(seen.size() == waiting.size());
    kept.insert(kept.end(), waiting.begin() + static_cast<std::ptrdiff_t>(seen.size()),
                waiting.end());
    waiting = kept;
  }
  CHECK(lasts > 1000);
  CHECK(dropped > 100);
  CHECK(counters.requests_dropped == static_cast<std::uint32_t>(dropped));
}

TEST_CASE("an inbox is empty after its only request was taken as the tick's last") {
  using enum Inbox::Taken;
  Inbox inbox;
  link::Counters counters;
  CHECK_FALSE(take(inbox, [](const PendingRequest&) { return kLast; }));
  inbox.push(command(5), counters);
  inbox.push(command(6), counters);
  CHECK(take(inbox, [](const PendingRequest&) { return kLast; }));
  CHECK(take(inbox, [](const PendingRequest& one) { return id_of(one) == 6 ? kLast : kAnswered; }));
  CHECK(all(inbox).empty());
}

TEST_CASE("a stop cancels the requests before it, and leaves those behind it for later") {
  using enum Inbox::Taken;
  Inbox inbox;
  link::Counters counters;
  for (std::uint16_t i = 0; i < 9; ++i) inbox.push(command(i), counters);
  CHECK(take(inbox, [](const PendingRequest& one) {
    if (id_of(one) == 4) return kStop;
    return id_of(one) % 2 == 0 ? kKept : kAnswered;
  }));
  const auto left = all(inbox);
  REQUIRE(left.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(id_of(left[i]) == 5 + i);
}

PendingRequest hold() {
  return pending(link::CommandLong{mav::kCmdDoSetMode, {1, 4, 0, 0, 0, 0, 0}, {1, 1}, 0});
}

/// Disarms, terminations and HOLD, in either form.
PendingRequest stop(std::size_t any) {
  if (any / 4 % 3 == 0) return hold();
  const bool terminate = any % 2 == 0;
  const std::uint16_t id = terminate ? mav::kCmdDoFlightTermination : mav::kCmdComponentArmDisarm;
  const float first = terminate ? 1 : 0;
  if (any / 2 % 2 == 0) return command(id, first);
  return pending(link::CommandInt{id, {first, 0, 0, 0}, 0, 0, 0, {1, 1}, 0});
}
// read_us numbers the letters.
TEST_CASE("no stop is ever lost in a full inbox, nor answered before earlier requests") {
  constexpr std::uint32_t kSeed = 10;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  using enum Inbox::Taken;
  Inbox inbox;
  link::Counters counters;
  std::size_t owed = 0, pushed = 0, taken = 0, stops_taken = 0;
  for (int tick = 0; tick < 5000; ++tick) {
    const std::size_t most = random() % 5 == 0 ? 60 : 10;
    for (auto n = random() % most; n > 0; --n) {
      PendingRequest one =
          random() % 8 == 0 ? stop(random()) : command(mav::kCmdComponentArmDisarm, 1);
      if (one.effects.stops && owed == kHolds) continue;  // enough stops are waiting already
      one.read_us = static_cast<std::int64_t>(++pushed);
      owed += one.effects.stops ? 1U : 0U;
      inbox.push(one, counters);
    }
    std::int64_t latest_other = 0, latest_stop = 0;
    take(inbox, [&](const PendingRequest& one) {
      if (one.effects.stops) {
        REQUIRE(one.read_us > latest_other);
        latest_stop = std::max(latest_stop, one.read_us);
      } else {
        REQUIRE(one.read_us > latest_other);
        REQUIRE(one.read_us > latest_stop);
        latest_other = one.read_us;
      }
      const auto chance = random() % 4;
      if (chance == 0) return kKept;
      ++taken;
      owed -= one.effects.stops ? 1U : 0U;
      stops_taken += one.effects.stops ? 1U : 0U;
      return chance == 1 && random() % 4 == 0 ? kLast : kAnswered;
    });
  }
  std::size_t left = 0;
  for (const PendingRequest& one : all(inbox)) {
    ++left;
    owed -= one.effects.stops ? 1U : 0U;
  }
  CHECK(owed == 0);
  CHECK(stops_taken > 1000);
  CHECK(pushed == taken + left + counters.requests_dropped);
}

TEST_CASE("a disarm is kept among any number of requests, wherever it stands") {
  constexpr std::uint32_t kSeed = 4;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int round = 0; round < 2000; ++round) {
    const std::size_t many = 1 + random() % 60;
    const std::size_t at = random() % many;
    const bool as_int = random() % 2 == 0;
    Inbox inbox;
    link::Counters counters;
    for (std::size_t i = 0; i < many; ++i) {
      if (i != at) {
        // Neither of these requests disarms.
        const bool arm = random() % 2 == 0;
        inbox.push(
            arm ? command(mav::kCmdComponentArmDisarm, 1) : pending(link::ParamRequestList{{1, 1}}),
            counters);
      } else if (as_int) {
        inbox.push(pending(link::CommandInt{
                       mav::kCmdComponentArmDisarm, {0, 0, 0, 0}, 0, 0, 0, {1, 1}, 0}),
                   counters);
      } else {
        inbox.push(command(mav::kCmdComponentArmDisarm, 0), counters);
      }
    }
    CAPTURE(many);
    CAPTURE(at);
    const auto pending = all(inbox);
    CHECK(pending.size() == std::min(many, kHolds));
    CHECK(counters.requests_dropped == many - pending.size());
    CHECK(std::count_if(pending.begin(), pending.end(), [](const PendingRequest& l) {
            const auto c = command_of(l.message);
            return c && is_disarm(*c);
          }) == 1);
  }
}

TEST_CASE("HOLD displaces no disarm, and displaces another request only if it is obeyed") {
  Inbox inbox;
  link::Counters counters;
  for (std::size_t i = 0; i < kHolds; ++i) inbox.push(command(7), counters);
  const PendingRequest strangers(0, hold().message, {255, 190}, {1, 1}, 0, false);
  CHECK_FALSE(strangers.effects.stops);
  inbox.push(strangers, counters);
  inbox.push(command(mav::kCmdComponentArmDisarm, 0), counters);
  for (std::size_t i = 0; i < 2 * kHolds; ++i) inbox.push(hold(), counters);
  auto kept = all(inbox);
  REQUIRE(kept.size() == kHolds);
  CHECK(id_of(kept[0]) == mav::kCmdComponentArmDisarm);
  CHECK(std::ranges::all_of(kept, [](const PendingRequest& one) { return one.effects.stops; }));
  for (std::size_t i = 0; i < 2 * kHolds; ++i) inbox.push(stop(6), counters);
  inbox.push(hold(), counters);
  kept = all(inbox);
  CHECK(std::ranges::all_of(kept, [](const PendingRequest& one) { return one.effects.ends; }));
}

TEST_CASE("of many stops the last one decides, however full the inbox was") {
  for (const std::size_t others : {std::size_t{0}, std::size_t{1}, std::size_t{5}, kHolds}) {
    Inbox inbox;
    link::Counters counters;
    for (std::size_t i = 0; i < others; ++i) inbox.push(command(7), counters);
    for (std::size_t i = 0; i < 2 * kHolds; ++i) {
      inbox.push(command(mav::kCmdDoFlightTermination, 1), counters);
    }
    inbox.push(command(mav::kCmdComponentArmDisarm, 0), counters);
    const auto pending = all(inbox);
    REQUIRE(pending.size() == kHolds);
    CHECK(id_of(pending.back()) == mav::kCmdComponentArmDisarm);
  }
}

}  // namespace
}  // namespace flotilla::app
