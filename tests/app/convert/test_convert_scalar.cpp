// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <random>

#include "app/convert/convert_scalar.hpp"
#include "app/convert/convert_telemetry.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::app::convert {
namespace {

using core::Q16;
constexpr double kLsb = 1.0 / 65536;

TEST_CASE("a number from the wire becomes the nearest Q16, ties to even, if it is in range") {
  constexpr std::uint32_t kSeed = 1616;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  core::take_overflow<Q16>();
  for (const double most : {1e-30, 1e-5, 1e-3, 1.0, 300.0, 32767.0}) {
    std::uniform_real_distribution<double> draw(-most, most);
    for (int i = 0; i < 20'000; ++i) {
      const double x = draw(random);
      REQUIRE(q16_of(x).raw() == std::lrint(x * 65536));
      REQUIRE(scalar<Q16>(static_cast<float>(x)) == q16_of(double{static_cast<float>(x)}));
    }
  }
  for (int n = -1000; n <= 1000; ++n) {  // ties and their neighbours
    const double tie = (n + 0.5) * kLsb;
    for (const double x : {tie, std::nextafter(tie, 1e9), std::nextafter(tie, -1e9), n * kLsb}) {
      REQUIRE(q16_of(x).raw() == std::lrint(x * 65536));
    }
  }
  CHECK_FALSE(core::take_overflow<Q16>());
}

TEST_CASE("a number outside Q16's range saturates and raises the overflow flag") {
  const auto most = std::numeric_limits<std::int32_t>::max();
  for (const double x : {32768.0, 40e3, 1e30, 1e300, HUGE_VAL}) {
    core::take_overflow<Q16>();
    CHECK(q16_of(x).raw() == most);
    CHECK(core::take_overflow<Q16>());
    CHECK(q16_of(-x - kLsb).raw() == -most - 1);
    CHECK(core::take_overflow<Q16>());
  }
  CHECK(q16_of(std::nan("")) == Q16(0));
  CHECK(core::take_overflow<Q16>());
  CHECK(q16_of(32768 - kLsb).raw() == most);
  CHECK(q16_of(-32768.0).raw() == -most - 1);
  CHECK_FALSE(core::take_overflow<Q16>());
}

TEST_CASE("numbers are converted unchanged; whole numbers are truncated towards zero") {
  for (const double x : {-32768.0, -2.75, -kLsb, 0.0, kLsb, 0.5, 32768 - kLsb}) {
    CHECK(number(q16_of(x)) == x);
    CHECK(whole(q16_of(x)) == static_cast<int>(x));
    CHECK(whole(x) == static_cast<int>(x));
  }
}

TEST_CASE("times are rounded to 15 us; in Q16 they saturate at nine hours without overflow") {
  CHECK(number(seconds<Q16>(10'000)) == doctest::Approx(0.01).epsilon(0.001));
  CHECK(number(seconds<Q16>(-10'000)) == -number(seconds<Q16>(10'000)));
  CHECK(seconds<float>(2'500'000) == 2.5F);
  core::take_overflow<Q16>();
  CHECK(number(seconds<Q16>(INT64_MAX)) == doctest::Approx(32767));
  CHECK(number(seconds<Q16>(INT64_MIN)) == doctest::Approx(-32767));
  CHECK_FALSE(core::take_overflow<Q16>());
}

/// Numbers that float, Q16 and double all have.
class Exact {
 public:
  explicit Exact(std::uint32_t seed) : random_(seed) {}
  float operator()(int most) {
    const std::int32_t raw = most * 65536;
    return static_cast<float>(std::uniform_int_distribution<std::int32_t>(-raw, raw)(random_)) *
           static_cast<float>(kLsb);
  }

 private:
  std::mt19937 random_;
};

/// Checks a velocity rotated by a heading. The tolerance is one LSB, for each m/s one LSB of the
/// heading's sine and, if the heading itself was rounded, one LSB of the heading.
void check_turned(double got, double expected, double speed, bool exact_heading) {
  REQUIRE(std::abs(got - expected) <= (1 + (exact_heading ? 1 : 2) * speed) * kLsb);
}

TEST_CASE("a received message has the same values in Q16 as in double, to Q16's last bit") {
  constexpr std::uint32_t kSeed = 1617;
  INFO("seed ", kSeed);
  Exact draw(kSeed);
  for (std::uint32_t ms = 0; ms < 20'000; ++ms) {
    const link::Attitude attitude{ms, 0, 0, draw(3), 0, 0, draw(1)};
    const link::LocalPositionNed position{ms + ms % 20, draw(100), draw(100), 0,
                                          draw(3),      draw(3),   0};
    const auto heading = heading_of<double>(attitude);
    const auto fixed_heading = heading_of<Q16>(attitude);
    REQUIRE(number(fixed_heading->psi_rad) == heading->psi_rad);
    REQUIRE(number(fixed_heading->r_radps) == heading->r_radps);
    const auto sample = sample_of(position, *heading);
    const auto fixed = sample_of(position, *fixed_heading);
    REQUIRE(fixed->stamp_us == sample->stamp_us);
    REQUIRE(fixed->north_m == sample->north_m);
    REQUIRE(fixed->east_m == sample->east_m);
    REQUIRE(number(fixed->r_radps) == sample->r_radps);
    REQUIRE(std::abs(number(fixed->psi_rad) - sample->psi_rad) <= kLsb);
    const double speed = std::hypot(sample->u_mps, sample->v_mps);
    const bool at_once = sample->stamp_us == heading->stamp_us;
    check_turned(number(fixed->u_mps), sample->u_mps, speed, at_once);
    check_turned(number(fixed->v_mps), sample->v_mps, speed, at_once);
  }
}

TEST_CASE("a boat's own telemetry is the same in Q16 as in double") {
  constexpr std::uint32_t kSeed = 1618;
  INFO("seed ", kSeed);
  Exact draw(kSeed);
  for (int i = 0; i < 20'000; ++i) {
    const Position from{double{draw(1000)}, double{draw(1000)}, {}};
    const core::Motion<double> motion{
        {draw(10), draw(10)}, draw(3), {draw(3), draw(3), draw(1)}, {draw(1), draw(1), draw(1)}};
    const auto q = [](double x) { return q16_of(x); };
    const auto& [moved, psi, nu, nu_dot] = motion;
    const OwnState state = own_state_of(from, motion);
    const OwnState fixed =
        own_state_of(from, core::Motion<Q16>{{q(moved.x), q(moved.y)},
                                             q(psi),
                                             {q(nu.u), q(nu.v), q(nu.r)},
                                             {q(nu_dot.u), q(nu_dot.v), q(nu_dot.r)}});
    REQUIRE(fixed.north_m == state.north_m);
    REQUIRE(fixed.east_m == state.east_m);
    REQUIRE(fixed.psi_rad == state.psi_rad);
    REQUIRE(fixed.nu.u == state.nu.u);
    REQUIRE(fixed.nu.r == state.nu.r);
    REQUIRE(fixed.nu_dot.v == state.nu_dot.v);
    const double speed = std::hypot(nu.u, nu.v);
    check_turned(fixed.v_n.x, state.v_n.x, speed, true);
    check_turned(fixed.v_n.y, state.v_n.y, speed, true);
  }
}

}  // namespace
}  // namespace flotilla::app::convert
