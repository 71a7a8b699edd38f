// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "app/navigation/vessel_track.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kLimit_us = 500'000, kHour_us = 3'600'000'000;

/// A state from component 1 of system 5, a vessel on a straight course north at 2 m/s.
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

TEST_CASE_TEMPLATE("a vessel is extrapolated from its last message, with clocks hours apart", S,
                   float, double) {
  for (const std::int64_t offset : {std::int64_t{0}, 5 * kHour_us}) {
    Watch<S> w;
    CHECK_FALSE(w.track.fresh(0, kLimit_us));
    CHECK_FALSE(w.track.age_us(0));
    for (int k = 0; k <= 10; ++k) w.hear(at(k * 100'000 + offset, 0.2F * float(k)), k * 100'000);
    CHECK(w.track.age_us(1'250'000) == 250'000);
    CHECK(convert::number(w.track.position().north_m) == doctest::Approx(2));
    CHECK(double(w.track.motion(1'250'000).moved_n.x) == doctest::Approx(0.5));
    CHECK(w.track.fresh(1'499'999, kLimit_us));
    CHECK_FALSE(w.track.fresh(1'500'000, kLimit_us));
  }
}

TEST_CASE_TEMPLATE(
    "without smoothing no fix bridges a gap, and another vessel is not smoothed either", S, float,
    double) {
  Watch<S> w;
  w.track.set_smoothing(false);
  w.hear(at(0, 0), 0);
  CHECK(w.track.take_fix()->dt == S(0));
  w.hear(at(100'000, 0.2F), 100'000);
  CHECK(double(w.track.take_fix()->dt) == doctest::Approx(0.1));
  w.hear(at(2'300'000, 4.6F), 2'300'000);
  CHECK(w.track.take_fix()->dt == S(0));
  w.track.follow(6);
  w.track.set_limits(JumpGuard<S>::kAnyVessel);
  for (int k = 0; k <= 10; ++k) {
    w.hear(at(k * 100'000, 0.2F * float(k), 0.1F * float(k)), 3'000'000 + k * 100'000, {6, 1});
  }
  CHECK(w.track.motion(4'000'000).nu.u == S(1));
  CHECK(w.track.motion(4'000'000).nu_dot.u == S(0));
}

TEST_CASE_TEMPLATE("a state grows old while its vessel's clock is set back an hour", S, float,
                   double) {
  Watch<S> w;
  for (int k = 0; k <= 10; ++k) w.hear(at(kHour_us + k * 100'000, 0.2F * float(k)), k * 100'000);
  w.track.answered({5, 1}, 1'010'000, 1'020'000, 1'030'000);
  CHECK(w.track.age_us(1'400'000) == 400'000);
  CHECK(double(w.track.motion(1'400'000).moved_n.x) == doctest::Approx(0.8));
  CHECK(w.track.fresh(1'499'999, kLimit_us));
  CHECK_FALSE(w.track.fresh(1'500'000, kLimit_us));
}

TEST_CASE_TEMPLATE("another vessel, or our own messages, never move a track", S, float, double) {
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
    "repeated and backward stamps are refused; the last good state stays until stale", S, float,
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

TEST_CASE_TEMPLATE("when the fast link is lost, states of the slow one keep their true age", S,
                   float, double) {
  Watch<S> w;
  w.track.set_lag(0);
  const std::uint8_t resets = w.track.clock_resets();
  const auto said = [](std::int64_t t) { return at(kHour_us + t, 2e-6F * float(t)); };
  for (std::int64_t t = 0; t < 40'000'000; t += 100'000) {
    if (t < 10'000'000) w.hear(said(t), t);
    if (t >= 6'000'000) w.hear(said(t - 6'000'000), t);
    if (t >= 12'000'000) REQUIRE_FALSE(w.track.fresh(t, 2'000'000));
    if (t >= 17'000'000) REQUIRE(w.track.age_us(t) >= 5'980'000);
  }
  CHECK(w.track.clock_resets() == resets + 1);  // by the first state
}

TEST_CASE_TEMPLATE(
    "a vessel's reboot counts as a clock reset, because its latency may have changed", S, float,
    double) {
  Watch<S> w;
  for (std::int64_t t = 0; t < 2'000'000; t += 100'000) w.hear(at(9 * kHour_us + t, 1), t);
  const std::uint8_t resets = w.track.clock_resets();
  for (std::int64_t t = 3'000'000; t < 5'000'000; t += 100'000) w.hear(at(t - 2'500'000, 1), t);
  CHECK(w.track.clock_resets() != resets);
}

TEST_CASE_TEMPLATE(
    "the own unit, on one link, is accepted soon after its clock is set back by seconds", S, float,
    double) {
  Watch<S> w{VesselTrack<S>{typename VesselTrack<S>::Identity{5, 0, 300'000, 300'000, true}}, {}};
  w.track.set_lag(0);
  for (std::int64_t t = 0; t < 5'000'000; t += 100'000)
    w.hear(at(kHour_us + t, 2e-6F * float(t)), t);
  for (std::int64_t t = 5'000'000; t < 12'000'000; t += 100'000) {
    w.hear(at(kHour_us + t - 4'000'000, 2e-6F * float(t)), t);
    if (t >= 7'000'000) REQUIRE(w.track.fresh(t, kLimit_us));
  }
}

TEST_CASE_TEMPLATE(
    "after one stamp from the far future, states are accepted again within two seconds", S, float,
    double) {
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
    "an estimator reset is not taken for a motion from the old position to the new one", S, float,
    double) {
  Watch<S> w;
  link::Odometry m;
  for (std::int64_t t = 0; t <= 2'000'000; t += 100'000) {
    m = at(t, 2e-6F * float(t));
    m.reset_counter = 255;
    w.hear(m, t);
  }
  m = at(2'100'000, 50, -2);
  m.reset_counter = 0;
  w.hear(m, 2'100'000);
  CHECK(w.track.position().north_m == 50);
  CHECK(w.track.age_us(2'100'000) == 0);
  CHECK(w.track.fresh(2'100'000, kLimit_us));
  const auto motion = w.track.motion(2'100'000);
  CHECK(double(motion.nu_dot.u) == doctest::Approx(0));  // the velocity's step is no acceleration
  CHECK(double(motion.nu.u) == doctest::Approx(-2));
}

TEST_CASE_TEMPLATE("a late state from before a reset, over another radio, is still late", S, float,
                   double) {
  Watch<S> w;
  const auto told = [](std::int64_t stamp_us, std::uint8_t resets) {
    link::Odometry m = at(stamp_us, resets == 0 ? 1 : 50);
    m.reset_counter = resets;
    return m;
  };
  for (std::int64_t t = 0; t <= 1'000'000; t += 100'000) w.hear(told(t, 0), t);
  for (std::int64_t t = 1'100'000; t <= 2'000'000; t += 100'000) {
    w.hear(told(t, 1), t);
    REQUIRE(w.track.position().north_m == 50);
    if (t <= 1'300'000) w.hear(told(t - 300'000, 0), t);
    REQUIRE(w.track.position().north_m == 50);
    REQUIRE(w.track.age_us(t) == 0);
  }
}

TEST_CASE_TEMPLATE("a vessel whose estimator reports its failure gives no state", S, float,
                   double) {
  Watch<S> w;
  for (const int quality : {0, 1, 100, -1, -128}) {
    link::Odometry m = at(1'000'000 + 1000 * quality, 1);
    m.time_usec = w.counters.mavlink_bad_value * 1000U + static_cast<std::uint64_t>(quality + 200);
    m.quality = static_cast<std::int8_t>(quality);
    const auto before = w.track.age_us(5'000'000);
    w.hear(m, 1'000'000);
    if (quality < 0) CHECK(w.track.age_us(5'000'000) == before);
    CHECK(w.track.age_us(5'000'000).has_value());
  }
  CHECK(w.counters.mavlink_bad_value == 2);
}

TEST_CASE_TEMPLATE("a clock that jumps ahead by hours begins a new track, without motion between",
                   S, float, double) {
  Watch<S> w;
  std::int64_t t = 0;
  for (; t <= 1'000'000; t += 100'000) w.hear(at(t, 1, 2), t);
  w.hear(at(t + kHour_us, 2, -2), t);
  CHECK(w.track.position().north_m == 2);
  CHECK(w.track.age_us(t) == 0);
  CHECK(double(w.track.motion(t).nu_dot.u) == doctest::Approx(0));
  for (int k = 0; k < 20; ++k) {
    t += 100'000;
    w.hear(at(t + kHour_us, 2, -2), t);
    REQUIRE(w.track.fresh(t, kLimit_us));
    REQUIRE(w.track.age_us(t) == 0);
  }
  // An hour of silence is no leap.
  w.hear(at(t + 2 * kHour_us, 31, 2), t + kHour_us);
  CHECK(w.track.age_us(t + kHour_us) == 0);
}

TEST_CASE_TEMPLATE(
    "a message with NaN is counted and ignored; one in a frame without north is reported", S, float,
    double) {
  Watch<S> w;
  w.hear(at(1'000'000, 1), 1'000'000);
  w.hear(at(1'100'000, NAN), 1'100'000);
  CHECK(w.counters.mavlink_bad_value == 1);
  CHECK_FALSE(w.track.take_frame_warning());
  link::Odometry m = at(1'100'000, 9);
  m.frame_id = 20;
  w.hear(m, 1'100'000);
  CHECK(w.counters.mavlink_bad_frame == 1);
  CHECK(w.track.take_frame_warning());
  CHECK_FALSE(w.track.take_frame_warning());
  CHECK(w.track.position().north_m == 1);
}

TEST_CASE_TEMPLATE(
    "separate position and attitude give a state; ODOMETRY is preferred while it arrives", S, float,
    double) {
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
  for (int k = 0; k < 5; ++k) {
    CHECK(w.track.position().north_m == 5);
    w.hear(at(1'150'000 + k * 10'000, 6), 1'150'000 + k * 10'000);
  }
  w.hear(local(1300, 7), 1'300'000);
  CHECK(w.track.position().north_m == 6);
  w.hear(link::Attitude{2350, 0, 0, 0.5F, 0, 0, 0}, 2'350'000);
  w.hear(local(2400, 8), 2'400'000);  // ODOMETRY has been silent for more than a second
  CHECK(w.track.position().north_m == 8);
}

TEST_CASE_TEMPLATE("a component that sends ATTITUDE only does not silence another one's ODOMETRY",
                   S, float, double) {
  Watch<S> w;
  for (std::int64_t t = 0; t < 5'000'000; t += 100'000) {
    w.hear(link::Attitude{static_cast<std::uint32_t>(t / 1000), 0, 0, 0, 0, 0, 0}, t, {5, 1});
    w.hear(at(t + 1, 2), t, {5, 2});
    if (t > 2'000'000) REQUIRE(w.track.fresh(t, kLimit_us));
  }
}

TEST_CASE_TEMPLATE("a heading four seconds old is not combined with a position", S, float, double) {
  Watch<S> w;
  w.hear(link::Attitude{1000, 0, 0, 0.5F, 0, 0, 0}, 1'000'000);
  w.hear(link::LocalPositionNed{5000, 1, 0, 0, 1, 0, 0}, 5'000'000);
  CHECK_FALSE(w.track.age_us(5'000'000));
}

TEST_CASE_TEMPLATE("TIMESYNC gives the age of a delayed message", S, float, double) {
  Watch<S> w;
  for (std::int64_t t = 0; t < 3'000'000; t += 100'000) w.hear(at(t + kHour_us, 0), t + 80'000);
  CHECK(w.track.age_us(3'000'000) == 20'000);  // the fastest message counts as undelayed
  w.track.answered({5, 1}, 2'000'000, 2'080'000 + kHour_us, 2'160'000);
  CHECK(w.track.age_us(3'000'000) == 100'000);
  w.track.answered({6, 1}, 2'000'000, 2'000'000 + kHour_us, 2'160'000);
  CHECK(w.track.age_us(3'000'000) == 100'000);
}

TEST_CASE_TEMPLATE(
    "an origin counts if its coordinates are valid; the antenna's offset is subtracted", S, float,
    double) {
  Watch<S> w;
  w.hear(link::GpsGlobalOrigin{950'000'000, 0, 0, 0}, 0);
  CHECK_FALSE(w.track.has_origin());
  w.hear(link::GpsGlobalOrigin{410'000'000, 20'000'000, 0, 0}, 0);
  CHECK_FALSE(w.track.has_origin());  // the component is unknown before the first state
  w.hear(at(1000, 7), 1000);
  CHECK(w.track.has_origin());
  CHECK(w.track.position().origin.latitude == 410'000'000);
  VesselTrack<S> track({5, 0}, {S(1.5), S(0.5)});
  track.take({{5, 1}, at(1000, 10)}, 1000, w.counters);
  CHECK(convert::number(track.position().north_m) == doctest::Approx(8.5));
  CHECK(convert::number(track.position().east_m) == doctest::Approx(-0.5));
}

// The messages of four sources of a vessel that sails north at 2 m/s. Each source has its own
// place, by which the tests recognise it.

constexpr std::int64_t kPeriod_us = 100'000;
const link::GpsGlobalOrigin kOrigin{487'000'000, 22'950'000, 0, 0};

link::LocalPositionNed local_at(std::int64_t us, float east_m) {
  return {convert::boot_ms(us), 0, east_m, 0, 2, 0, 0};
}

link::GlobalPositionInt global_at(std::int64_t us, double east_m) {
  const auto at = convert::global_of({0, east_m, kOrigin});
  return {convert::boot_ms(us), at.latitude, at.longitude, 0, 0, 200, 0, 0, 65535};
}

link::FollowTarget follow_target_at(std::int64_t us, double east_m) {
  const auto at = convert::global_of({0, east_m, kOrigin});
  link::FollowTarget m{};
  m.timestamp = static_cast<std::uint64_t>(us / 1000);
  m.lat = at.latitude, m.lon = at.longitude;
  m.vel = {2, 0, 0};
  m.attitude_q = {1, 0, 0, 0};
  m.est_capabilities = 1 | 2 | 8;
  return m;
}

link::Odometry odometry_at(std::int64_t us, float east_m) {
  link::Odometry m = at(us, 0);
  m.y = east_m;
  return m;
}

constexpr float kOdometryEast = 0.1F, kLocalEast = 0.2F, kFollowEast = 0.3F, kGlobalEast = 0.4F;

template <class S>
struct FourSources : Watch<S> {
  bool odometry = false, local = false, follow = false, global = false, origin = true;
  std::int64_t now_us = 1'000'000;

  /// Sends all active sources ten times a second.
  void sail(double seconds) {
    const std::int64_t end = now_us + static_cast<std::int64_t>(seconds * 1e6);
    for (; now_us < end; now_us += kPeriod_us) {
      if (origin) this->hear(kOrigin, now_us);
      this->hear(link::Attitude{convert::boot_ms(now_us), 0, 0, 0, 0, 0, 0}, now_us);
      if (global) this->hear(global_at(now_us, kGlobalEast), now_us);
      if (follow) this->hear(follow_target_at(now_us, kFollowEast), now_us);
      if (local) this->hear(local_at(now_us, kLocalEast), now_us);
      if (odometry) this->hear(odometry_at(now_us, kOdometryEast), now_us);
    }
  }
  /// Whether the position has this offset to the east, which identifies the source in use.
  bool believes(double east_m) const {
    return std::abs(convert::number(this->track.position().east_m) - east_m) < 0.03;
  }
};

TEST_CASE_TEMPLATE("the most precise source available is used", S, float, double) {
  FourSources<S> w;
  w.global = true;
  w.sail(1);
  CHECK(w.believes(kGlobalEast));
  w.follow = true;
  w.sail(1);
  CHECK(w.believes(kFollowEast));
  w.local = true;
  w.sail(1);
  CHECK(w.believes(kLocalEast));
  w.odometry = true;
  w.sail(1);
  CHECK(w.believes(kOdometryEast));
  w.odometry = false;
  w.sail(1);
  CHECK(w.believes(kLocalEast));
  w.local = w.follow = false;
  w.sail(1);
  CHECK(w.believes(kGlobalEast));
  CHECK(w.counters.mavlink_bad_value + w.counters.mavlink_no_heading == 0);
}

TEST_CASE_TEMPLATE("a local position without a known origin ranks below every global one", S, float,
                   double) {
  FourSources<S> w;
  w.origin = false;
  w.odometry = true;
  w.sail(1);
  CHECK(w.believes(kOdometryEast));  // better than nothing
  CHECK_FALSE(w.track.has_origin());
  w.global = true;
  w.sail(1);
  CHECK(w.track.has_origin());
  CHECK(w.believes(0));  // from its own first fix
  w.origin = true;
  w.sail(1);
  CHECK(w.believes(kOdometryEast));
  CHECK(w.track.position().origin.longitude == kOrigin.longitude);
}

TEST_CASE_TEMPLATE("a fix on the other side of the globe does not count as near the old position",
                   S, float, double) {
  Watch<S> w;
  const auto hear = [&](std::int64_t us, std::int32_t longitude) {
    w.hear(link::Attitude{convert::boot_ms(us), 0, 0, 0, 0, 0, 0}, us);
    w.hear(link::GlobalPositionInt{convert::boot_ms(us), 0, longitude, 0, 0, 0, 0, 0, 0}, us);
    return convert::near({0, 0, {0, 22'950'000, 0, 0}}, w.track.position());
  };
  std::int64_t us = 1'000'000;
  CHECK(hear(us, 22'950'000));
  // It takes a second until another place is believed.
  for (int k = 0; k < 11; ++k) hear(us += 100'000, 22'950'000 - 1'800'000'000);
  CHECK_FALSE(hear(us += 100'000, 22'950'000 - 1'800'000'000));
  for (int k = 0; k < 11; ++k) hear(us += 100'000, 22'950'100);
  CHECK(hear(us += 100'000, 22'950'100));
}

TEST_CASE_TEMPLATE("after a reboot, the old origin is not used, whichever source comes first", S,
                   float, double) {
  for (const bool odometry : {false, true}) {
    FourSources<S> w;
    w.odometry = w.local = true;
    w.sail(2);
    CHECK(w.track.has_origin());
    w.track.take_fix();
    int believed = 0;
    for (std::int64_t t = 0; t < 4'000'000; t += kPeriod_us) {
      const std::int64_t now_us = w.now_us + t;
      w.hear(link::Attitude{convert::boot_ms(t), 0, 0, 0, 0, 0, 0}, now_us);
      w.hear(local_at(t, 0.5F), now_us);
      if (odometry) w.hear(odometry_at(t, 0.5F), now_us);
      if (w.track.take_fix()) ++believed;
      if (believed > 0) REQUIRE_FALSE(w.track.has_origin());
    }
    CHECK(believed > 15);
    CHECK(w.track.position().east_m == 0.5F);
    w.hear(kOrigin, w.now_us + 4'000'000);
    CHECK_FALSE(w.track.has_origin());  // until its next place is compared with the last one
    const std::int64_t next_us = 4'100'000;
    w.hear(link::Attitude{convert::boot_ms(next_us), 0, 0, 0, 0, 0, 0}, w.now_us + next_us);
    w.hear(local_at(next_us, 0.5F), w.now_us + next_us);
    if (odometry) w.hear(odometry_at(next_us, 0.5F), w.now_us + next_us);
    CHECK(w.track.has_origin());
  }
}

TEST_CASE_TEMPLATE("changing the source keeps the acceleration and the age measured by TIMESYNC", S,
                   float, double) {
  constexpr std::int64_t kDelay_us = 150'000, kClock_us = kHour_us;
  Watch<S> w;
  double before = 0, motion = 0;
  w.hear(kOrigin, 0);
  for (std::int64_t t = 1'000'000; t < 6'000'000; t += kPeriod_us) {
    const double v = 1 + 0.2e-6 * double(t), way = 1e-6 * double(t) * (1 + 0.1e-6 * double(t));
    link::GlobalPositionInt global = global_at(t + kClock_us, 0);
    const auto place = convert::global_of({way, 0, kOrigin});
    global.lat = place.latitude, global.lon = place.longitude;
    global.vx = static_cast<std::int16_t>(std::lround(100 * v));
    const std::int64_t now = t + kDelay_us;
    w.hear(link::Attitude{convert::boot_ms(t + kClock_us), 0, 0, 0, 0, 0, 0}, now);
    w.hear(global, now);
    if (t < 4'000'000) w.hear(at(t + kClock_us, float(way), float(v)), now);
    w.track.answered({5, 1}, now - 2 * kDelay_us, now - kDelay_us + kClock_us, now);
    const auto m = w.track.motion(now);
    const auto fix = w.track.take_fix();
    motion = convert::number(w.track.position().north_m) + double(m.moved_n.x);
    const double truth = 1e-6 * double(now) * (1 + 0.1e-6 * double(now));
    if (t > 2'000'000) {
      CAPTURE(t);
      CHECK(std::abs(motion - truth) < 0.05);
      CHECK(std::abs(double(m.nu.u) - (1 + 0.2e-6 * double(now))) < 0.05);
      CHECK(std::abs(double(m.nu_dot.u) - 0.2) < 0.08);
      // ODOMETRY's last was 0.6 s before GLOBAL_POSITION_INT took over.
      if (fix) CHECK(double(fix->dt) == doctest::Approx(t == 4'500'000 ? 0.6 : 0.1).epsilon(1e-3));
      CHECK(motion > before);
    }
    before = motion;
  }
}

TEST_CASE_TEMPLATE("FOLLOW_TARGET without attitude is combined with the ATTITUDE of its own time",
                   S, float, double) {
  Watch<S> w;
  link::FollowTarget m = follow_target_at(1'000'000, 0);
  m.est_capabilities = 1 | 2;
  w.hear(m, 1'000'000);
  CHECK(w.counters.mavlink_no_heading == 1);
  w.hear(link::Attitude{900, 0, 0, 0.5F, 0, 0, 0.1F}, 1'000'000);
  w.hear(m, 1'000'000);
  CHECK(double(w.track.take_fix().value().psi) == doctest::Approx(0.51));
  m.timestamp = 1'700'000'000'000;  // a clock other than ATTITUDE's
  w.hear(m, 1'100'000);
  CHECK(w.counters.mavlink_no_heading == 2);
}

TEST_CASE_TEMPLATE("a message without fix, with NaN or without state is counted and moves nothing",
                   S, float, double) {
  FourSources<S> w;
  w.global = w.follow = true;
  w.sail(1);
  w.track.take_fix();
  link::GlobalPositionInt global = global_at(w.now_us, 0);
  global.lat = global.lon = 0;
  w.hear(global, w.now_us);
  global.lat = INT32_MIN;
  w.hear(global, w.now_us);
  link::FollowTarget target = follow_target_at(w.now_us, 0);
  target.vel[1] = NAN;
  w.hear(target, w.now_us);
  target = follow_target_at(w.now_us, 0);
  target.est_capabilities = 1;
  w.hear(target, w.now_us);
  w.hear(link::LocalPositionNed{convert::boot_ms(w.now_us), NAN, 0, 0, 0, 0, 0}, w.now_us);
  CHECK(w.counters.mavlink_bad_value == 5);
  CHECK_FALSE(w.track.take_fix());
}

TEST_CASE_TEMPLATE("following another vessel discards all data of the previous one", S, float,
                   double) {
  FourSources<S> w;
  w.odometry = w.local = true;
  w.sail(2);
  link::Odometry frd = odometry_at(w.now_us, 0);
  frd.frame_id = 20;
  w.hear(frd, w.now_us);
  w.track.follow(5);  // the same vessel
  CHECK(w.track.fresh(w.now_us, kLimit_us));
  w.track.follow(7);
  CHECK_FALSE(w.track.age_us(w.now_us));
  CHECK_FALSE(w.track.fresh(w.now_us, kLimit_us));
  CHECK_FALSE(w.track.has_origin());
  CHECK_FALSE(w.track.take_frame_warning());
  w.hear(odometry_at(w.now_us, 0), w.now_us);
  CHECK_FALSE(w.track.age_us(w.now_us));  // a message of the old vessel
  w.hear(local_at(w.now_us, 3), w.now_us, {7, 1});
  CHECK(w.counters.mavlink_no_heading == 1);  // the old one's ATTITUDE is not the new one's
  w.hear(at(50'000, 3), w.now_us, {7, 1});
  CHECK(w.track.age_us(w.now_us) == 0);  // nor are its clock and stamps used
  CHECK(w.track.position().north_m == 3);
  CHECK(double(w.track.motion(w.now_us).nu_dot.u) == 0);
}

TEST_CASE_TEMPLATE("a new antenna offset applies from the next message on", S, float, double) {
  Watch<S> w;
  w.hear(at(1'000'000, 10), 1'000'000);
  w.track.set_antenna({S(1.5), S(0.5)});
  CHECK(w.track.position().north_m == 10);
  w.hear(at(1'100'000, 10), 1'100'000);
  CHECK(convert::number(w.track.position().north_m) == doctest::Approx(8.5));
}

TEST_CASE_TEMPLATE("the longer a vessel is silent, the less certain its position", S, float,
                   double) {
  Watch<S> w;
  CHECK_FALSE(w.track.uncertainty_m(0));
  for (std::int64_t t = 1'000'000; t <= 2'000'000; t += 100'000) w.hear(at(t, 1e-6F * float(t)), t);
  const double now_m = w.track.uncertainty_m(2'000'000).value();
  CHECK(w.track.uncertainty_m(2'500'000).value() > now_m);
  CHECK(w.track.uncertainty_m(3'000'000).value() > w.track.uncertainty_m(2'500'000).value());
}

}  // namespace
}  // namespace flotilla::app
