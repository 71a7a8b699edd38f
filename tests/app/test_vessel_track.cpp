// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "app/vessel_track.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kLimit_us = 500'000, kHour_us = 3'600'000'000;

/// A vessel of system 5 on a straight course north at 2 m/s: what its component 1 says of time t.
link::Odometry at(std::int64_t stamp_us, float north_m, float speed = 2) {
  link::Odometry m{};
  m.time_usec = static_cast<std::uint64_t>(stamp_us);
  m.x = north_m;
  m.q = {1, 0, 0, 0};
  m.vx = speed;
  m.frame_id = 1;
  m.child_frame_id = 12;
  return m;
}

template <class S>
struct Watch {
  VesselTrack<S> track{{5, 0}};
  link::Counters counters;
  void hear(const link::Message& message, std::int64_t now_us, link::Address from = {5, 1}) {
    track.take({from, message}, now_us, counters);
  }
};

TEST_CASE_TEMPLATE("a vessel is carried forward from its last message, hours apart in clock", S,
                   float, double) {
  for (const std::int64_t offset : {std::int64_t{0}, 5 * kHour_us}) {
    Watch<S> w;
    CHECK_FALSE(w.track.fresh(0, kLimit_us));
    CHECK_FALSE(w.track.age_us(0));
    for (int k = 0; k <= 10; ++k) w.hear(at(k * 100'000 + offset, 0.2F * float(k)), k * 100'000);
    CHECK(w.track.age_us(1'250'000) == 250'000);
    CHECK(w.track.position().north_m == doctest::Approx(2));
    CHECK(double(w.track.motion(1'250'000).moved_n.x) == doctest::Approx(0.5));
    CHECK(w.track.fresh(1'499'999, kLimit_us));
    CHECK_FALSE(w.track.fresh(1'500'000, kLimit_us));
  }
}

TEST_CASE_TEMPLATE("another vessel, or our own voice, never moves a track", S, float, double) {
  Watch<S> w;
  w.hear(at(1000, 7), 1000, {6, 1});
  w.hear(at(1000, 7), 1000, {0, 1});
  w.hear(at(1000, 7), 1000, {5, 0});
  CHECK_FALSE(w.track.age_us(1000));
  VesselTrack<S> own({5, 1});
  own.take({{5, 1}, at(1000, 7)}, 1000, w.counters);
  CHECK_FALSE(own.age_us(1000));
  own.take({{5, 2}, at(1000, 7)}, 1000, w.counters);
  CHECK(own.age_us(1000));
}

TEST_CASE_TEMPLATE(
    "repeated and backward stamps are refused, the last good state stays until stale", S, float,
    double) {
  Watch<S> w;
  w.hear(at(1'000'000, 1), 1'000'000);
  w.hear(at(1'100'000, 2), 1'100'000);
  w.hear(at(1'100'000, 50), 1'200'000);
  w.hear(at(1'000'000, 60), 1'300'000);
  CHECK(w.counters.mavlink_old_stamp == 2);
  CHECK(w.track.position().north_m == 2);
  CHECK(w.track.age_us(1'300'000) == 200'000);
  CHECK(w.track.fresh(1'599'999, kLimit_us));
  CHECK_FALSE(w.track.fresh(1'600'000, kLimit_us));
}

TEST_CASE_TEMPLATE("a vessel that rebooted is believed again after a second", S, float, double) {
  Watch<S> w;
  w.hear(at(9 * kHour_us, 1), 1'000'000);
  std::int64_t believed = 0;
  for (std::int64_t t = 1'100'000; t < 4'000'000 && believed == 0; t += 100'000) {
    w.hear(at(t - 1'000'000, 5), t);
    if (w.track.position().north_m == 5) believed = t;
  }
  CHECK(believed > 0);
  CHECK(believed <= 2'200'000);
  CHECK(w.track.age_us(believed) == 0);
  CHECK(std::isfinite(double(w.track.motion(believed + 100'000).moved_n.x)));
}

TEST_CASE_TEMPLATE("one stamp from the far future costs two seconds at most", S, float, double) {
  Watch<S> w;
  for (std::int64_t t = 0; t < 10'000'000; t += 100'000) {
    w.hear(at(t == 5'000'000 ? 20 * kHour_us : t + 1000, 3), t);
    const auto motion = w.track.motion(t);
    REQUIRE(std::isfinite(double(motion.moved_n.x)));
    REQUIRE(std::abs(double(motion.nu_dot.u)) < 10);
    if (t > 7'000'000) CHECK(w.track.fresh(t, kLimit_us));
  }
}

TEST_CASE_TEMPLATE(
    "a message with NaN is counted and forgotten, one without north complained about", S, float,
    double) {
  Watch<S> w;
  w.hear(at(1'000'000, 1), 1'000'000);
  w.hear(at(1'100'000, NAN), 1'100'000);
  CHECK(w.counters.mavlink_bad_value == 1);
  CHECK_FALSE(w.track.take_frame_complaint());
  link::Odometry m = at(1'100'000, 9);
  m.frame_id = 20;
  w.hear(m, 1'100'000);
  CHECK(w.counters.mavlink_bad_frame == 1);
  CHECK(w.track.take_frame_complaint());
  CHECK_FALSE(w.track.take_frame_complaint());
  CHECK(w.track.position().north_m == 1);
}

TEST_CASE_TEMPLATE("position and attitude apart make a state; ODOMETRY is preferred while it comes",
                   S, float, double) {
  Watch<S> w;
  const auto local = [](std::uint32_t ms, float x) {
    return link::LocalPositionNed{ms, x, 0, 0, 1, 0, 0};
  };
  w.hear(local(1000, 4), 1'000'000);
  CHECK_FALSE(w.track.age_us(1'000'000));  // no heading yet
  w.hear(link::Attitude{1000, 0, 0, 0.5F, 0, 0, 0}, 1'000'000);
  w.hear(local(1100, 5), 1'100'000);
  CHECK(w.track.position().north_m == 5);
  CHECK(double(w.track.motion(1'100'000).psi) == doctest::Approx(0.5));
  w.hear(at(1'200'000, 6), 1'200'000);
  w.hear(local(1300, 7), 1'300'000);
  CHECK(w.track.position().north_m == 6);
  w.hear(link::Attitude{2350, 0, 0, 0.5F, 0, 0, 0}, 2'350'000);
  w.hear(local(2400, 8), 2'400'000);  // ODOMETRY has been silent for more than a second
  CHECK(w.track.position().north_m == 8);
}

TEST_CASE_TEMPLATE(
    "of two components that send state the lower is heard, the other when it is gone", S, float,
    double) {
  Watch<S> w;
  w.hear(at(1'000'000, 2), 1'000'000, {5, 2});
  CHECK(w.track.position().north_m == 2);
  w.hear(at(1'100'000, 1), 1'100'000, {5, 1});
  CHECK(w.track.position().north_m == 1);
  w.hear(at(1'200'000, 2), 1'200'000, {5, 2});
  CHECK(w.track.position().north_m == 1);
  w.hear(at(2'300'000, 2), 2'300'000, {5, 2});
  CHECK(w.track.position().north_m == 2);
}

TEST_CASE_TEMPLATE("a lower component with an attitude but no position silences nobody", S, float,
                   double) {
  Watch<S> w;
  for (std::int64_t t = 0; t < 5'000'000; t += 100'000) {
    w.hear(link::Attitude{static_cast<std::uint32_t>(t / 1000), 0, 0, 0, 0, 0, 0}, t, {5, 1});
    w.hear(at(t + 1, 2), t, {5, 2});
    if (t > 2'000'000) REQUIRE(w.track.fresh(t, kLimit_us));
  }
}

TEST_CASE_TEMPLATE("a heading of another time is not joined with a position", S, float, double) {
  Watch<S> w;
  w.hear(link::Attitude{1000, 0, 0, 0.5F, 0, 0, 0}, 1'000'000);
  w.hear(link::LocalPositionNed{5000, 1, 0, 0, 1, 0, 0}, 5'000'000);
  CHECK_FALSE(w.track.age_us(5'000'000));
}

TEST_CASE_TEMPLATE("TIMESYNC tells the age of a message that was long on its way", S, float,
                   double) {
  Watch<S> w;
  for (std::int64_t t = 0; t < 3'000'000; t += 100'000) w.hear(at(t + kHour_us, 0), t + 80'000);
  CHECK(w.track.age_us(3'000'000) == 20'000);  // believes the quickest way took no time
  w.track.answered({5, 1}, 2'000'000, 2'080'000 + kHour_us, 2'160'000);
  CHECK(w.track.age_us(3'000'000) == 100'000);
  w.track.answered({6, 1}, 2'000'000, 2'000'000 + kHour_us, 2'160'000);
  CHECK(w.track.age_us(3'000'000) == 100'000);
}

TEST_CASE_TEMPLATE("an origin counts when it is on the globe; the antenna's offset is taken out", S,
                   float, double) {
  Watch<S> w;
  w.hear(link::GpsGlobalOrigin{950'000'000, 0, 0, 0}, 0);
  CHECK_FALSE(w.track.has_origin());
  w.hear(link::GpsGlobalOrigin{410'000'000, 20'000'000, 0, 0}, 0);
  CHECK_FALSE(w.track.has_origin());  // of whom, is not known before there is a state
  w.hear(at(1000, 7), 1000);
  CHECK(w.track.has_origin());
  CHECK(w.track.position().origin.latitude == 410'000'000);
  VesselTrack<S> track({5, 0}, {1.5, 0.5});
  track.take({{5, 1}, at(1000, 10)}, 1000, w.counters);
  CHECK(track.position().north_m == doctest::Approx(8.5));
  CHECK(track.position().east_m == doctest::Approx(-0.5));
}

}  // namespace
}  // namespace flotilla::app
