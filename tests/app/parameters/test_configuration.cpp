// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "app/convert/times.hpp"
#include "app/parameters/configuration.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("a time is truncated to whole microseconds, for any float from 0 to 97 days") {
  constexpr std::uint32_t kSeed = 61;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int i = 0; i < 100'000; ++i) {
    const auto mantissa = static_cast<std::int64_t>(random() % (1U << 24U));
    const int exponent = static_cast<int>(random() % 64) - 64;  // of the last bit: 2⁻⁶⁴ … 2⁻¹
    const float s = std::ldexp(static_cast<float>(mantissa), exponent);
    // mantissa · 10⁶ < 2⁴⁴: an integer, whose bits below the point are dropped.
    REQUIRE(convert::microseconds(s) == (exponent < -63 ? 0 : mantissa * 1'000'000 >> -exponent));
  }
  CHECK(convert::microseconds(0.5F) == 500'000);
}

TEST_CASE("every id that a parameter may hold is read unchanged") {
  for (int id = 1; id <= 255; ++id) {
    Parameters p;
    p.MAV_SYSID = p.MAV_COMPID = p.FORM_LEADER = p.CAN_NODE = static_cast<float>(id);
    const Configuration c = configuration_of(p);
    CHECK(c.start.system == id);
    CHECK(c.start.component == id);
    CHECK(c.start.can_node == id);
    CHECK(c.formation.leader == id);
  }
  const Configuration defaults = configuration_of({});
  CHECK((defaults.propulsion.port_esc == 0 && defaults.propulsion.stbd_esc == 1));
  CHECK_FALSE((defaults.propulsion.port_reversed || defaults.propulsion.stbd_reversed));
  CHECK(configuration_of({.THR_PORT_DIR = -1}).propulsion.port_reversed);
  CHECK(configuration_of({.THR_STBD_DIR = -1}).propulsion.stbd_reversed);
}

TEST_CASE("a parameter of 0 switches its limit off, any other sets it") {
  const Configuration off = configuration_of({});
  CHECK_FALSE(off.operators.commander);
  CHECK_FALSE(off.operators.gcs_limit_us);
  CHECK_FALSE(off.failsafes.battery_V);
  CHECK_FALSE(off.failsafes.fence_m);
  CHECK_FALSE(off.formation.max_depth);
  CHECK(off.formation.judges_station);
  const Configuration on = configuration_of({.MAV_GCS_SYSID = 255,
                                             .FORM_DEPTH = 23,
                                             .FS_SLOT_M = 0,
                                             .FS_GCS_S = 2.5F,
                                             .FS_BATT_V = 0.1F,
                                             .FS_FENCE_M = 0.01F});
  CHECK(on.operators.commander == 255);
  CHECK(on.operators.gcs_limit_us == 2'500'000);
  CHECK(on.failsafes.battery_V == 0.1F);
  CHECK(on.failsafes.fence_m == 0.01F);
  CHECK(on.formation.max_depth == 23U);
  CHECK_FALSE(on.formation.judges_station);
}

TEST_CASE("times and rates are those of the parameters' list") {
  const Configuration c = configuration_of({});
  CHECK(c.start.tick_us == 10'000);
  CHECK(c.navigation.own_limit_us == 500'000);
  CHECK(c.navigation.leader_limit_us == 1'000'000);
  CHECK(c.propulsion.esc_limit_us == 1'200'000);
  CHECK(c.failsafes.coast_us == 5'000'000);
  CHECK(c.operators.state_us == 100'000);
  CHECK(c.operators.slow_us == 1'000'000);
  CHECK(c.failsafes.choices.leader == core::Reaction::kCoast);
  CHECK(c.failsafes.choices.gcs == core::Reaction::kHold);
}

}  // namespace
}  // namespace flotilla::app
