// SPDX-License-Identifier: MIT
// Jumps: an impossible motion does not move a track until it has been reported for a second.
#include <doctest/doctest.h>

#include <algorithm>
#include <tuple>
#include <vector>

#include "app/navigation/vessel_track.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kPeriod_us = 100'000, kHour_us = 3'600'000'000;

/// A state of system 5, a vessel that sails north at 1 m/s, `off` east of the origin.
link::Odometry at(std::int64_t us, double off, std::int64_t clock_us = 0) {
  link::Odometry m{};
  m.time_usec = static_cast<std::uint64_t>(us + clock_us);
  m.x = static_cast<float>(1e-6 * double(us));
  m.y = static_cast<float>(off);
  m.q = {1, 0, 0, 0};
  m.vx = 1;
  m.frame_id = 1;
  m.child_frame_id = 12;
  return m;
}

template <class S>
struct Watch {
  VesselTrack<S> track{{5, 0}};
  link::Counters counters;
  std::int64_t now_us = 1'000'000;

  void hear(const link::Message& message) { track.take({{5, 1}, message}, now_us, counters); }
  /// Receives states at 10 Hz, `off` to the east.
  void sail(double seconds, double off = 0) {
    const std::int64_t end_us = now_us + static_cast<std::int64_t>(seconds * 1e6);
    for (; now_us < end_us; now_us += kPeriod_us) hear(at(now_us, off));
  }
  double east_m() const { return convert::number(track.position().east_m); }
  bool steady() const { return track.steady(now_us); }
};

TEST_CASE_TEMPLATE(
    "a jump does not move the vessel, is counted, and makes it unsteady for a second", S, float,
    double) {
  Watch<S> w;
  w.sail(2);
  CHECK(w.steady());
  w.hear(at(w.now_us, 5));
  CHECK(w.east_m() == 0);
  CHECK(w.counters.mavlink_jump == 1);
  CHECK_FALSE(w.steady());
  w.now_us += kPeriod_us;
  w.sail(0.8);
  CHECK_FALSE(w.steady());
  w.sail(0.2);
  CHECK(w.steady());
  CHECK(w.east_m() == 0);
  CHECK(w.counters.mavlink_jump == 1);
}

TEST_CASE_TEMPLATE("a new position is accepted after a second and five messages", S, float,
                   double) {
  Watch<S> w;
  w.sail(2);
  w.sail(1, 50);
  CHECK(w.east_m() == 0);
  CHECK_FALSE(w.track.jumped());
  w.sail(0.1, 50);
  CHECK(w.east_m() == 50);
  CHECK_FALSE(w.steady());
  CHECK(w.track.jumped());
  CHECK(double(w.track.motion(w.now_us).nu_dot.u) == doctest::Approx(0));  // the jump is no motion
  w.sail(1.1, 50);
  CHECK(w.steady());
  CHECK(w.track.jumped());  // until that is accepted
  w.track.accept_place();
  CHECK_FALSE(w.track.jumped());
  CHECK(w.counters.mavlink_jump == 10);
  Watch<S> rare;  // 2 Hz: five of them take longer than a second
  rare.sail(2);
  for (int k = 0; k < 4; ++k, rare.now_us += 500'000) rare.hear(at(rare.now_us, 50));
  CHECK(rare.east_m() == 0);
  rare.hear(at(rare.now_us, 50));
  CHECK(rare.east_m() == 50);
}

TEST_CASE_TEMPLATE("positions that contradict each other are never accepted", S, float, double) {
  Watch<S> w;
  w.sail(2);
  for (int k = 0; k < 100; ++k) w.sail(0.1, k % 2 == 0 ? 300 : -300);
  CHECK(w.east_m() == 0);
  CHECK_FALSE(w.steady());
}

TEST_CASE_TEMPLATE(
    "of two vessels with one system id, the first is followed, whatever their clocks", S, float,
    double) {
  for (const std::int64_t clock_us :
       {std::int64_t{40'000}, std::int64_t{90'000'000}, -std::int64_t{500'000}, kHour_us}) {
    CAPTURE(clock_us);
    Watch<S> w;
    w.sail(2);
    for (int k = 0; k < 100; ++k) {
      w.hear(at(w.now_us, 0));
      w.hear(at(w.now_us, 20, clock_us));
      w.now_us += kPeriod_us;
      REQUIRE(w.east_m() == 0);
      REQUIRE(w.track.fresh(w.now_us, 500'000));
      REQUIRE_FALSE(w.steady());
    }
    w.sail(1.1);
    CHECK(w.steady());
    CHECK(w.east_m() == 0);
  }
}

TEST_CASE_TEMPLATE("another sender's reset counter makes no jump acceptable", S, float, double) {
  Watch<S> w;
  w.sail(2);
  link::Odometry other = at(0, 20);
  for (int k = 0; k < 50; ++k) {
    w.hear(at(w.now_us, 0));
    other = at(w.now_us + 40'000, 20);
    other.reset_counter = 7;
    w.hear(other);
    w.now_us += kPeriod_us;
    REQUIRE(w.east_m() == 0);
  }
  other = at(w.now_us, 20);
  other.reset_counter = 1;  // the next reset of its own
  w.hear(other);
  CHECK(w.east_m() == 20);
}

TEST_CASE_TEMPLATE("after a gap a vessel may be farther away, but within limits", S, float,
                   double) {
  const std::vector<std::tuple<double, double, bool>> gaps{
      {0, 4, false}, {2, 4, true}, {2, 100, false}, {20, 90, true}};
  for (const auto& [gap_s, off_m, legal] : gaps) {
    CAPTURE(gap_s);
    CAPTURE(off_m);
    Watch<S> w;
    w.sail(2);
    w.now_us += static_cast<std::int64_t>(gap_s * 1e6);
    w.hear(at(w.now_us, off_m));
    CHECK((w.east_m() == off_m) == legal);
    CHECK(w.steady() == legal);
  }
}

TEST_CASE_TEMPLATE("a receiver whose positions scatter by metres gets a tolerance of metres", S,
                   float, double) {
  Watch<S> w;
  for (int k = 0; k < 600; ++k) w.sail(0.1, 0.01 * std::min(k, 200) * ((k * 7) % 5 - 2) * 0.4);
  CHECK(w.counters.mavlink_jump == 0);
  CHECK(w.steady());
  w.sail(0.1, 40);
  CHECK_FALSE(w.steady());
}

TEST_CASE_TEMPLATE("a clock that leaps by hours while its vessel sails on is no jump", S, float,
                   double) {
  Watch<S> w;
  w.sail(2);
  for (int k = 0; k < 50; ++k, w.now_us += kPeriod_us) {
    w.hear(at(w.now_us, 0, kHour_us));
    REQUIRE(w.track.age_us(w.now_us) == 0);
    REQUIRE(w.steady());
  }
  CHECK(w.counters.mavlink_jump == 0);
}

TEST_CASE_TEMPLATE("a fix across the globe is a jump; after a second it is a new position", S,
                   float, double) {
  Watch<S> w;
  const auto hear = [&](std::int32_t longitude) {
    w.hear(link::Attitude{convert::boot_ms(w.now_us), 0, 0, 0, 0, 0, 0});
    w.hear(link::GlobalPositionInt{convert::boot_ms(w.now_us), 0, longitude, 0, 0, 0, 0, 0, 0});
    w.now_us += kPeriod_us;
    return convert::near({0, 0, {0, 22'950'000, 0, 0}}, w.track.position());
  };
  for (int k = 0; k < 10; ++k) REQUIRE(hear(22'950'000));
  for (int k = 0; k < 10; ++k) REQUIRE(hear(22'950'000 - 1'800'000'000));
  CHECK_FALSE(w.steady());
  CHECK_FALSE(hear(22'950'000 - 1'800'000'000));
  CHECK_FALSE(hear(22'950'000 - 1'800'000'000));
}

}  // namespace
}  // namespace flotilla::app
