// SPDX-License-Identifier: MIT
#include "core/arbitrary.hpp"
#include "core/rotation.hpp"

namespace flotilla::core {
namespace {

using testing::approx;
using testing::kPi;
using testing::Random;

TEST_CASE_TEMPLATE("a boat that heads east has ahead to the east and starboard to the south", S,
                   float, double) {
  const S east = S(kPi / 2);
  const Vec2<S> ahead = to_north_east(east, Vec2<S>{S(1), S(0)});
  CHECK(ahead.x == approx(S(0)));
  CHECK(ahead.y == approx(S(1)));
  const Vec2<S> starboard = to_north_east(east, Vec2<S>{S(0), S(1)});
  CHECK(starboard.x == approx(S(-1)));
  CHECK(starboard.y == approx(S(0)));
}

TEST_CASE_TEMPLATE("rotating there and back is the identity, and distances are kept", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 3;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const S psi = S(random(-100, 100));
    const Vec2<S> b{S(random(-50, 50)), S(random(-50, 50))};
    const Vec2<S> n = to_north_east(psi, b);
    const Vec2<S> back = to_body(psi, n);
    CHECK(back.x == approx(b.x, 50));
    CHECK(back.y == approx(b.y, 50));
    CHECK(n.x * n.x + n.y * n.y == approx(b.x * b.x + b.y * b.y, 50));
  }
}

TEST_CASE_TEMPLATE("two rotations in sequence equal one by the sum of their angles", S, float,
                   double) {
  constexpr std::uint32_t kSeed = 4;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 1000; ++i) {
    const S a = S(random.angle()), b = S(random.angle());
    const Vec2<S> v{S(random(-5, 5)), S(random(-5, 5))};
    const Vec2<S> twice = to_north_east(a, to_north_east(b, v));
    const Vec2<S> once = to_north_east(a + b, v);
    CHECK(twice.x == approx(once.x, 5));
    CHECK(twice.y == approx(once.y, 5));
  }
}

}  // namespace
}  // namespace flotilla::core
