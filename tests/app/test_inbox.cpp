// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "app/inbox.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
constexpr std::size_t kHolds = 24;

Letter letter(const link::Message& message, std::size_t link = 0, std::int64_t read_us = 0) {
  return {link, {{255, 190}, message, {1, 1}}, read_us};
}
Letter command(std::uint16_t id, float first = 0) {
  return letter(link::CommandLong{id, {first, 0, 0, 0, 0, 0, 0}, {1, 1}, 0});
}
std::vector<Letter> all(Inbox& inbox) {
  std::vector<Letter> out;
  inbox.take_each([&](const Letter& letter) {
    out.push_back(letter);
    return true;
  });
  return out;
}
std::uint16_t id_of(const Letter& letter) { return command_of(letter.received.message)->id; }

TEST_CASE("requests wait in their order with link and time of reading; one too many is counted") {
  Inbox inbox;
  link::Counters counters;
  for (std::uint16_t i = 0; i < kHolds + 3; ++i) {
    Letter one = command(i);
    one.link = i % 4U;
    one.read_us = i * 1000;
    inbox.push(one, counters);
  }
  const auto letters = all(inbox);
  REQUIRE(letters.size() == kHolds);
  for (std::uint16_t i = 0; i < kHolds; ++i) {
    CHECK(id_of(letters[i]) == i);
    CHECK(letters[i].link == i % 4U);
    CHECK(letters[i].read_us == i * 1000);
  }
  CHECK(counters.requests_dropped == 3);
  CHECK(all(inbox).empty());
  inbox.push(command(77), counters);
  const auto next = all(inbox);
  REQUIRE(next.size() == 1);
  CHECK(id_of(next[0]) == 77);
  CHECK(counters.requests_dropped == 3);
}

TEST_CASE("what cannot be answered yet keeps its place before what comes later") {
  constexpr std::uint32_t kSeed = 9;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  Inbox inbox;
  link::Counters counters;
  std::vector<std::uint16_t> waiting;
  for (std::uint16_t next = 0; next < 20'000;) {
    for (auto n = random() % 12; n > 0; --n) {
      if (waiting.size() < kHolds) waiting.push_back(next);
      inbox.push(letter(link::CommandLong{next++, {1, 0, 0, 0, 0, 0, 0}, {1, 1}, 0}), counters);
    }
    std::vector<std::uint16_t> seen, kept;
    inbox.take_each([&](const Letter& letter) {
      seen.push_back(id_of(letter));
      if (random() % 3 == 0) return true;
      kept.push_back(id_of(letter));
      return false;
    });
    REQUIRE(seen == waiting);
    waiting = kept;
  }
}

TEST_CASE("among however many requests, wherever it stands, a disarm is kept") {
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
        // An arming is no disarm, whatever it is about.
        const bool arm = random() % 2 == 0;
        inbox.push(
            arm ? command(mav::kCmdComponentArmDisarm, 1) : letter(link::ParamRequestList{{1, 1}}),
            counters);
      } else if (as_int) {
        inbox.push(
            letter(link::CommandInt{mav::kCmdComponentArmDisarm, {0, 0, 0, 0}, 0, 0, 0, {1, 1}, 0}),
            counters);
      } else {
        inbox.push(command(mav::kCmdComponentArmDisarm, 0), counters);
      }
    }
    CAPTURE(many);
    CAPTURE(at);
    const auto letters = all(inbox);
    CHECK(letters.size() == std::min(many, kHolds));
    CHECK(counters.requests_dropped == many - letters.size());
    CHECK(std::count_if(letters.begin(), letters.end(), [](const Letter& l) {
            const auto c = command_of(l.received.message);
            return c && is_disarm(*c);
          }) == 1);
  }
}

}  // namespace
}  // namespace flotilla::app
