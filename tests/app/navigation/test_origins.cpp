// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>

#include "app/navigation/origins.hpp"

namespace flotilla::app {
namespace {

using Sample = convert::Sample<double>;
const link::GpsGlobalOrigin kOrigin{487'000'000, 22'950'000, 0, 0};

Sample local() { return {0, 1, 2, 0, 0, 0, 0}; }
Sample global(double east_m) {
  Sample out{};
  out.at = convert::global_of({0, east_m, kOrigin});
  return out;
}

TEST_CASE("local positions count once their own component has reported its origin") {
  Origins origins;
  CHECK_FALSE(origins.located());
  CHECK_FALSE(origins.place_of(local(), 1));
  origins.take(kOrigin, 1, true, 10);
  CHECK(origins.is_told_by(1));
  CHECK_FALSE(origins.is_told_by(2));
  CHECK_FALSE(origins.located());  // until a position is accepted
  CHECK(origins.place_of(local(), 1)->origin.longitude == kOrigin.longitude);
  CHECK_FALSE(origins.place_of(local(), 2));
  origins.anchor(local(), 1);
  CHECK(origins.located());
  CHECK(origins.position().origin.longitude == kOrigin.longitude);
  CHECK(origins.in_plane(local()).east_m == local().east_m);
}

TEST_CASE("the first origin applies to the positions received before it") {
  Origins origins;
  origins.take(kOrigin, 1, true, 10);
  origins.locate();
  CHECK(origins.located());
  CHECK(origins.position().origin.longitude == kOrigin.longitude);
}

TEST_CASE("an origin received after the last state before a reboot is kept") {
  for (const std::int64_t last_us : {9, 10}) {
    Origins origins;
    origins.take(kOrigin, 1, true, 10);
    origins.forget(last_us);
    CHECK(origins.is_told_by(1) == (last_us == 9));
  }
}

TEST_CASE("another component's origin waits until that one is in use") {
  link::GpsGlobalOrigin other = kOrigin;
  other.latitude += 9;
  Origins origins;
  origins.take(kOrigin, 2, true, 10);
  origins.take(other, 1, false, 20);
  CHECK(origins.place_of(local(), 2)->origin.latitude == kOrigin.latitude);
  CHECK(origins.place_of(local(), 1)->origin.latitude == other.latitude);
  origins.change_to(1);
  origins.anchor(local(), 1);
  CHECK(origins.located());
  CHECK(origins.position().origin.latitude == other.latitude);
}

TEST_CASE(
    "a new origin moves local positions if another was known before; it moves no global ones") {
  link::GpsGlobalOrigin other = kOrigin;
  other.latitude += 1;
  Origins origins;
  CHECK_FALSE(origins.moves_to(kOrigin));
  origins.take(kOrigin, 1, true, 10);
  CHECK_FALSE(origins.moves_to(kOrigin));
  CHECK(origins.moves_to(other));
  origins.anchor(global(0), 1);
  CHECK_FALSE(origins.moves_to(other));
}

TEST_CASE("global positions get an origin of their own; a reported origin does not replace it") {
  Origins origins;
  CHECK_FALSE(origins.is_of_kind(global(40)));
  origins.anchor(global(40), 1);
  CHECK(origins.is_of_kind(global(40)));
  CHECK(origins.located());
  const auto first = origins.position().origin;
  CHECK(std::abs(convert::number(origins.in_plane(global(40)).east_m)) < 1e-6);
  CHECK(convert::number(origins.in_plane(global(2540)).east_m) == doctest::Approx(2500));
  origins.take(kOrigin, 1, true, 10);
  CHECK(origins.position().origin.longitude == first.longitude);
  CHECK_FALSE(origins.is_of_kind(local()));
  origins.anchor(local(), 1);
  CHECK(origins.position().origin.longitude == kOrigin.longitude);
}

TEST_CASE("global positions use their component's origin if it is near") {
  for (const double east_m : {40.0, 200e3}) {
    Origins origins;
    origins.take(kOrigin, 1, true, 10);
    origins.anchor(global(east_m), 1);
    const bool near = origins.position().origin.longitude == kOrigin.longitude;
    CHECK(near == (east_m < 100e3));
    origins.anchor(global(east_m), 2);
    CHECK(origins.position().origin.longitude != kOrigin.longitude);
  }
}

TEST_CASE("a position too far from the anchor is detected, and gets a new anchor") {
  Origins origins;
  origins.anchor(global(0), 1);
  CHECK_FALSE(origins.is_far(global(90e3)));
  CHECK(origins.is_far(global(200e3)));
  CHECK_FALSE(origins.is_far(local()));
  origins.anchor(global(200e3), 1);
  CHECK_FALSE(origins.is_far(global(200e3)));
  origins.change_to(2);
  CHECK_FALSE(origins.is_far(global(0)));
  CHECK_FALSE(origins.is_of_kind(global(0)));
}

}  // namespace
}  // namespace flotilla::app
