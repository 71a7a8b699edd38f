// SPDX-License-Identifier: MIT
#include "core/arbitrary.hpp"
#include "core/scalar/fixed.hpp"
#include "core/scalar/scalar.hpp"

namespace flotilla::core {
namespace {

using testing::kPi;
using testing::Random;

TEST_CASE_TEMPLATE("a wrapped heading differs by whole turns and is at most half a turn", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 1;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 5000; ++i) {
    const S angle = S(random(-100, 100));
    const S wrapped = wrap_pi(angle);
    const double tolerance = 300 * double(std::numeric_limits<S>::epsilon());
    CAPTURE(angle);
    CHECK(std::abs(double(wrapped)) <= kPi + tolerance);
    const double turns = (double(angle) - double(wrapped)) / (2 * kPi);
    CHECK(std::abs(turns - std::round(turns)) < tolerance);
  }
}

TEST_CASE_TEMPLATE("a heading that is wrapped already stays as it is, to the last bit", S, float,
                   double) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const S angle = S(random(-3.14159, 3.14159));
    CHECK(wrap_pi(angle) == angle);
    const S half_turn = S(kPi) * S(1 - random(0, 1e-6));
    CHECK(wrap_pi(half_turn) == half_turn);
    CHECK(wrap_pi(-half_turn) == (-half_turn == -S(kPi) ? S(kPi) : -half_turn));
  }
  CHECK(wrap_pi(S(0)) == S(0));
}

TEST_CASE_TEMPLATE("wrapping a heading twice equals wrapping it once, due astern as well", S, float,
                   double) {
  Random random(3);
  for (int i = 0; i < 5000; ++i) {
    S angle = S(random(-100, 100));
    // Differences of two headings are within two half turns.
    if (i % 2 == 0) angle = S(i % 5 - 2) * S(kPi) + S(random(-1e-6, 1e-6));
    if (i % 10 < 4) angle = S(i % 5 - 2) * S(kPi);
    const S wrapped = wrap_pi(angle);
    CAPTURE(angle);
    CHECK(wrap_pi(wrapped) == wrapped);
  }
}

TEST_CASE_TEMPLATE("due astern is +pi, whichever way the boat turned there", S, float, double) {
  const S pi = S(kPi);
  CHECK(wrap_pi(pi) == pi);
  CHECK(wrap_pi(-pi) == testing::approx(pi));
  CHECK(wrap_pi(S(3) * pi) == testing::approx(pi));
  CHECK(wrap_pi(S(-3.25) * pi) == testing::approx(S(0.75) * pi));
}

TEST_CASE_TEMPLATE("clamp and smaller return one of their arguments", S, float, double) {
  CHECK(clamp(S(-2), S(-1), S(3)) == S(-1));
  CHECK(clamp(S(4), S(-1), S(3)) == S(3));
  CHECK(clamp(S(0.5), S(-1), S(3)) == S(0.5));
  CHECK(clamp(S(9), S(1), S(1)) == S(1));
  CHECK(min(S(1), S(2)) == S(1));
  CHECK(min(S(2), S(-1)) == S(-1));
}

TEST_CASE_TEMPLATE("a ratio stays within its bounds, also where the quotient is out of range", S,
                   float, double, Q16) {
  CHECK(ratio_within(S(3), S(2), S(100)) == S(1.5));
  CHECK(ratio_within(S(-3), S(2), S(100)) == S(-1.5));
  q16_overflow = false;
  CHECK(ratio_within(S(30000), S(0.125), S(100)) == S(100));
  CHECK(ratio_within(S(-30000), S(0.125), S(100)) == S(-100));
  CHECK_FALSE(q16_overflow);
}

}  // namespace
}  // namespace flotilla::core
