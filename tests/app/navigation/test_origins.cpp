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

TEST_CASE("local positions are known when their own component has reported their origin") {
  Origins origins;
  CHECK_FALSE(origins.knows(1));
  origins.take(kOrigin, 1);
  CHECK(origins.knows(1));
  CHECK_FALSE(origins.knows(2));
  CHECK(origins.position().origin.longitude == kOrigin.longitude);
  CHECK(origins.in_plane(local()).east_m == local().east_m);
  origins.forget();
  CHECK_FALSE(origins.knows(1));
}

TEST_CASE("an origin moves local positions where another one was known, and no global ones") {
  link::GpsGlobalOrigin other = kOrigin;
  other.latitude += 1;
  Origins origins;
  CHECK_FALSE(origins.moves_to(kOrigin));
  origins.take(kOrigin, 1);
  CHECK_FALSE(origins.moves_to(kOrigin));
  CHECK(origins.moves_to(other));
  origins.anchor(global(0), 1);
  CHECK_FALSE(origins.moves_to(other));
}

TEST_CASE("global positions need no origin, and the one that they get stays") {
  Origins origins;
  CHECK_FALSE(origins.is_of_kind(global(40)));
  origins.anchor(global(40), 1);
  CHECK(origins.is_of_kind(global(40)));
  CHECK(origins.knows(1));
  const auto first = origins.position().origin;
  CHECK(std::abs(convert::number(origins.in_plane(global(40)).east_m)) < 1e-6);
  CHECK(convert::number(origins.in_plane(global(2540)).east_m) == doctest::Approx(2500));
  origins.take(kOrigin, 1);
  CHECK(origins.position().origin.longitude == first.longitude);
  CHECK_FALSE(origins.is_of_kind(local()));
  origins.anchor(local(), 1);
  CHECK(origins.position().origin.longitude == kOrigin.longitude);
}

TEST_CASE("global positions count from the origin of their component where that is near") {
  for (const double east_m : {40.0, 200e3}) {
    Origins origins;
    origins.take(kOrigin, 1);
    origins.anchor(global(east_m), 1);
    const bool near = origins.position().origin.longitude == kOrigin.longitude;
    CHECK(near == (east_m < 100e3));
    origins.anchor(global(east_m), 2);
    CHECK(origins.position().origin.longitude != kOrigin.longitude);
  }
}

TEST_CASE("a position too far from the anchor is told, and gets another one") {
  Origins origins;
  origins.anchor(global(0), 1);
  CHECK_FALSE(origins.is_far(global(90e3)));
  CHECK(origins.is_far(global(200e3)));
  CHECK_FALSE(origins.is_far(local()));
  origins.anchor(global(200e3), 1);
  CHECK_FALSE(origins.is_far(global(200e3)));
  origins.release();
  CHECK_FALSE(origins.is_far(global(0)));
  CHECK_FALSE(origins.knows(1));
}

}  // namespace
}  // namespace flotilla::app
