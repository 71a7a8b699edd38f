// SPDX-License-Identifier: MIT
// The proof behind core/scalar/fixed.hpp: errors against the C library's double, which is within
// 2⁻²¹ LSB.
//
//   sin cos atan tanh exp sqrt   all 2³² arguments. For an odd or even function the oracle checks
//                                the upper half, and each lower result is compared with its mirror
//                                image; where only an end of the range can result, that is compared
//   atan2 hypot divide           all pairs of a dense grid, and 10⁹ random pairs
//   hypot3 scaled Sum            all triples of a dense grid, and 10⁹ random ones
//   Carry                        the totals of 10⁶ random sequences, after each of 10³ products
//
// Prints each largest error and its place; exits with 1 if a bound is reached or a mirror image
// differs.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include "core/fixed_errors.hpp"
#include "core/scalar/carry.hpp"

namespace {

using namespace flotilla::testing;
using flotilla::core::Carry;
using flotilla::core::Q16;

enum class Mirror : std::uint8_t { kOdd, kEven, kNone };

struct Function {
  const char* name;
  Q16 (*ours)(Q16);
  double (*exact)(double);
  Mirror mirror = Mirror::kNone;
  double bound = 1;
  /// Arguments beyond these, in LSB, give the same results as these.
  std::int64_t from = kMin, to = kMax;
};

constexpr std::array<Function, 6> kFunctions{{
    {"sin", flotilla::core::sin, std::sin, Mirror::kOdd},
    {"cos", flotilla::core::cos, std::cos, Mirror::kEven},
    {"atan", flotilla::core::atan, std::atan, Mirror::kOdd},
    {"tanh", flotilla::core::tanh, std::tanh, Mirror::kOdd, 1, kMin, 8 * 65536},
    {"exp", flotilla::core::exp, std::exp, Mirror::kNone, 1, -13 * 65536, 12 * 65536},
    {"sqrt", flotilla::core::sqrt, [](double x) { return std::sqrt(std::max(x, 0.0)); },
     Mirror::kNone, kRoundedOnce, 0},
}};

/// The result of `function` for `raw`, compared with the oracle.
Q16 seen(Worst& worst, const Function& function, std::int64_t raw) {
  const auto ours = [&function](std::int64_t x) {
    return function.ours(Q16::of_raw(static_cast<std::int32_t>(x)));
  };
  const Q16 result = ours(raw);
  const std::int64_t inner = std::clamp(raw, function.from, function.to);
  const double exact =
      inner == raw ? 65536 * function.exact(static_cast<double>(raw) / 65536) : ours(inner).raw();
  worst.see(result, exact, {raw});
  return result;
}

Worst over_all(const Function& function) {
  constexpr std::int64_t kChunk = std::int64_t{1} << 22;
  return over(function.name, 512, [&](int index) {
    Worst worst;
    if (index == 0) seen(worst, function, 0);
    for (std::int64_t m = index * kChunk + 1; m <= (index + 1) * kChunk; ++m) {
      const bool has_mirror = m <= kMax && function.mirror != Mirror::kNone;
      if (!has_mirror) seen(worst, function, -m);
      if (m > kMax) continue;
      const Q16 upper = seen(worst, function, m);
      if (!has_mirror) continue;
      const Q16 lower = function.ours(Q16::of_raw(static_cast<std::int32_t>(-m)));
      ++worst.checked;
      if (lower != (function.mirror == Mirror::kOdd ? -upper : upper)) ++worst.broken_mirrors;
    }
    return worst;
  });
}

/// Half of the pairs have any magnitude, because uniform numbers are nearly all large.
struct Random {
  explicit Random(int seed) : engine(static_cast<std::uint64_t>(seed)) {}

  std::array<std::int32_t, 2> pair(bool uniform) {
    const std::uint64_t both = engine(), places = uniform ? 0 : engine();
    const auto a = static_cast<std::int32_t>(both >> 32), b = static_cast<std::int32_t>(both);
    return {a >> (places & 31), b >> (places >> 5 & 31)};
  }
  std::mt19937_64 engine;
};

struct Several {
  const char* name;
  double bound;
  int arguments;
  Q16 (*ours)(Q16, Q16, Q16);
  double (*exact)(double, double, double);  ///< LSB of LSB
};

constexpr std::array<Several, 7> kSeveral{{
    {"atan2", 1, 2, [](Q16 y, Q16 x, Q16) { return atan2(y, x); },
     [](double y, double x, double) { return 65536 * std::atan2(y, x); }},
    {"hypot", kRoundedOnce, 2, [](Q16 y, Q16 x, Q16) { return hypot(y, x); },
     [](double y, double x, double) { return std::sqrt(x * x + y * y); }},
    {"divide", kRoundedOnce, 2, [](Q16 a, Q16 b, Q16) { return a / b; },
     [](double a, double b, double) { return a == 0 ? 0 : 65536 * a / b; }},
    {"hypot3", kRoundedOnce, 3, [](Q16 x, Q16 y, Q16 z) { return hypot(x, y, z); },
     [](double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }},
    {"scaled", kRoundedOnce, 3, [](Q16 a, Q16 b, Q16 c) { return scaled(a, b, c); },
     [](double a, double b, double c) { return a * b == 0 ? 0 : a * b / c; }},
    {"a + b c", kRoundedOnce, 3,
     [](Q16 a, Q16 b, Q16 c) { return sum_of_products(a, Q16(1), b, c); },
     [](double a, double b, double c) { return a + b * c / 65536; }},
    {"a b - c", kRoundedOnce, 3,
     [](Q16 a, Q16 b, Q16 c) { return difference_of_products(a, b, c, Q16(1)); },
     [](double a, double b, double c) { return a * b / 65536 - c; }},
}};

/// Each number up to `small`, then `great` more at a constant ratio up to the end; their negatives.
std::vector<std::int32_t> dense_grid(int small, int great) {
  std::vector<std::int32_t> grid;
  for (int i = 0; i <= small + great; ++i) {
    const double ratio = std::pow(static_cast<double>(kMax) / small, 1.0 * (i - small) / great);
    const double value = i <= small ? i : std::min(small * ratio, double{kMax});
    grid.push_back(static_cast<std::int32_t>(value));
    grid.push_back(-grid.back() - (i == small + great ? 1 : 0));
  }
  return grid;
}

Worst over_several(const Several& function) {
  const bool three = function.arguments == 3;
  const auto grid = three ? dense_grid(40, 100) : dense_grid(1000, 1000);
  const auto thirds = three ? grid : std::vector<std::int32_t>{0};
  const auto see = [&](Worst& worst, std::int32_t a, std::int32_t b, std::int32_t c) {
    const Q16 result = function.ours(Q16::of_raw(a), Q16::of_raw(b), Q16::of_raw(c));
    worst.see(result, function.exact(a, b, c), {a, b, c});
  };
  Worst worst = over(function.name, static_cast<int>(grid.size()), [&](int index) {
    Worst row;
    for (const std::int32_t b : grid) {
      for (const std::int32_t c : thirds) see(row, grid[static_cast<std::size_t>(index)], b, c);
    }
    return row;
  });
  worst.merge(over(function.name, 1000, [&](int index) {
    Worst chunk;
    Random random(index);
    for (int i = 0; i < 1'000'000; ++i) {
      const auto [a, b] = random.pair(i % 2 == 0);
      see(chunk, a, b, three ? random.pair(i % 4 < 2)[0] : 0);
    }
    return chunk;
  }));
  return worst;
}

/// Running sums of 1000 products, each within the range: the sum taken minus the exact sum.
Worst over_carries() {
  return over("Carry", 1000, [](int index) {
    Worst chunk;
    Random random(index);
    for (int i = 0; i < 1'000; ++i) {
      Carry<Q16> carry;
      std::int64_t exact = 0, taken = 0;  // in 2⁻³²
      for (int k = 0; k < 1'000; ++k) {
        const auto [a, whole_b] = random.pair(k % 2 == 0);
        const std::int32_t b = whole_b >> 16;
        exact += std::int64_t{a} * b;
        taken += std::int64_t{carry.take(Q16::of_raw(a), Q16::of_raw(b)).raw()} * 65536;
        chunk.see(static_cast<double>(taken - exact) / 65536, {a, b});
      }
    }
    return chunk;
  });
}

}  // namespace

int main() {
  std::printf(
      "|         |  arguments | max error, LSB | below | at, in LSB |\n|---|---|---|---|---|\n");
  bool holds = true;
  for (const Function& function : kFunctions) {
    if (!report(function.name, function.bound, over_all(function))) holds = false;
  }
  for (const Several& function : kSeveral) {
    if (!report(function.name, function.bound, over_several(function))) holds = false;
  }
  if (!report("Carry", kRoundedOnce, over_carries())) holds = false;
  return holds ? EXIT_SUCCESS : EXIT_FAILURE;
}
