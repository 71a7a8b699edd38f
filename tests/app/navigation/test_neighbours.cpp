// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "app/navigation/neighbours.hpp"
#include "app/operator/text.hpp"

namespace flotilla::app {
namespace {

constexpr std::uint8_t kOwn = 3, kLeader = 2;
constexpr std::int32_t kLatitude = 410'000'000, kLongitude = 20'000'000;
constexpr std::int64_t kSecond_us = 1'000'000;

link::Heartbeat beat(std::uint8_t type = link::mav::kTypeSurfaceBoat,
                     std::uint8_t autopilot = link::mav::kAutopilotGeneric, bool steered = true) {
  return {0, type, autopilot, steered ? link::mav::kModeFlagGuided : std::uint8_t{0}, 4};
}

/// degE7 of a way that many metres from the origin; a sphere is near enough for metres.
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
  /// A boat that is there, and how deep it is.
  void meet(std::uint8_t system, double north_m, double east_m, int depth, bool steered = true) {
    hear(system, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotGeneric, steered));
    hear(system, at(north_m, east_m));
    hear(system, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotGeneric, steered));
    if (depth >= 0) hear(system, value_of("DEPTH", static_cast<float>(depth), 0));
  }
  core::Traffic<double> look(std::int64_t now_us = 0) const {
    return neighbours.traffic(own, core::Vec2<double>{}, now_us);
  }
};

TEST_CASE(
    "a vessel is where it says on the globe, carried forward, seen from where we have moved") {
  Watch w;
  w.hear(5, beat());
  w.hear(5, at(30, -40, 2, -1));
  const auto seen = w.neighbours.traffic(w.own, core::Vec2<double>{1, 1}, kSecond_us / 2);
  REQUIRE(seen.count == 1);
  // 0.6 s on: half a second, and the tenth that a message was on its way.
  CHECK(seen.vessels[0].p_n.x == doctest::Approx(30 + 1.2 - 1).epsilon(2e-3));
  CHECK(seen.vessels[0].p_n.y == doctest::Approx(-40 - 0.6 - 1).epsilon(2e-3));
  CHECK(seen.vessels[0].v_n.x == doctest::Approx(2));
  CHECK(seen.vessels[0].v_n.y == doctest::Approx(-1));
  CHECK(seen.vessels[0].margin == doctest::Approx(0.6 * std::sqrt(5.0)));
}

TEST_CASE("a place in a local frame counts where its origin is known, in any kind of message") {
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

TEST_CASE("FOLLOW_TARGET tells a place too") {
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
    "virtual leaders, stations, companions, gimbals, other components and we are no vessels") {
  for (const unsigned type : {0U, 5U, 6U, 18U, 26U, 30U}) {
    Watch w;
    w.hear(5, beat(static_cast<std::uint8_t>(type)));
    w.hear(5, at(5, 0));
    CHECK(w.look().count == 0);
  }
  Watch w;
  w.hear(5, beat(link::mav::kTypeSurfaceBoat, link::mav::kAutopilotInvalid));
  w.hear(5, at(5, 0));
  w.hear(6, at(5, 0));  // never a heartbeat
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

TEST_CASE("a place that cannot be is passed over, and so is one in another ocean") {
  Watch w;
  w.hear(5, beat());
  w.hear(5, link::GlobalPositionInt{});
  w.hear(5, at(8000, 0));
  CHECK(w.look().count == 0);
  w.own.origin = {};  // nobody knows where we are ourselves
  w.hear(5, at(5, 0));
  CHECK(w.look().count == 0);
}

TEST_CASE("the leader, the shallower and the lower system id have the way; the unknown too") {
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
    other.hear(kLeader, value_of("DEPTH", 1, 0));
    other.meet(system, 0, 9, depth, steered);
    REQUIRE(other.look().count == 1);
    CHECK(other.look().vessels[0].has_way == has_way);
  }
}

TEST_CASE("behind a leader that tells no depth a boat is one deep; nonsense is no depth") {
  Watch w;
  CHECK(w.neighbours.depth() == 1);
  w.hear(kLeader, value_of("DEPTH", -1, 0));
  w.hear(kLeader, value_of("DEPTH", 251, 0));
  w.hear(kLeader, value_of("DEPTH", NAN, 0));
  w.hear(kLeader, value_of("DEPTHS", 7, 0));
  w.hear(kLeader, value_of("OTHER", 7, 0));
  CHECK(w.neighbours.depth() == 1);
  w.hear(kLeader, value_of("DEPTH", 250, 0));
  CHECK(w.neighbours.depth() == 250);  // who follows in a circle does not count for ever
  w.neighbours.configure(kOwn, 77, 1.5F);
  CHECK(w.neighbours.depth() == 1);
}

TEST_CASE("a silent vessel is forgotten after three seconds, and its place is another's") {
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
  w.hear(32, origin);  // nobody knows yet how near it is
  const auto seen = w.look();
  CHECK(seen.count == 8);
  double farthest_m = 0;
  for (const auto& v : seen.vessels) farthest_m = std::max(farthest_m, core::length(v.p_n));
  CHECK(farthest_m == doctest::Approx(70).epsilon(0.01));  // not the one at 80, nor that at 100
}

TEST_CASE("where our own origin changes, places from the old one are worth nothing") {
  Watch w;
  w.meet(5, 5, 0, 1);
  CHECK(w.look().count == 1);
  w.own.origin.latitude += 1000;
  CHECK(w.look().count == 0);
  w.meet(6, 30, 0, 1);
  CHECK(w.look().count == 1);
}

TEST_CASE("clear is when nobody is nearer than FS_SEP_M; without it nobody is looked for") {
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
}  // namespace flotilla::app
