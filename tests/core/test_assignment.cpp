// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/arbitrary.hpp"
#include "core/assignment.hpp"

namespace flotilla::core {
namespace {

using testing::number_of;
using testing::Random;

/// The least largest time over all permutations, one by one.
template <class S>
double by_trying_all(const ArrivalTable<S>& T, std::size_t n) {
  std::vector<std::size_t> slots(n);
  std::iota(slots.begin(), slots.end(), 0U);
  double best = 1e9;
  do {
    double last = 0;
    for (std::size_t boat = 0; boat < n; ++boat) {
      last = std::max(last, number_of(T[boat][slots[boat]]));
    }
    best = std::min(best, last);
  } while (std::next_permutation(slots.begin(), slots.end()));
  return best;
}

TEST_CASE_TEMPLATE("no other assignment brings the last boat to its slot earlier", S, float, double,
                   Q16) {
  constexpr std::uint32_t kSeed = 91;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 400; ++run) {
    const auto n = static_cast<std::size_t>(1 + run % 7);
    ArrivalTable<S> T{};
    for (std::size_t boat = 0; boat < n; ++boat) {
      // Equal times are common: whole numbers.
      for (std::size_t slot = 0; slot < n; ++slot)
        T[boat][slot] = S(static_cast<int>(random(0, 12)));
    }
    const Assigned<S> found = assign(T, n);
    CHECK(number_of(found.last) == by_trying_all(T, n));
    std::vector<bool> taken(n, false);
    for (std::size_t boat = 0; boat < n; ++boat) {
      const std::size_t slot = found.slots[boat];
      REQUIRE(slot < n);
      CHECK_FALSE(taken[slot]);
      taken[slot] = true;
      CHECK(!(found.last < T[boat][slot]));
    }
  }
}

TEST_CASE("as many boats as there is room for get a slot each") {
  Random random(92);
  ArrivalTable<double> T{};
  for (auto& row : T) {
    for (double& t : row) t = random(0, 100);
  }
  const auto found = assign(T, kMostSlots);
  std::vector<std::uint8_t> slots(found.slots.begin(), found.slots.end());
  std::sort(slots.begin(), slots.end());
  for (std::size_t i = 0; i < kMostSlots; ++i) CHECK(slots[i] == i);
  CHECK(assign(T, 0).last == 0);
}

TEST_CASE_TEMPLATE("a boat that turns and sails straight meets its slot at that time", S, float,
                   double, Q16) {
  constexpr std::uint32_t kSeed = 93;
  INFO("seed ", kSeed);
  Random random(kSeed);
  for (int run = 0; run < 500; ++run) {
    const double U = 1.5, r_m = 0.8, psi = random.angle(), way = random.angle();
    const double w = random(0, 1.2), x = random(-100, 100), y = random(-100, 100);
    const double wx = w * std::cos(way), wy = w * std::sin(way);
    // Found step by step: the first time at which the boat can have reached the slot's place.
    double t = 0;
    while (std::hypot(x + wx * t, y + wy * t) > U * t) t += 1e-3;
    const double course = std::atan2(y + wy * t, x + wx * t);
    const double turn = std::abs(std::remainder(course - psi, 2 * testing::kPi)) / r_m;
    const auto in = [](double v) { return testing::in_scalar<S>(v); };
    const S found =
        arrival_time(Approach<S>{{in(x), in(y)}, {in(wx), in(wy)}, in(psi), in(U), in(r_m)});
    CHECK(number_of(found) == doctest::Approx(t + turn).epsilon(0.01).scale(1));
  }
  CHECK(arrival_time(Approach<S>{{}, {S(1), S(0)}, S(0), S(1.5), S(0.8)}) == S(0));
}

}  // namespace
}  // namespace flotilla::core
