// SPDX-License-Identifier: MIT
// The clearance compared with an oracle without its formulas. The oracle takes the boundary as a
// row of points, and sums the angles under which a place sees the edges to decide whether it is
// inside.
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/arbitrary.hpp"
#include "core/fence.hpp"
#include "core/scalar/overflow.hpp"

namespace flotilla::core {
namespace {

using testing::in_scalar;
using testing::number_of;
using testing::Random;
using Place = Vec2<double>;

struct Drawn {
  std::vector<Place> corners;
  double radius = 0;
  bool keeps_in = true;
};

template <class S>
std::vector<Vec2<S>> in_scalars(const std::vector<Place>& places) {
  std::vector<Vec2<S>> out;
  for (const Place& p : places) out.push_back({in_scalar<S>(p.x), in_scalar<S>(p.y)});
  return out;
}

template <class S>
double clearance_of(const Drawn& drawn, const Place& p) {
  const auto corners = in_scalars<S>(drawn.corners);
  const Zone<S> zone{corners, in_scalar<S>(drawn.radius), drawn.keeps_in};
  return number_of(clearance(zone, in_scalars<S>({p})[0]));
}

template <class S>
double clearance_of(const Drawn& drawn, const Place& a, const Place& b) {
  const auto corners = in_scalars<S>(drawn.corners);
  const Zone<S> zone{corners, in_scalar<S>(drawn.radius), drawn.keeps_in};
  const auto ends = in_scalars<S>({a, b});
  return number_of(clearance(zone, ends[0], ends[1]));
}

double between(const Place& a, const Place& b) { return std::hypot(a.x - b.x, a.y - b.y); }

std::vector<Place> row(const Place& a, const Place& b, double step) {
  std::vector<Place> out;
  const int n = std::max(1, static_cast<int>(std::ceil(between(a, b) / step)));
  for (int k = 0; k <= n; ++k)
    out.push_back({a.x + (b.x - a.x) * k / n, a.y + (b.y - a.y) * k / n});
  return out;
}

/// Points of the boundary, at most `step` apart.
std::vector<Place> boundary(const Drawn& drawn, double step) {
  std::vector<Place> out;
  const auto& c = drawn.corners;
  if (c.size() == 1) {
    const int n = static_cast<int>(2 * testing::kPi * drawn.radius / step) + 1;
    for (int k = 0; k < n; ++k) {
      const double angle = 2 * testing::kPi * k / n;
      out.push_back(
          {c[0].x + drawn.radius * std::cos(angle), c[0].y + drawn.radius * std::sin(angle)});
    }
    return out;
  }
  for (std::size_t i = 0; i < c.size(); ++i) {
    const auto edge = row(c[i], c[(i + 1) % c.size()], step);
    out.insert(out.end(), edge.begin(), edge.end());
  }
  return out;
}

bool permitted(const Drawn& drawn, const Place& p) {
  const auto& c = drawn.corners;
  bool inside = c.size() == 1 && between(p, c[0]) < drawn.radius;
  if (c.size() > 1) {
    double angle = 0;
    for (std::size_t i = 0; i < c.size(); ++i) {
      const Place &a = c[i], &b = c[(i + 1) % c.size()];
      const double ax = a.x - p.x, ay = a.y - p.y, bx = b.x - p.x, by = b.y - p.y;
      angle += std::atan2(ax * by - ay * bx, ax * bx + ay * by);
    }
    inside = std::abs(angle) > testing::kPi;
  }
  return inside == drawn.keeps_in;
}

/// A circle, or a polygon whose corners lie round a point in order: it does not cross itself.
Drawn drawn_by(Random& random, double size) {
  Drawn out;
  out.keeps_in = random(0, 1) < 0.5;
  const Place middle{random(-size, size), random(-size, size)};
  if (random(0, 1) < 0.3) {
    out.corners = {middle};
    out.radius = random(0.02, 1) * size;
    return out;
  }
  const int n = 3 + static_cast<int>(random(0, 20));
  for (int k = 0; k < n; ++k) {
    const double angle = 2 * testing::kPi * (k + random(0.05, 0.95)) / n;
    const double far = random(0.1, 1) * size;
    out.corners.push_back({middle.x + far * std::cos(angle), middle.y + far * std::sin(angle)});
  }
  if (random(0, 1) < 0.5) std::ranges::reverse(out.corners);
  return out;
}

TEST_CASE_TEMPLATE(
    "the clearance of a place is its distance to the boundary, positive if permitted", S, float,
    double, Q16) {
  constexpr std::uint32_t kSeed = 11;
  INFO("seed ", kSeed);
  Random random(kSeed);
  take_overflow<S>();
  for (int i = 0; i < 300; ++i) {
    const double size = random(0, 1) < 0.5 ? 30 : 2000;
    const Drawn drawn = drawn_by(random, size);
    const double step = size / 500;
    const auto points = boundary(drawn, step);
    for (int k = 0; k < 20; ++k) {
      const Place p{random(-2 * size, 2 * size), random(-2 * size, 2 * size)};
      double nearest = 1e9;
      for (const Place& b : points) nearest = std::min(nearest, between(p, b));
      const double c = clearance_of<S>(drawn, p);
      const double fine = 0.5 * step + 1e-4 * size;
      CHECK(std::abs(c) <= nearest + 1e-4 * size);
      CHECK(std::abs(c) >= nearest - fine);
      if (nearest > fine) CHECK((c > 0) == permitted(drawn, p));
    }
  }
  CHECK_FALSE(take_overflow<S>());
}

TEST_CASE_TEMPLATE("the clearance of a leg is the least of its points; a leg that crosses has none",
                   S, float, double, Q16) {
  constexpr std::uint32_t kSeed = 12;
  INFO("seed ", kSeed);
  Random random(kSeed);
  take_overflow<S>();
  int clear = 0, crossing = 0;
  for (int i = 0; i < 100; ++i) {
    const double size = random(0, 1) < 0.5 ? 30 : 2000;
    const Drawn drawn = drawn_by(random, size);
    for (int k = 0; k < 10; ++k) {
      const Place a{random(-2 * size, 2 * size), random(-2 * size, 2 * size)};
      const Place b{a.x + random(-size, size), a.y + random(-size, size)};
      const double step = size / 1000;
      double least = 1e9;
      for (const Place& p : row(a, b, step)) {
        least = std::min(least, clearance_of<double>(drawn, p));  // by the test above
      }
      const double c = clearance_of<S>(drawn, a, b);
      const double fine = step + 1e-4 * size;
      if (least > 0) {
        CHECK(c <= least + fine);
        CHECK(c >= least - fine);
        clear += c > 0 ? 1 : 0;
      } else {
        CHECK(c <= fine);
        ++crossing;
      }
    }
  }
  CHECK(clear > 200);
  CHECK(crossing > 200);
  CHECK_FALSE(take_overflow<S>());
}

TEST_CASE_TEMPLATE("between two places the clearance changes by no more than their distance", S,
                   float, double, Q16) {
  constexpr std::uint32_t kSeed = 13;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int i = 0; i < 500; ++i) {
    const Drawn drawn = drawn_by(random, 100);
    const Place a{random(-200, 200), random(-200, 200)};
    const Place b{a.x + random(-5, 5), a.y + random(-5, 5)};
    const double change = std::abs(clearance_of<S>(drawn, a) - clearance_of<S>(drawn, b));
    CHECK(change <= between(a, b) + 0.01);
  }
}

TEST_CASE("a leg through a thin strip, or past a corner, is detected") {
  const Drawn strip{{{0, -100}, {0, 100}, {0.2, 100}, {0.2, -100}}, 0, false};
  CHECK(clearance_of<Q16>(strip, {-50, 3}, {50, 3}) <= 0);
  CHECK(clearance_of<Q16>(strip, {-50, 3}, {-1, 3}) == doctest::Approx(1).epsilon(0.01));
  const Drawn wedge{{{0, 0}, {20, 30}, {20, -30}}, 0, false};
  CHECK(clearance_of<double>(wedge, {-2, -50}, {-2, 50}) == doctest::Approx(2));
  CHECK(clearance_of<double>(wedge, {1, -50}, {1, 50}) <= 0);
}

TEST_CASE("a leg without length is a point") {
  const Drawn pool{{{0, 0}}, 10, true};
  const Drawn square{{{0, 0}, {0, 10}, {10, 10}, {10, 0}}, 0, true};
  for (const Drawn& drawn : {pool, square}) {
    CHECK(clearance_of<float>(drawn, {3, 4}, {3, 4}) ==
          doctest::Approx(clearance_of<float>(drawn, Place{3, 4})));
  }
}

TEST_CASE("crossing edges have distance 0, others the distance of their nearest points") {
  using V = Vec2<double>;
  CHECK(distance_between(V{0, 0}, V{10, 10}, V{0, 10}, V{10, 0}) == 0);
  CHECK(distance_between(V{0, 0}, V{10, 0}, V{5, 3}, V{5, 9}) == doctest::Approx(3));
  CHECK(distance_between(V{0, 0}, V{10, 0}, V{13, 4}, V{20, 4}) == doctest::Approx(5));
}

}  // namespace
}  // namespace flotilla::core
