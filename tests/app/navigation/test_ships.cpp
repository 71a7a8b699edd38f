// SPDX-License-Identifier: MIT
// Ships that report by AIS, and which vessels count if there are many.
#include <doctest/doctest.h>

#include <algorithm>

#include "app/navigation/neighbours_watch.hpp"

namespace flotilla::app::vessels {
namespace {

/// A ship that reports by AIS that it sails east.
link::AisVessel ship(double north_m, std::uint16_t heard_s_ago, std::uint32_t mmsi = 211'000'001) {
  const link::GlobalPositionInt place = at(north_m, 0);
  link::AisVessel m{};
  m.MMSI = mmsi;
  m.lat = place.lat;
  m.lon = place.lon;
  m.COG = 9000;
  m.velocity = 200;
  m.tslc = heard_s_ago;
  m.flags = link::mav::kAisCourse | link::mav::kAisSpeed;
  return m;
}

TEST_CASE("a ship in AIS is a stranger with right of way, whoever relays it") {
  for (const std::uint8_t teller : {kOwn, kLeader, std::uint8_t{255}}) {
    Watch w;
    w.hear(teller, ship(40, 0), 10 * kSecond_us, 191);
    const auto seen = w.look(10 * kSecond_us);
    REQUIRE(seen.count == 1);
    const auto& other = seen.vessels[0];
    CHECK((other.stranger && other.has_way));
    CHECK(other.p_n.x == doctest::Approx(40).epsilon(0.01));
    CHECK(other.v_n.x == doctest::Approx(0).scale(1));
    CHECK(other.v_n.y == doctest::Approx(2));
    CHECK(other.p_n.y == doctest::Approx(2.2));  // up to a second old, and 0.1 s on its way
    CHECK(other.margin == doctest::Approx(2.2));
  }
}

TEST_CASE("a ship's report ages by the receiver's counter, and is forgotten after 30 s") {
  Watch w;
  w.hear(255, ship(40, 9), 60 * kSecond_us);
  CHECK(w.look(60 * kSecond_us).vessels[0].p_n.y == doctest::Approx(2 * 10.1));
  w.hear(255, ship(40, 14), 62 * kSecond_us);  // an older one
  CHECK(w.look(62 * kSecond_us).vessels[0].p_n.y == doctest::Approx(2 * 12.1));
  CHECK(w.look(80 * kSecond_us).count == 1);
  CHECK(w.look(81 * kSecond_us).count == 0);
  w.hear(255, ship(40, 30), 90 * kSecond_us);  // too old when it comes
  CHECK(w.look(90 * kSecond_us).count == 0);
  w.hear(255, ship(40, 1), 91 * kSecond_us);
  CHECK(w.look(91 * kSecond_us).count == 1);
}

TEST_CASE("a ship at rest stays where it is for 6.5 minutes after its report") {
  for (int at_rest = 0; at_rest < 4; ++at_rest) {
    link::AisVessel m = ship(40, 0);
    m.velocity = 100;
    if (at_rest == 0) m.navigational_status = link::mav::kAisAnchored;
    if (at_rest == 1) m.navigational_status = link::mav::kAisMoored;
    if (at_rest == 2) m.navigational_status = link::mav::kAisAground;
    if (at_rest == 3) m.velocity = 29;
    Watch w;
    w.hear(255, m);
    REQUIRE(w.look(389 * kSecond_us).count == 1);
    CHECK(w.look(389 * kSecond_us).vessels[0].margin < 10.2);
    CHECK(w.look(390 * kSecond_us).count == 0);
    m.velocity = 155;  // it gets under way, whatever its status
    w.hear(255, m, 20 * kSecond_us);
    CHECK(w.look(49 * kSecond_us).count == 1);
    CHECK(w.look(50 * kSecond_us).count == 0);
  }
}

TEST_CASE("a ship's hull counts, and a report that cannot be true does not") {
  Watch w;
  link::AisVessel m = ship(40, 0);
  m.flags |= link::mav::kAisDimensions;
  m.dimension_bow = 3;
  m.dimension_stern = 30;
  m.dimension_starboard = 40;
  w.hear(255, m);
  CHECK(w.look().vessels[0].margin == doctest::Approx(50 + 2.2));
  CHECK_FALSE(w.neighbours.clear(w.own, core::Vec2<float>{}, 0));  // its bow may be here
  link::AisVessel still = ship(40, 0);
  still.flags = link::mav::kAisSpeed;  // where to?
  Watch rest;
  rest.hear(255, still);
  CHECK(core::length(rest.look().vessels[0].v_n) == 0);
  for (int wrong = 0; wrong < 2; ++wrong) {
    link::AisVessel bad = ship(40, 0);
    if (wrong == 0) bad.lat = 910'000'000;
    if (wrong == 1) bad.MMSI = 7;  // would be a system id
    Watch none;
    none.hear(255, bad);
    CHECK(none.look().count == 0);
  }
  Watch off(0);
  off.hear(255, ship(40, 0));
  CHECK(off.look().count == 0);
}

TEST_CASE("a ship whose speed or course is not available counts where it is") {
  for (int unknown = 0; unknown < 4; ++unknown) {
    CAPTURE(unknown);
    link::AisVessel m = ship(40, 0);
    if (unknown == 0) m.velocity = 5263;  // 102.3 kn
    if (unknown == 1) m.COG = 36'000;
    if (unknown == 2) m.flags |= link::mav::kAisFast;
    if (unknown == 3) m.velocity = 5001;
    Watch w;
    w.hear(255, m);
    REQUIRE(w.look().count == 1);
    CHECK(core::length(w.look().vessels[0].v_n) == 0);
  }
  link::AisVessel silent = ship(40, 0);  // perhaps at rest: reports every three minutes
  silent.velocity = 5263;
  Watch w;
  w.hear(255, silent);
  CHECK(w.look(380 * kSecond_us).count == 1);
}

TEST_CASE("yachts at rest do not hide a ship that approaches") {
  for (const bool first : {false, true}) {
    CAPTURE(first);
    Watch w;
    link::AisVessel fast = ship(150, 0);
    fast.velocity = 800;
    fast.COG = 18'000;
    if (first) w.hear(255, fast);
    for (std::uint32_t i = 0; i < 40; ++i) {
      link::AisVessel yacht = ship(50 + 5.0 * i, 0, 211'000'100 + i);
      yacht.velocity = 0;
      w.hear(255, yacht);
    }
    if (!first) w.hear(255, fast);
    const auto seen = w.look();
    CHECK(seen.count == 8);
    CHECK(std::ranges::any_of(seen.vessels, [](const auto& v) { return v.v_n.x < -7; }));
  }
}

TEST_CASE("fast vessels that cross far away do not hide a near one at rest, nor a long ship") {
  Watch w;
  link::AisVessel tanker = ship(120, 0, 211'000'099);
  tanker.velocity = 0;
  tanker.flags |= link::mav::kAisDimensions;
  tanker.dimension_bow = 100;
  w.hear(255, tanker);
  for (std::uint32_t i = 0; i < 40; ++i) {
    link::AisVessel fast = ship(200 + 5.0 * i, 0, 211'000'100 + i);
    fast.velocity = 1000;
    w.hear(255, fast);
  }
  for (std::uint32_t i = 0; i < 7; ++i) {
    link::AisVessel yacht = ship(60 + 5.0 * i, 0, 211'000'200 + i);
    yacht.velocity = 0;
    w.hear(255, yacht);
  }
  const auto seen = w.look();
  CHECK(seen.count == 8);
  CHECK(std::ranges::none_of(seen.vessels, [](const auto& v) { return v.v_n.y > 7; }));
  CHECK(std::ranges::any_of(seen.vessels, [](const auto& v) { return v.margin > 90; }));
}

TEST_CASE("vessels that are nearer for a moment do not displace a moored ship from memory") {
  Watch w;
  link::AisVessel moored = ship(60, 0);
  moored.velocity = 0;
  w.hear(255, moored);
  for (std::uint8_t i = 0; i < 20; ++i) w.meet(static_cast<std::uint8_t>(20 + i), 10 + i, 0, 1);
  CHECK(w.look().count == 8);
  CHECK(w.look(60 * kSecond_us).count == 1);
}

TEST_CASE("long ships around us do not displace a boat that is near") {
  Watch w;
  for (std::uint32_t i = 0; i < 40; ++i) {
    link::AisVessel tanker = ship(100 + 5.0 * i, 0, 211'000'100 + i);
    tanker.velocity = 0;
    tanker.flags |= link::mav::kAisDimensions;
    tanker.dimension_bow = 500;
    w.hear(255, tanker);
  }
  w.meet(6, 5, 0, 1);
  const auto seen = w.look();
  CHECK(std::ranges::any_of(seen.vessels, [](const auto& v) { return v.p_n.x < 6; }));
}

}  // namespace
}  // namespace flotilla::app::vessels
