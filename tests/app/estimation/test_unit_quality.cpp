// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "app/estimation/unit_quality.hpp"

namespace flotilla::app {
namespace {

constexpr UnitQuality::Limits kLimits{.fix = 3, .hdop = 2.5F, .accuracy_m = 3, .ratio = 0.8F};
constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr std::uint16_t kWell = 1 | 2 | 8 | 16;

struct Unit {
  UnitQuality quality;
  std::int64_t now_us = 0;
  UnitQuality::Limits limits = kLimits;

  void say(const link::Message& message, std::uint8_t component = 2) {
    quality.take({{1, component}, message}, limits, now_us += 100'000);
  }
  bool good() const { return quality.good(now_us); }
};

link::GpsRawInt gps(std::uint8_t fix, std::uint16_t eph) {
  link::GpsRawInt m{};
  m.fix_type = fix;
  m.eph = eph;
  return m;
}

link::EstimatorStatus estimator(float accuracy_m, float ratio = 0.1F, std::uint16_t flags = kWell) {
  link::EstimatorStatus m{};
  m.flags = flags;
  m.pos_horiz_accuracy = accuracy_m;
  m.vel_ratio = m.pos_horiz_ratio = ratio;
  m.mag_ratio = kUnknown;
  return m;
}

link::EkfStatusReport ekf(float variance, std::uint16_t flags = kWell) {
  return {flags, 0.1F, variance, 0.1F};
}

link::Odometry odometry(float north_m2, float east_m2) {
  link::Odometry m{};
  m.pose_covariance[0] = north_m2;
  m.pose_covariance[6] = east_m2;
  return m;
}

TEST_CASE("a unit that does not report its quality counts as good, and as not reporting") {
  Unit u;
  CHECK(u.good());
  u.say(link::Attitude{});
  u.say(odometry(kUnknown, 0));
  u.say(odometry(-1, -1));
  CHECK(u.good());
  CHECK_FALSE(u.quality.told());
  u.say(gps(3, 100));
  CHECK(u.quality.told());
}

TEST_CASE("every kind of quality message can report a poor estimate, with the reason") {
  struct Case {
    link::Message good, poor;
    std::string_view why;
  };
  for (const auto& [good, poor, why] : {
           Case{gps(3, 250), gps(2, 100), "GPS fix type"},
           Case{gps(6, UINT16_MAX), gps(3, 251), "GPS HDOP"},
           Case{estimator(3), estimator(500), "position accuracy"},
           Case{estimator(kUnknown), estimator(1, 0.81F), "estimator test ratios"},
           Case{estimator(1), estimator(1, 0.1F, kWell | 1024), "estimator flags"},
           Case{estimator(1), estimator(1, 0.1F, kWell & ~1U), "estimator flags"},
           Case{ekf(0.8F), ekf(1), "estimator test ratios"},
           Case{ekf(0.1F), ekf(0.1F, kWell | 128), "estimator flags"},
           Case{ekf(0.1F, kWell & ~8U), ekf(0.1F, 1 | 2), "estimator flags"},
           Case{ekf(0.1F), ekf(0.1F, kWell | 32768), "estimator flags"},
           Case{odometry(9, 9), odometry(1, 9.1F), "position accuracy"},
       }) {
    Unit u;
    u.say(good);
    CHECK(u.good());
    u.say(poor);
    CHECK_FALSE(u.good());
    CHECK(u.quality.fault() == why);
  }
}

TEST_CASE("an unknown ratio does not hide a bad one") {
  for (const float bad : {50.0F, 0.1F}) {
    Unit u;
    link::EstimatorStatus m = estimator(1);
    m.vel_ratio = kUnknown;
    m.pos_horiz_ratio = bad;
    u.say(m);
    CHECK(u.good() == (bad < 1));
  }
}

TEST_CASE("a limit of 0 means no limit") {
  Unit u;
  u.limits = {};
  for (const link::Message& m : {link::Message(gps(0, 9999)), link::Message(estimator(500, 9)),
                                 link::Message(ekf(9)), link::Message(odometry(1e6F, 1e6F))}) {
    u.say(m);
    CHECK(u.good());
  }
}

TEST_CASE("a poor estimate counts as good after a second at a fifth below its limit") {
  Unit u;
  u.say(gps(3, 300));
  u.say(gps(3, 210));
  CHECK_FALSE(u.quality.good(u.now_us + 60'000'000));
  u.say(gps(3, 199));
  CHECK_FALSE(u.quality.good(u.now_us + 999'999));
  CHECK(u.quality.good(u.now_us + 1'000'000));
  u.say(gps(3, 240));
  CHECK(u.quality.good(u.now_us + 1'000'000));
  u.say(gps(3, 260));
  CHECK_FALSE(u.good());
}

TEST_CASE("an estimate stays poor while its poor value is unknown, and only then") {
  const auto recovers = [](const link::Message& poor, const link::Message& next) {
    Unit unit;
    unit.say(poor);
    CHECK_FALSE(unit.good());
    for (int i = 0; i < 20; ++i) unit.say(next);
    return unit.good();
  };
  constexpr std::uint16_t kNoHdop = 65535;
  CHECK_FALSE(recovers(gps(3, 900), gps(3, kNoHdop)));
  CHECK(recovers(gps(0, kNoHdop), gps(3, kNoHdop)));
  CHECK_FALSE(recovers(estimator(50), estimator(kUnknown)));
  CHECK(recovers(estimator(kUnknown, 0.1F, 0), estimator(kUnknown)));
  CHECK_FALSE(recovers(ekf(5), ekf(kUnknown)));
  CHECK_FALSE(recovers(odometry(900, 900), odometry(kUnknown, kUnknown)));
  CHECK(recovers(estimator(1, 5), estimator(1)));  // its third ratio is never known
  Unit unit;
  unit.say(estimator(kUnknown, 0.1F, 0));
  unit.say(odometry(900, 900));
  for (int i = 0; i < 20; ++i) unit.say(estimator(kUnknown)), unit.say(odometry(0.1F, 0.1F));
  CHECK(unit.good());
}

TEST_CASE("an estimate stays poor in silence, and when another kind of message reports good") {
  Unit u;
  u.say(gps(1, 100));
  u.say(ekf(0.1F));
  CHECK_FALSE(u.quality.good(u.now_us + 600'000'000));
}

TEST_CASE("a new unit is judged only by its own messages") {
  Unit u;
  u.say(gps(1, 100));
  u.say(link::Attitude{}, 3);
  CHECK(u.good());
  CHECK_FALSE(u.quality.told());
}

}  // namespace
}  // namespace flotilla::app
