// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <list>
#include <random>

#include "app/operator/router.hpp"

namespace flotilla::app {
namespace {

using Room = std::array<Router::Link, 4>;
constexpr std::int64_t kNow_us = 5'000'000, kGone_us = 10'000'000;

TEST_CASE("a message is forwarded where its target was heard, and never to unknown targets") {
  Room room;
  Router router(room);
  router.heard({2, 1}, 1, kNow_us);
  router.heard({2, 191}, 2, kNow_us);
  CHECK(router.beyond({2, 1}, 0, kNow_us) == 0b010);
  CHECK(router.beyond({2, 191}, 0, kNow_us) == 0b100);
  CHECK(router.beyond({2, 0}, 0, kNow_us) == 0b110);
  CHECK(router.beyond({2, 7}, 0, kNow_us) == 0);
  CHECK(router.beyond({3, 0}, 0, kNow_us) == 0);
}

TEST_CASE(
    "a system is reached on each link where one of its components was heard in the last 10 s") {
  Room room;
  Router router(room);
  router.heard({2, 1}, 1, kNow_us);
  router.heard({2, 191}, 2, kNow_us + kGone_us);
  CHECK(router.links_to({2, 0}, kNow_us + 1) == 0b110);
  CHECK(router.links_to({2, 1}, kNow_us + 1) == 0b010);
  CHECK(router.links_to({2, 0}, kNow_us + kGone_us) == 0b100);
  CHECK(router.links_to({3, 0}, kNow_us) == 0);
  CHECK(router.links_to({0, 0}, kNow_us) == 0);
}

TEST_CASE("broadcasts are not forwarded") {
  Room room;
  Router router(room);
  for (std::uint8_t system = 0; system < 20; ++system) router.heard({system, 1}, 1, kNow_us);
  CHECK(router.beyond({0, 0}, 0, kNow_us) == 0);
  CHECK(router.beyond({0, 1}, 0, kNow_us) == 0);
}

TEST_CASE("a message whose target is on the link it came from is not forwarded") {
  Room room;
  Router router(room);
  router.heard({2, 1}, 1, kNow_us);
  CHECK(router.beyond({2, 1}, 1, kNow_us) == 0);
  router.heard({2, 1}, 3, kNow_us);
  CHECK(router.beyond({2, 1}, 0, kNow_us) == 0b1010);
  CHECK(router.beyond({2, 1}, 1, kNow_us) == 0);
  CHECK(router.beyond({2, 1}, 3, kNow_us) == 0);
}

TEST_CASE("a system silent for ten seconds is forgotten, on each link separately") {
  Room room;
  Router router(room);
  router.heard({2, 1}, 1, 0);
  router.heard({2, 1}, 2, 4'000'000);
  CHECK(router.beyond({2, 1}, 0, kGone_us - 1) == 0b110);
  CHECK(router.beyond({2, 1}, 1, kGone_us - 1) == 0);
  CHECK(router.beyond({2, 1}, 0, kGone_us) == 0b100);
  CHECK(router.beyond({2, 1}, 1, kGone_us) == 0b100);  // no longer heard on its link
  CHECK(router.beyond({2, 0}, 0, kGone_us + 4'000'000) == 0);
  router.heard({2, 1}, 1, 2 * kGone_us);
  CHECK(router.beyond({2, 1}, 0, 2 * kGone_us) == 0b010);
}

TEST_CASE("a system heard at clock time 0 counts as heard") {
  Room room;
  Router router(room);
  router.heard({0, 0}, 3, 0);
  router.heard({2, 1}, 1, 0);
  CHECK(router.beyond({2, 1}, 0, 0) == 0b010);
}

/// The oracle: the same by plain lists, with the place heard last at the end.
struct Model {
  struct Place {
    link::Address who;
    std::array<std::int64_t, 4> heard_us;
  };
  std::list<Place> places;

  void heard(link::Address from, std::size_t link, std::int64_t now_us) {
    Place place{from, {-kGone_us, -kGone_us, -kGone_us, -kGone_us}};
    const auto at =
        std::find_if(places.begin(), places.end(), [&](const Place& p) { return p.who == from; });
    if (at != places.end()) {
      place = *at;
      places.erase(at);
    } else if (places.size() == 32) {
      places.pop_front();
    }
    place.heard_us[link] = now_us;
    places.push_back(place);
  }
  unsigned beyond(link::Address target, std::size_t from_link, std::int64_t now_us) const {
    unsigned links = 0;
    for (const Place& p : places) {
      if (target.system != 0 && p.who.system == target.system &&
          (target.component == 0 || p.who.component == target.component)) {
        for (std::size_t link = 0; link < 4; ++link) {
          if (now_us - p.heard_us[link] < kGone_us) links |= 1U << link;
        }
      }
    }
    return (links >> from_link & 1U) != 0 ? 0 : links;
  }
};

TEST_CASE("from the 33rd sender on, the one silent for longest is forgotten") {
  constexpr std::uint32_t kSeed = 8;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  Room room;
  Router router(room);
  Model model;
  std::int64_t now_us = 0;
  for (int k = 0; k < 20'000; ++k) {
    const auto any = [&] {
      return link::Address{static_cast<std::uint8_t>(random() % 12),
                           static_cast<std::uint8_t>(random() % 5)};
    };
    const link::Address from = any(), target = any();
    const std::size_t link = random() % 4;
    const auto hear = [&](link::Address who) {
      ++now_us;
      router.heard(who, link, now_us);
      model.heard(who, link, now_us);
    };
    now_us += static_cast<std::int64_t>(random() % 400'000);
    // Sometimes a fleet passes by, or all senders are silent for a while.
    if (random() % 500 == 0) {
      for (std::uint8_t s = 100; s < 100 + random() % 40; ++s) hear({s, 1});
    }
    if (random() % 500 == 0) now_us += static_cast<std::int64_t>(random() % 15'000'000);
    hear(from);
    for (std::size_t from_link = 0; from_link < 4; ++from_link) {
      REQUIRE(router.beyond(target, from_link, now_us) == model.beyond(target, from_link, now_us));
    }
  }
}

}  // namespace
}  // namespace flotilla::app
