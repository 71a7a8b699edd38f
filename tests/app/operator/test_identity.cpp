// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "app/operator/identity.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::uint8_t kArdupilot = 3;
constexpr std::uint8_t kLeader = 100;

Identity identity(bool companion, std::uint8_t system, std::uint8_t component) {
  return Identity({.system = system, .component = component, .companion = companion});
}
link::Heartbeat beat(std::uint8_t autopilot = kArdupilot) { return {0, 11, autopilot, 1, 4}; }

TEST_CASE("a message is for us by our ids or by zeros, and for others by theirs") {
  for (const bool companion : {false, true}) {
    const Identity boat = identity(companion, 7, 191);
    CHECK(boat.self() == link::Address{7, 191});
    CHECK(boat.companion() == companion);
    for (unsigned system = 0; system < 256; ++system) {
      for (unsigned component = 0; component < 256; ++component) {
        const link::Address target{static_cast<std::uint8_t>(system),
                                   static_cast<std::uint8_t>(component)};
        const bool ours = (system == 0 || system == 7) && (component == 0 || component == 191);
        REQUIRE(boat.addressed(target) == ours);
        REQUIRE(boat.is_for_autopilot(target) == (companion && component == 0));
      }
    }
  }
}

TEST_CASE("a vehicle is GENERIC or ARDUPILOTMEGA as MAV_AUTOPILOT says, a companion neither") {
  CHECK(Identity({.ardupilot = false}).autopilot() == 0);
  CHECK(Identity({.ardupilot = true}).autopilot() == kArdupilot);
  for (const bool ardupilot : {false, true}) {
    CHECK(Identity({.companion = true, .ardupilot = ardupilot}).autopilot() == 8);
  }
}

TEST_CASE("a companion takes the only autopilot's system id three seconds after hearing it") {
  Identity boat = identity(true, 7, 191);
  CHECK_FALSE(boat.latch(false, 50 * kSecond_us));  // no autopilot is heard yet
  for (std::int64_t t = 0; t < 3; ++t) {
    boat.heard({42, 1}, beat(), kLeader, (60 + t) * kSecond_us);
    CHECK_FALSE(boat.latch(false, (60 + t) * kSecond_us));
    CHECK(boat.self() == link::Address{7, 191});
  }
  CHECK_FALSE(boat.latch(false, 63 * kSecond_us - 1));
  CHECK(boat.latch(false, 63 * kSecond_us));
  CHECK(boat.self() == link::Address{42, 191});
  CHECK(boat.addressed({42, 191}));
  CHECK_FALSE(boat.addressed({7, 191}));
  CHECK_FALSE(boat.latch(false, 64 * kSecond_us));  // once
}

TEST_CASE("once a companion has taken an id or kept its own, it stays with it") {
  for (const bool several : {false, true}) {
    Identity boat = identity(true, 7, 191);
    boat.heard({42, 1}, beat(), kLeader, 0);
    if (several) boat.heard({43, 1}, beat(), kLeader, kSecond_us);
    boat.latch(false, 3 * kSecond_us);
    const link::Address self = boat.self();
    CHECK(self.system == (several ? 7 : 42));
    for (std::int64_t t = 4; t < 20; ++t) {
      boat.heard({99, 1}, beat(), kLeader, t * kSecond_us);
      CHECK_FALSE(boat.latch(false, t * kSecond_us));
      CHECK(boat.self() == self);
    }
  }
}

TEST_CASE("of several autopilots a companion takes none, in whatever order they are heard") {
  for (unsigned order = 0; order < 16; ++order) {
    Identity boat = identity(true, 7, 191);
    boat.heard({42, 1}, beat(), kLeader, 0);
    for (unsigned k = 0; k < 4; ++k) {
      const std::uint8_t system = (order >> k & 1U) != 0 ? 43 : 42;
      boat.heard({system, 1}, beat(), kLeader, k * kSecond_us / 2);
    }
    CHECK(boat.latch(false, 3 * kSecond_us) == (order == 0));
    CHECK(boat.self().system == (order == 0 ? 42 : 7));
  }
}

TEST_CASE("ground stations and other companions are no autopilots") {
  Identity boat = identity(true, 7, 191);
  boat.heard({255, 190}, beat(mav::kAutopilotInvalid), kLeader, 0);
  boat.heard({42, 191}, beat(mav::kAutopilotInvalid), kLeader, 0);
  CHECK_FALSE(boat.latch(false, 10 * kSecond_us));
  boat.heard({42, 1}, beat(), kLeader, 11 * kSecond_us);
  boat.heard({255, 190}, beat(mav::kAutopilotInvalid), kLeader, 12 * kSecond_us);
  CHECK(boat.latch(false, 14 * kSecond_us));
  CHECK(boat.self().system == 42);
}

TEST_CASE("a companion never takes the id of its leader's autopilot") {
  Identity boat = identity(true, 7, 191);
  boat.heard({100, 1}, beat(), kLeader, 0);
  CHECK_FALSE(boat.latch(false, 5 * kSecond_us));
  boat.heard({42, 1}, beat(), kLeader, 6 * kSecond_us);
  boat.heard({100, 1}, beat(), kLeader, 7 * kSecond_us);
  CHECK(boat.latch(false, 9 * kSecond_us));
  CHECK(boat.self().system == 42);
}

TEST_CASE(
    "only component 1 is an autopilot, and only one that does not call itself a ground station") {
  for (unsigned component = 0; component < 256; ++component) {
    Identity boat = identity(true, 7, 191);
    boat.heard({42, static_cast<std::uint8_t>(component)}, beat(), kLeader, 0);
    CAPTURE(component);
    CHECK(boat.latch(false, 3 * kSecond_us) == (component == 1));
    CHECK(boat.self().system == (component == 1 ? 42 : 7));
  }
  Identity boat = identity(true, 7, 191);
  link::Heartbeat station = beat();
  station.type = mav::kTypeGcs;
  boat.heard({255, 1}, station, kLeader, 0);
  CHECK_FALSE(boat.latch(false, 3 * kSecond_us));
  boat.heard({42, 1}, beat(), kLeader, 4 * kSecond_us);
  CHECK(boat.latch(false, 7 * kSecond_us));
}

TEST_CASE("a companion that is armed when it would take an id keeps its own for good") {
  Identity boat = identity(true, 7, 191);
  boat.heard({42, 1}, beat(), kLeader, 0);
  CHECK_FALSE(boat.latch(true, 3 * kSecond_us));
  CHECK_FALSE(boat.latch(false, 4 * kSecond_us));
  boat.heard({42, 1}, beat(), kLeader, 5 * kSecond_us);
  CHECK_FALSE(boat.latch(false, 20 * kSecond_us));
  CHECK(boat.self() == link::Address{7, 191});

  Identity other = identity(true, 7, 191);  // armed before the three seconds are over, and not then
  other.heard({42, 1}, beat(), kLeader, 0);
  CHECK_FALSE(other.latch(true, 3 * kSecond_us - 1));
  CHECK(other.latch(false, 3 * kSecond_us));
}

TEST_CASE("a companion does not take system id 0") {
  Identity boat = identity(true, 7, 191);
  boat.heard({0, 1}, beat(), kLeader, 0);
  boat.latch(false, 3 * kSecond_us);
  CHECK(boat.self().system == 7);
}

TEST_CASE("a companion configured with its autopilot's id changes nothing") {
  Identity boat = identity(true, 42, 191);
  boat.heard({42, 1}, beat(), kLeader, 0);
  CHECK_FALSE(boat.latch(false, 3 * kSecond_us));
  CHECK(boat.self() == link::Address{42, 191});
}

TEST_CASE("an independent vehicle keeps its id, whatever it hears") {
  Identity boat = identity(false, 7, 1);
  for (std::int64_t t = 0; t < 10; ++t) {
    boat.heard({42, 1}, beat(), kLeader, t * kSecond_us);
    CHECK_FALSE(boat.latch(false, t * kSecond_us));
  }
  CHECK(boat.self() == link::Address{7, 1});
}

}  // namespace
}  // namespace flotilla::app
