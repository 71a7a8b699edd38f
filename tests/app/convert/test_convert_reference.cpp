// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "app/convert/convert_reference.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::app::convert {
namespace {

constexpr double kLsb_m = 1.0 / 1024;

link::FormationReference some_motion() {
  link::FormationReference m{};
  m.latitude = 487'000'000, m.longitude = 22'950'000;
  m.north = 5 * 1024, m.east = -7 * 1024, m.heading = 8192;
  m.nu = {512, 10, 1024}, m.nu_dot = {100, -20, 300}, m.r_ddot = 33;
  return m;
}

TEST_CASE_TEMPLATE("a root's motion survives encoding and decoding, to the last bit of each unit",
                   S, float, double, core::Q16) {
  constexpr std::uint32_t kSeed = 91;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  const auto any = [&](int most) {
    return static_cast<std::int16_t>(std::uniform_int_distribution(-most, most)(random));
  };
  core::take_overflow<S>();
  for (int k = 0; k < 2000; ++k) {
    const auto far = [&] { return std::uniform_int_distribution(-1'000'000, 1'000'000)(random); };
    link::FormationReference told = some_motion();
    told.north = far(), told.east = far(), told.heading = any(25'735);
    told.nu = {any(32'766), any(32'766), any(32'766)};
    told.nu_dot = {any(32'766), any(32'766), any(32'766)}, told.r_ddot = any(32'766);
    const auto root = root_state_of<S>(told, 0);
    REQUIRE(root);
    const auto again = reference_of(*root);
    REQUIRE(again);
    CHECK(again->north == told.north);
    CHECK(again->east == told.east);
    CHECK(again->heading == told.heading);
    CHECK(again->nu == told.nu);
    CHECK(again->nu_dot == told.nu_dot);
    CHECK(again->r_ddot == told.r_ddot);
    CHECK(again->latitude == told.latitude);
    CHECK(again->longitude == told.longitude);
  }
  CHECK_FALSE(core::take_overflow<S>());
}

TEST_CASE("units are those of the message's definition") {
  const auto root = root_state_of<double>(some_motion(), 40'000);
  REQUIRE(root);
  CHECK(number(root->position.north_m) == 5);
  CHECK(number(root->position.east_m) == -7);
  CHECK(root->position.origin.latitude == 487'000'000);
  CHECK(root->position.origin.altitude == 40'000);
  CHECK(root->motion.psi == 1);
  CHECK(root->motion.nu.u == 0.5);
  CHECK(root->motion.nu.r == 0.25);
  CHECK(root->motion.nu_dot.r == doctest::Approx(300 * kLsb_m));
  CHECK(root->motion.r_ddot == doctest::Approx(33 * kLsb_m));
}

TEST_CASE("a position is encoded to half a thousandth of a metre") {
  for (double north_m = -3; north_m < 3; north_m += 0.0037) {
    RootState<double> root{{north_m, 0, {487'000'000, 22'950'000, 0, 0}}, {}};
    const auto told = reference_of(root);
    REQUIRE(told);
    CHECK(std::abs(told->north * kLsb_m - north_m) <= 0.51 * kLsb_m);
  }
}

TEST_CASE("a reference at an impossible position is refused") {
  const auto refused = [](auto change) {
    link::FormationReference m = some_motion();
    change(m);
    return !root_state_of<double>(m, 0).has_value();
  };
  CHECK_FALSE(refused([](auto&) {}));
  CHECK(refused([](auto& m) { m.latitude = m.longitude = 0; }));
  CHECK(refused([](auto& m) { m.latitude = 899'999'999; }));
  CHECK(refused([](auto& m) { m.longitude = 1'800'000'001; }));
  CHECK(refused([](auto& m) { m.north = INT32_MIN; }));
  CHECK(refused([](auto& m) { m.east = INT32_MAX; }));
  CHECK(refused([](auto& m) { m.heading = INT16_MIN + 7; }) == false);
  CHECK(refused([](auto& m) { m.heading = INT16_MIN; }) == false);
}

TEST_CASE_TEMPLATE("a motion beyond the message's range is not sent, and nothing overflows", S,
                   float, double, core::Q16) {
  core::take_overflow<S>();
  const auto told = [](core::Nu<S> nu, core::Nu<S> nu_dot) {
    const RootState<S> root{{0, 0, {487'000'000, 22'950'000, 0, 0}}, {S(0), nu, nu_dot, S(0)}};
    return reference_of(root).has_value();
  };
  CHECK(told({S(31), S(-31), S(7)}, {S(-31), S(31), S(31)}));
  CHECK_FALSE(told({S(33), S(0), S(0)}, {}));
  CHECK_FALSE(told({S(0), S(-50), S(0)}, {}));
  CHECK_FALSE(told({S(0), S(0), S(9)}, {}));
  CHECK_FALSE(told({}, {S(0), S(0), S(200)}));
  CHECK_FALSE(core::take_overflow<S>());
}

TEST_CASE_TEMPLATE("a predicted motion is encoded to two thousandths, however it changes", S, float,
                   double, core::Q16) {
  core::Future<S> future;
  for (std::size_t k = 0; k < future.u.size(); ++k) {
    const double t = 0.5 * static_cast<double>(k);
    future.u[k] = scalar<S>(static_cast<float>(0.6 + 0.3 * std::sin(0.7 * t)));
    future.r[k] = scalar<S>(static_cast<float>(0.3 * std::cos(0.5 * t)));
  }
  const auto told = message_of(future);
  REQUIRE(told);
  const auto read = future_of<S>(*told);
  REQUIRE(read);
  for (std::size_t k = 0; k < future.u.size(); ++k) {
    CHECK(std::abs(number(read->u[k] - future.u[k])) < 0.0026);
    CHECK(std::abs(number(read->r[k] - future.r[k])) < 0.0013);
  }
}

TEST_CASE("a predicted motion of 20 m/s or 4 rad/s is refused, and nothing overflows") {
  core::take_overflow<core::Q16>();
  link::FormationFuture m{};
  m.u = 30'000;
  m.u_change.fill(127);
  CHECK_FALSE(future_of<core::Q16>(m));
  m = {};
  m.r_change.fill(-128);
  CHECK_FALSE(future_of<core::Q16>(m));
  CHECK_FALSE(core::take_overflow<core::Q16>());
}

TEST_CASE("slot offsets add up exactly, in 1/1024 m; a sum beyond 100 km is refused") {
  const WireOffset a = wire_offset_of(-3.0F, 0.5F), b = wire_offset_of(1000.0F, -1000.0F);
  CHECK(a == WireOffset{-3072, 512});
  CHECK(sum_of(a, b) == WireOffset{-3072 + 1'024'000, 512 - 1'024'000});
  CHECK(offset_of<double>(a).x == -3);
  CHECK(offset_of<double>(a).y == 0.5);
  CHECK_FALSE(sum_of({INT32_MAX, 0}, {INT32_MAX, 0}));
  CHECK_FALSE(sum_of({0, INT32_MIN}, {0, -1}));
  CHECK_FALSE(sum_of({100'000 * 1024, 0}, {1, 0}));
}

}  // namespace
}  // namespace flotilla::app::convert
