// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <list>
#include <random>

#include "app/router.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("a message goes on to where its addressee was heard, and never to who is unknown") {
  Router router;
  router.heard({2, 1}, 1);
  router.heard({2, 191}, 2);
  CHECK(router.beyond({2, 1}, 0) == 0b010);
  CHECK(router.beyond({2, 191}, 0) == 0b100);
  CHECK(router.beyond({2, 0}, 0) == 0b110);
  CHECK(router.beyond({2, 7}, 0) == 0);
  CHECK(router.beyond({3, 0}, 0) == 0);
}

TEST_CASE("broadcasts are not handed on") {
  Router router;
  for (std::uint8_t system = 0; system < 20; ++system) router.heard({system, 1}, 1);
  CHECK(router.beyond({0, 0}, 0) == 0);
  CHECK(router.beyond({0, 1}, 0) == 0);
}

TEST_CASE("what its addressee hears anyway, on the link that it came by, is not handed on") {
  Router router;
  router.heard({2, 1}, 1);
  CHECK(router.beyond({2, 1}, 1) == 0);
  router.heard({2, 1}, 3);
  CHECK(router.beyond({2, 1}, 0) == 0b1010);
  CHECK(router.beyond({2, 1}, 1) == 0);
  CHECK(router.beyond({2, 1}, 3) == 0);
}

/// The same by plain lists: the place that was heard last stands last.
struct Model {
  struct Place {
    link::Address who;
    unsigned links;
  };
  std::list<Place> places;

  void heard(link::Address from, std::size_t link) {
    Place place{from, 1U << link};
    const auto at =
        std::find_if(places.begin(), places.end(), [&](const Place& p) { return p.who == from; });
    if (at != places.end()) {
      place.links |= at->links;
      places.erase(at);
    } else if (places.size() == 32) {
      places.pop_front();
    }
    places.push_back(place);
  }
  unsigned beyond(link::Address target, std::size_t from_link) const {
    unsigned links = 0;
    for (const Place& p : places) {
      if (target.system != 0 && p.who.system == target.system &&
          (target.component == 0 || p.who.component == target.component)) {
        links |= p.links;
      }
    }
    return (links >> from_link & 1U) != 0 ? 0 : links;
  }
};

TEST_CASE("of the 33rd sender on, the one unheard for longest is forgotten") {
  constexpr std::uint32_t kSeed = 8;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  Router router;
  Model model;
  for (int k = 0; k < 20'000; ++k) {
    const auto any = [&] {
      return link::Address{static_cast<std::uint8_t>(random() % 12),
                           static_cast<std::uint8_t>(random() % 5)};
    };
    const link::Address from = any(), target = any();
    const std::size_t link = random() % 4;
    // Now and then a fleet passes by.
    if (random() % 500 == 0) {
      for (std::uint8_t s = 100; s < 100 + random() % 40; ++s) {
        router.heard({s, 1}, link);
        model.heard({s, 1}, link);
      }
    }
    router.heard(from, link);
    model.heard(from, link);
    for (std::size_t from_link = 0; from_link < 4; ++from_link) {
      REQUIRE(router.beyond(target, from_link) == model.beyond(target, from_link));
    }
  }
}

}  // namespace
}  // namespace flotilla::app
