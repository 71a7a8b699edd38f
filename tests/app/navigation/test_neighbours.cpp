// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "app/navigation/neighbours.hpp"
#include "app/operator/telemetry/text.hpp"

namespace flotilla::app {
namespace {

constexpr std::uint8_t kOwn = 3, kLeader = 2;
constexpr std::int32_t kLatitude = 410'000'000, kLongitude = 20'000'000;
constexpr std::int64_t kSecond_us = 1'000'000;

link::Heartbeat beat(std::uint8_t type = link::mav::kTypeSurfaceBoat,
                     std::uint8_t autopilot = link::mav::kAutopilotGeneric, bool steered = true) {
  return {0, type, autopilot, steered ? link::mav::kModeFlagGuided : std::uint8_t{0}, 4};
}

/// The position in degE7 at these metres from the origin; a sphere is accurate enough for metres.
link::GlobalPositionInt at(double north_m, double east_m, double v_north = 0, double v_east = 0) {
  const double degE7_per_m = 1e7 / 111'050;
  const double c = std::cos(41.0 / 180 * 3.14159265358979);
  return {0,
          kLatitude + static_cast<std::int32_t>(north_m * degE7_per_m),
          kLongitude + static_cast<std::int32_t>(east_m * degE7_per_m * 111'050 / 111'412 / c),
          0,
          0,
          static_cast<std::int16_t>(100 * v_north),
          static_cast<std::int16_t>(100 * v_east),
          0,
          65535};
}

struct Watch {
  Neighbours neighbours;
  convert::Position own{0, 0, {kLatitude, kLongitude, 0, 0}};

  explicit Watch(float least_m = 1.5F) { neighbours.configure(kOwn, kLeader, least_m); }

  void hear(std::uint8_t system, const link::Message& message, std::int64_t now_us = 0,
            std::uint8_t component = 1) {
    neighbours.take({{system, component}, message}, own, now_us);
  }
  /// Receives a boat at that place, with its depth in the tree.
  void meet(std::uint8_t system, double north_m, double east_m, int depth, bool steered = true) {
    hear(system, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotGeneric, steered));
    hear(system, at(north_m, east_m));
    hear(system, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotGeneric, steered));
    if (depth >= 0) tell_depth(system, static_cast<float>(depth));
  }
  void tell_depth(std::uint8_t system, float depth) {
    hear(system, link::FleetBeacon{});
    hear(system, value_of("DEPTH", depth, 0));
  }
  core::Traffic<double> look(std::int64_t now_us = 0) const {
    return neighbours.traffic(own, core::Vec2<double>{}, now_us);
  }
};

TEST_CASE("a vessel's global position is extrapolated and relative to our moved position") {
  Watch w;
  w.hear(5, beat());
  w.hear(5, at(30, -40, 2, -1));
  const auto seen = w.neighbours.traffic(w.own, core::Vec2<double>{1, 1}, kSecond_us / 2);
  REQUIRE(seen.count == 1);
  // 0.6 s later: half a second, and 0.1 s for the message's delay.
  CHECK(seen.vessels[0].p_n.x == doctest::Approx(30 + 1.2 - 1).epsilon(2e-3));
  CHECK(seen.vessels[0].p_n.y == doctest::Approx(-40 - 0.6 - 1).epsilon(2e-3));
  CHECK(seen.vessels[0].v_n.x == doctest::Approx(2));
  CHECK(seen.vessels[0].v_n.y == doctest::Approx(-1));
  CHECK(seen.vessels[0].margin == doctest::Approx(0.6 * std::sqrt(5.0)));
}

/// Vessel 5 sails north at 2 m/s. It reports its place at `true_us` by a clock that is `ahead_us`
/// ahead of ours.
struct Sailing : Watch {
  std::int64_t ahead_us = 100 * kSecond_us;

  Sailing() { hear(5, beat()); }
  void tell(std::int64_t true_us, std::int64_t now_us) {
    link::GlobalPositionInt m = at(2e-6 * static_cast<double>(true_us), 0, 2, 0);
    m.time_boot_ms = static_cast<std::uint32_t>((true_us + ahead_us) / 1000);
    hear(5, m, now_us);
  }
  /// Reports ten times a second, each `late_us` late.
  void sail(std::int64_t from_us, std::int64_t to_us, std::int64_t late_us) {
    for (std::int64_t us = from_us; us < to_us; us += 100'000) tell(us - late_us, us);
  }
  /// Distance of the assumed place ahead of the true one, without the assumed delay of 0.1 s.
  double off_m(std::int64_t now_us) const {
    const auto seen = look(now_us);
    REQUIRE(seen.count == 1);
    return seen.vessels[0].p_n.x - 2e-6 * static_cast<double>(now_us) - 0.2;
  }
};

TEST_CASE("a late state is as old as its stamp, and its position as uncertain") {
  Sailing w;
  w.sail(0, kSecond_us, 0);
  CHECK(w.off_m(kSecond_us) == doctest::Approx(0).epsilon(0.05));
  w.sail(2 * kSecond_us, 3 * kSecond_us, 800'000);
  CHECK(w.off_m(3 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
  CHECK(w.look(3 * kSecond_us).vessels[0].margin ==
        doctest::Approx(2 * (0.1 + 0.1 + 0.8)).epsilon(0.01));
}

TEST_CASE("a state five to thirty seconds late is as old as its stamp, and that is reported") {
  for (const std::int64_t late_us : {5 * kSecond_us, 29 * kSecond_us}) {
    Sailing w;
    w.sail(0, 10 * kSecond_us, 0);
    CHECK_FALSE(w.neighbours.late(10 * kSecond_us));
    w.sail(12 * kSecond_us, 60 * kSecond_us, late_us);
    CHECK(w.off_m(60 * kSecond_us) == doctest::Approx(0).epsilon(0.15));
    CHECK(w.look(60 * kSecond_us).vessels[0].margin ==
          doctest::Approx(2 * (0.2 + 1e-6 * static_cast<double>(late_us))).epsilon(0.01));
    CHECK(w.neighbours.late(60 * kSecond_us) == 5);
    w.tell(60 * kSecond_us, 60 * kSecond_us);
    CHECK(w.neighbours.late(60 * kSecond_us) == 5);  // another one with its id may be the late one
    CHECK_FALSE(w.neighbours.late(63 * kSecond_us));
    CHECK(w.off_m(60 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
  }
}

TEST_CASE("a vessel heard late counts until it has been silent for 3 s") {
  Sailing w;
  w.sail(0, 10 * kSecond_us, 0);
  w.sail(10 * kSecond_us, 20 * kSecond_us, 8 * kSecond_us);
  CHECK(w.look(22 * kSecond_us + 800'000).count == 1);
  CHECK(w.look(23 * kSecond_us).count == 0);
}

TEST_CASE("a vessel heard 40 s late is predicted for 30 s, and then taken for prompt") {
  Sailing w;
  w.sail(0, 10 * kSecond_us, 0);
  w.sail(10 * kSecond_us, 39 * kSecond_us, 40 * kSecond_us);
  CHECK(w.off_m(39 * kSecond_us) == doctest::Approx(0).epsilon(0.15));
  CHECK(w.neighbours.late(39 * kSecond_us) == 5);
  w.sail(39 * kSecond_us, 45 * kSecond_us, 40 * kSecond_us);
  CHECK(w.off_m(45 * kSecond_us) == doctest::Approx(-80).epsilon(0.01));
}

TEST_CASE("a vessel whose clock is set back is predicted from its last state until then") {
  Sailing w;
  w.ahead_us = 1000 * kSecond_us;
  w.sail(5 * kSecond_us, 20 * kSecond_us, 0);
  w.ahead_us -= 15 * kSecond_us;
  for (std::int64_t us = 20 * kSecond_us; us < 34 * kSecond_us; us += kSecond_us) {
    w.tell(us, us);
    CHECK(w.off_m(us + 500'000) == doctest::Approx(0).epsilon(0.25));
  }
}

TEST_CASE("the first prompt message shows that a vessel's earlier messages were late") {
  Sailing w;
  w.sail(5 * kSecond_us, 6 * kSecond_us, 4 * kSecond_us);
  w.sail(6 * kSecond_us, 7 * kSecond_us, 0);
  w.sail(8 * kSecond_us, 9 * kSecond_us, kSecond_us);
  CHECK(w.off_m(9 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
}

TEST_CASE("an overtaken message does not move a vessel back") {
  Sailing w;
  w.sail(0, 2 * kSecond_us, 0);
  const double before_m = w.off_m(2 * kSecond_us);
  w.tell(kSecond_us, 2 * kSecond_us);
  CHECK(w.off_m(2 * kSecond_us) == before_m);
}

TEST_CASE("a restarted or changed clock hides its vessel for at most three seconds") {
  for (const std::int64_t ahead_us : {-5 * kSecond_us, 35 * kSecond_us, 4000 * kSecond_us}) {
    Sailing w;
    w.sail(5 * kSecond_us, 10 * kSecond_us, 0);
    w.ahead_us = ahead_us;
    w.sail(10 * kSecond_us, 14 * kSecond_us, 0);
    CHECK(w.off_m(14 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
  }
}

TEST_CASE("after a clock was set back, or one stamp was wrong, the margin covers the vessel") {
  for (const bool set_back : {true, false}) {
    for (const std::int64_t by_us : {10 * kSecond_us, 40 * kSecond_us}) {
      Sailing w;
      w.ahead_us = 1000 * kSecond_us;
      w.sail(5 * kSecond_us, 10 * kSecond_us, 0);
      if (set_back) {
        w.ahead_us -= by_us;
      } else {
        w.ahead_us += by_us;
        w.tell(10 * kSecond_us, 10 * kSecond_us);
        w.ahead_us -= by_us;
      }
      w.sail(10 * kSecond_us + 100'000, 75 * kSecond_us, 0);
      if (by_us > 30 * kSecond_us) {
        CHECK(w.off_m(75 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
      } else {
        CHECK(std::abs(w.off_m(75 * kSecond_us)) < w.look(75 * kSecond_us).vessels[0].margin);
      }
    }
  }
}

TEST_CASE("a vessel beside us is not clear of us although its late states are of another place") {
  Sailing w;
  w.sail(0, 20 * kSecond_us, 0);
  w.sail(25 * kSecond_us, 26 * kSecond_us, 10 * kSecond_us);
  w.own.north_m = 31.5;
  w.sail(26 * kSecond_us, 27 * kSecond_us, 10 * kSecond_us);
  CHECK_FALSE(w.neighbours.clear(w.own, core::Vec2<float>{}, 27 * kSecond_us));
}

TEST_CASE("a vessel that was started while it was silent is heard again") {
  Sailing w;
  w.ahead_us = 20 * kSecond_us;
  w.sail(5 * kSecond_us, 10 * kSecond_us, 0);
  w.ahead_us = -14 * kSecond_us;
  w.sail(15 * kSecond_us, 16 * kSecond_us, 0);
  CHECK(w.off_m(16 * kSecond_us) == doctest::Approx(0).epsilon(0.05));
}

TEST_CASE("when the fast link is lost, states from the slow one are late, not from a new clock") {
  for (const std::int64_t late_us : {2 * kSecond_us, 6 * kSecond_us, 25 * kSecond_us}) {
    Sailing w;
    w.ahead_us = 1000 * kSecond_us;
    for (std::int64_t us = 0; us < 120 * kSecond_us; us += 100'000) {
      if (us < 70 * kSecond_us) w.tell(us, us);
      if (us >= late_us) w.tell(us - late_us, us);
    }
    CHECK(w.neighbours.late(120 * kSecond_us).has_value() == (late_us > 3 * kSecond_us));
    CHECK(std::abs(w.off_m(120 * kSecond_us)) < 0.2);
  }
}

TEST_CASE("a clock slower than ours for hours does not age its vessel") {
  Sailing w;
  constexpr std::int64_t kHours_us = 4 * 3600 * kSecond_us;
  for (std::int64_t us = 0; us <= kHours_us; us += 500'000) {
    link::GlobalPositionInt m = at(0, 0, 2, 0);
    m.time_boot_ms = static_cast<std::uint32_t>((us - us / 10'000) / 1000);  // 100 ppm
    w.hear(5, m, us);
  }
  CHECK(w.look(kHours_us).vessels[0].p_n.x == doctest::Approx(0.2).epsilon(0.05));
}

TEST_CASE("a local position counts in any kind of message if its origin is known") {
  const link::GpsGlobalOrigin origin{kLatitude + 1000, kLongitude, 0, 0};  // 11.1 m north of ours
  link::Odometry odometry{};
  odometry.x = 5;
  odometry.q = {1, 0, 0, 0};
  odometry.vx = 1;
  odometry.frame_id = link::mav::kFrameLocalNed;
  odometry.child_frame_id = link::mav::kFrameBodyFrd;
  for (const link::Message& message :
       {link::Message(link::LocalPositionNed{0, 5, 0, 0, 1, 0, 0}), link::Message(odometry)}) {
    Watch w;
    w.hear(5, beat());
    w.hear(5, message);
    CHECK(w.look().count == 0);
    w.hear(5, link::GpsGlobalOrigin{});  // no fix
    w.hear(5, message);
    CHECK(w.look().count == 0);
    w.hear(5, origin);
    CHECK(w.look().count == 0);
    w.hear(5, message);
    REQUIRE(w.look().count == 1);
    CHECK(w.look().vessels[0].p_n.x == doctest::Approx(5 + 11.1 + 0.1).epsilon(0.01));
    CHECK(w.look().vessels[0].v_n.x == doctest::Approx(1));
  }
}

TEST_CASE("FOLLOW_TARGET gives a position too") {
  Watch w;
  w.hear(5, beat());
  link::FollowTarget target{};
  target.lat = kLatitude + 1000;
  target.lon = kLongitude;
  target.est_capabilities = link::mav::kFollowPosition | link::mav::kFollowVelocity;
  w.hear(5, target);
  REQUIRE(w.look().count == 1);
  CHECK(w.look().vessels[0].p_n.x == doctest::Approx(11.1).epsilon(0.01));
}

TEST_CASE(
    "no vessels: virtual leaders, stations, companions, gimbals, other components, ourselves") {
  for (const unsigned type : {0U, 5U, 6U, 18U, 26U, 30U}) {
    Watch w;
    w.hear(5, beat(static_cast<std::uint8_t>(type)));
    w.hear(5, at(5, 0));
    CHECK(w.look().count == 0);
  }
  Watch w;
  w.hear(5, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotInvalid));
  w.hear(5, at(5, 0));
  w.hear(6, at(5, 0));  // without any heartbeat
  w.hear(7, beat());
  w.hear(7, at(5, 0), 0, 220);
  w.hear(kOwn, beat());
  w.hear(kOwn, at(5, 0));
  w.hear(0, beat());
  w.hear(0, at(5, 0));
  w.hear(8, beat(), 0, 0);
  w.hear(8, at(5, 0), 0, 0);
  CHECK(w.look().count == 0);
}

TEST_CASE("an impossible position is ignored, as is one in another ocean") {
  Watch w;
  w.hear(5, beat());
  w.hear(5, link::GlobalPositionInt{});
  w.hear(5, at(8000, 0));
  CHECK(w.look().count == 0);
  w.own.origin = {};  // our own place is unknown
  w.hear(5, at(5, 0));
  CHECK(w.look().count == 0);
}

TEST_CASE("right of way: leader, smaller depth, lower system id; also an unknown vessel") {
  Watch w;
  w.meet(kLeader, 5, 0, 1);
  CHECK(w.neighbours.depth() == 2);
  CHECK(w.look().vessels[0].has_way);
  struct Meeting {
    std::uint8_t system;
    int depth;
    bool steered, has_way;
  };
  for (const auto& [system, depth, steered, has_way] :
       {Meeting{9, 1, true, true}, Meeting{9, 2, true, false}, Meeting{1, 2, true, true},
        Meeting{1, 3, true, false}, Meeting{9, 3, false, true}, Meeting{9, -1, true, true}}) {
    Watch other;
    other.hear(kLeader, beat());
    other.tell_depth(kLeader, 1);
    other.meet(system, 0, 9, depth, steered);
    REQUIRE(other.look().count == 1);
    CHECK(other.look().vessels[0].has_way == has_way);
  }
}

TEST_CASE("a vessel that sends DEPTH, but nothing of our dialect, is a stranger") {
  Watch w;
  w.meet(9, 10, 0, -1);
  w.hear(9, value_of("DEPTH", 12, 0));
  w.hear(9, link::FleetBeacon{}, 0, 154);  // not its autopilot's
  w.hear(9, value_of("DEPTH", 12, 0));
  CHECK((w.look().vessels[0].stranger && w.look().vessels[0].has_way));
}

TEST_CASE("a vessel that sends no DEPTH is a stranger, except the leader") {
  Watch w;
  w.meet(kLeader, 5, 0, -1);
  w.meet(9, 10, 0, 4);
  w.meet(10, 15, 0, -1);
  const auto seen = w.look();
  REQUIRE(seen.count == 3);
  CHECK_FALSE(seen.vessels[0].stranger);
  CHECK_FALSE(seen.vessels[1].stranger);
  CHECK((seen.vessels[2].stranger && seen.vessels[2].has_way));
}

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

TEST_CASE("a member's longer hull counts, until another length is known") {
  Watch w;
  const auto hear = [&](std::optional<float> reach_m) {
    w.neighbours.take({{5, 1}, at(3, 0)}, w.own, 0, reach_m);
  };
  w.hear(5, beat());
  hear(1.8F);
  CHECK(w.look().vessels[0].margin == doctest::Approx(1.8));
  CHECK_FALSE(w.neighbours.clear(w.own, core::Vec2<double>{}, 0));  // 3 m off, 1.5 + 1.8 m to keep
  hear(std::nullopt);  // as by a table that stops all boats
  CHECK(w.look().vessels[0].margin == doctest::Approx(1.8));
  hear(0.0F);
  CHECK(w.look().vessels[0].margin == 0);
  CHECK(w.neighbours.clear(w.own, core::Vec2<double>{}, 0));
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

TEST_CASE("another vehicle's component of the same system does not hide a vessel") {
  Watch w;
  const auto sail = [&](std::int64_t from_us, std::uint8_t told) {
    for (std::int64_t us = from_us; us < from_us + 5 * kSecond_us; us += 200'000) {
      if (us % kSecond_us == 0) {
        w.hear(5, beat(), us);
        w.hear(5, beat(), us, 2);
      }
      w.hear(5, at(5, 0), us, told);
    }
    return w.look(from_us + 5 * kSecond_us).count;
  };
  CHECK(sail(0, 1) == 1);
  CHECK(sail(5 * kSecond_us, 2) == 1);  // three seconds after the first has sent its last place
}

TEST_CASE("a vessel whose autopilot goes on under another component is seen again") {
  Watch w;
  for (std::int64_t us = 0; us < 20 * kSecond_us; us += 200'000) {
    const std::uint8_t component = us < 5 * kSecond_us ? 1 : 2;
    if (us % kSecond_us == 0) w.hear(5, beat(), us, component);
    w.hear(5, at(5, 0), us, component);
  }
  CHECK(w.look(20 * kSecond_us).count == 1);
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

TEST_CASE("a vessel that tells only its place counts as at rest there") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  link::GlobalPositionInt global = at(5, 0);
  global.vx = global.vy = 32767;
  link::FollowTarget target{};
  target.lat = kLatitude + 450;
  target.lon = kLongitude;
  target.est_capabilities = link::mav::kFollowPosition;
  link::FollowTarget unknown = target;
  unknown.est_capabilities |= link::mav::kFollowVelocity;
  unknown.vel = {nan, nan, nan};
  link::LocalPositionNed local{0, 5, 0, nan, 1, 0, nan};
  link::Odometry odometry{};
  odometry.x = 5;
  odometry.vx = odometry.yawspeed = nan;
  odometry.frame_id = link::mav::kFrameLocalNed;
  odometry.child_frame_id = link::mav::kFrameBodyFrd;
  for (const link::Message& message :
       {link::Message(global), link::Message(target), link::Message(unknown), link::Message(local),
        link::Message(odometry)}) {
    CAPTURE(message.index());
    Watch w;
    w.hear(5, beat());
    w.hear(5, w.own.origin);
    w.hear(5, message);
    REQUIRE(w.look().count == 1);
    CHECK(w.look().vessels[0].p_n.x == doctest::Approx(5).epsilon(0.01));
    CHECK(core::length(w.look().vessels[0].v_n) == 0);
  }
  target.est_capabilities = 0;
  Watch w;
  w.hear(5, beat());
  w.hear(5, target);
  CHECK(w.look().count == 0);
}

TEST_CASE("behind a leader that sends no depth a boat has depth one; invalid depths are ignored") {
  Watch w;
  w.hear(kLeader, beat());
  w.hear(kLeader, link::FormationReference{});
  CHECK(w.neighbours.depth() == 1);
  w.hear(kLeader, value_of("DEPTH", 2.5F, 0));
  w.hear(kLeader, value_of("DEPTH", 2, 0), 0, 154);
  w.hear(kLeader, value_of("DEPTH", -1, 0));
  w.hear(kLeader, value_of("DEPTH", 251, 0));
  w.hear(kLeader, value_of("DEPTH", NAN, 0));
  w.hear(kLeader, value_of("DEPTHS", 7, 0));
  w.hear(kLeader, value_of("OTHER", 7, 0));
  CHECK(w.neighbours.depth() == 1);
  w.hear(kLeader, value_of("DEPTH", 250, 0));
  CHECK(w.neighbours.depth() == 250);  // the depth of a boat in a cycle is limited
  w.neighbours.configure(kOwn, 77, 1.5F);
  CHECK(w.neighbours.depth() == 1);
}

TEST_CASE("a silent vessel is forgotten after three seconds, and its entry is reused") {
  Watch w;
  for (int i = 0; i < 8; ++i) w.meet(static_cast<std::uint8_t>(10 + i), 5 + i, 0, 1);
  CHECK(w.look(3 * kSecond_us).count == 8);
  CHECK(w.look(3 * kSecond_us + 1).count == 0);
  w.hear(40, beat());
  w.hear(40, at(50, 0), 4 * kSecond_us);
  CHECK(w.look(4 * kSecond_us).count == 1);
}

TEST_CASE("of more vessels than there is room for, the farthest are left out") {
  Watch w;
  for (int i = 0; i < 8; ++i) w.meet(static_cast<std::uint8_t>(10 + i), 10 + 10 * i, 0, 1);
  w.meet(30, 0, 100, 1);
  w.meet(31, 0, 20, 1);
  const link::GpsGlobalOrigin origin{kLatitude, kLongitude, 0, 0};
  w.hear(32, beat());
  w.hear(32, origin);  // its distance is still unknown
  const auto seen = w.look();
  CHECK(seen.count == 8);
  double farthest_m = 0;
  for (const auto& v : seen.vessels) farthest_m = std::max(farthest_m, core::length(v.p_n));
  CHECK(farthest_m == doctest::Approx(70).epsilon(0.01));  // not the one at 80, nor that at 100
  w.hear(32, link::LocalPositionNed{0, 5, 0, 0, 1, 0, 0});
  const auto now = w.look();
  CHECK(std::ranges::any_of(std::span(now.vessels).first(now.count), [](const auto& v) {
    return core::length(v.p_n) < 6;  // it is near, although it sends only local places
  }));
}

TEST_CASE("a tracked vessel's local place counts, however many others tell their origins") {
  Watch w;
  const link::GpsGlobalOrigin origin{kLatitude, kLongitude, 0, 0};
  for (std::uint8_t system = 5; system < 13; ++system) {
    w.hear(system, beat());
    w.hear(system, origin);
    w.hear(system, link::LocalPositionNed{0, 5.0F + system, 0, 0, 1, 0, 0});
  }
  for (std::uint8_t system = 30; system < 80; ++system) {
    w.hear(system, beat());
    w.hear(system, origin);
  }
  for (std::uint8_t system = 5; system < 13; ++system) {
    w.hear(system, link::LocalPositionNed{100, 50.0F + system, 0, 0, 1, 0, 0}, 100'000);
  }
  const auto seen = w.look(100'000);
  REQUIRE(seen.count == 8);
  for (const auto& v : seen.vessels) CHECK(v.p_n.x > 50);
}

TEST_CASE("where our own origin changes, the vessels stay where they are") {
  Watch w;
  w.meet(5, 5, 3, 1);
  w.own.origin.latitude += 1000;  // 11.1 m north
  CHECK(w.look().count == 0);
  w.hear(kOwn, link::GlobalPositionInt{});  // any message
  REQUIRE(w.look().count == 1);
  CHECK(w.look().vessels[0].p_n.x == doctest::Approx(5 - 11.1).epsilon(0.01));
  CHECK(w.look().vessels[0].p_n.y == doctest::Approx(3).epsilon(0.01));
  w.own.origin.latitude += 10'000'000;
  w.hear(kOwn, link::GlobalPositionInt{});
  CHECK(w.look().count == 0);  // too far away
}

TEST_CASE("kClear means that no vessel is within FS_SEP_M; without it no vessel is checked") {
  for (const float least_m : {0.0F, 1.5F, 20.0F}) {
    Watch w(least_m);
    CHECK(w.neighbours.watches() == (least_m > 0));
    CHECK(w.neighbours.clear(w.own, core::Vec2<float>{}, 0));
    w.meet(5, 12, 0, 1);
    CHECK(w.neighbours.clear(w.own, core::Vec2<float>{}, 0) == (least_m < 20));
    CHECK(w.look().count == (least_m > 0 ? 1 : 0));
  }
}

TEST_CASE("a vessel alongside is not clear of us although one with its system id is far away") {
  Watch w;
  w.hear(5, beat());
  const auto tell = [&](double north_m, std::int64_t stamp_us, std::int64_t now_us) {
    link::GlobalPositionInt m = at(north_m, 0);
    m.time_boot_ms = static_cast<std::uint32_t>(stamp_us / 1000);
    w.hear(5, m, now_us);
  };
  const auto clear = [&](std::int64_t now_us) {
    return w.neighbours.clear(w.own, core::Vec2<float>{}, now_us);
  };
  for (std::int64_t us = 0; us < 10 * kSecond_us; us += 200'000) {
    tell(-200, us + 100 * kSecond_us, us);
    if (us < 2 * kSecond_us) {
      CHECK(clear(us));
    } else {
      tell(-0.5, us + 40 * kSecond_us, us + 100'000);
      CHECK_FALSE(clear(us + 100'000));
    }
  }
  CHECK(w.neighbours.late(10 * kSecond_us) == 5);
  CHECK(clear(13 * kSecond_us));
}

}  // namespace
}  // namespace flotilla::app
