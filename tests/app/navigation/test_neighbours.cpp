// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "app/navigation/neighbours_watch.hpp"

namespace flotilla::app::vessels {
namespace {

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
    w.hear(system, link::LocalPositionNed{100, 5.0F + system, 8, 0, 1, 0, 0}, 100'000);
  }
  const auto seen = w.look(100'000);
  REQUIRE(seen.count == 8);
  for (const auto& v : seen.vessels) CHECK(v.p_n.y > 7);
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

}  // namespace
}  // namespace flotilla::app::vessels
