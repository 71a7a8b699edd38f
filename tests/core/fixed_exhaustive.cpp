// SPDX-License-Identifier: MIT
// The proof behind core/fixed.hpp: errors against the C library's double, which is within 2⁻²¹ LSB.
//
//   sin cos atan tanh exp sqrt   all 2³² arguments. Of an odd or even function the oracle sees the
//                                upper half, and every lower one is compared with its mirror image;
//                                where nothing but an end can come out, that is compared instead
//   atan2 hypot divide           all pairs of a dense grid, and 10⁹ random pairs
//
// Prints the largest error of each and where; exit 1 where one LSB is reached, or a mirror breaks.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "core/fixed.hpp"

namespace {

using flotilla::core::Q16;

constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min();
constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();

struct Worst {
  double lsb = 0;
  std::int64_t x = 0, y = 0;
  std::uint64_t checked = 0, broken_mirrors = 0;

  /// `exact` in LSB; the nearest end of the range is expected of what is beyond it.
  void see(Q16 result, double exact, std::int64_t at_x, std::int64_t at_y = 0) {
    const double nearest = std::clamp(exact, double{kLeast}, double{kMost});
    const double error = std::abs(result.raw() - nearest);
    ++checked;
    if (!(error <= lsb)) {
      lsb = error;
      x = at_x;
      y = at_y;
    }
  }
  void merge(const Worst& other) {
    if (other.lsb > lsb) {
      lsb = other.lsb;
      x = other.x;
      y = other.y;
    }
    checked += other.checked;
    broken_mirrors += other.broken_mirrors;
  }
};

/// All of `chunks`, on every core; one line of progress.
template <class Chunk>
Worst over(const char* name, int chunks, Chunk chunk) {
  Worst worst;
  std::mutex mutex;
  std::atomic<int> next{0};
  const auto work = [&] {
    for (int i = next++; i < chunks; i = next++) {
      const Worst found = chunk(i);
      const std::scoped_lock lock(mutex);
      worst.merge(found);
      std::fprintf(stderr, "\r%-8s %3d %%", name, 100 * (i + 1) / chunks);
    }
  };
  {
    std::vector<std::jthread> crew(std::max(1U, std::thread::hardware_concurrency()));
    for (std::jthread& hand : crew) hand = std::jthread(work);
  }
  std::fprintf(stderr, "\r");
  return worst;
}

bool report(const char* name, const Worst& worst) {
  std::printf("| %-6s | %10llu | %.4f | %lld", name, static_cast<unsigned long long>(worst.checked),
              worst.lsb, static_cast<long long>(worst.x));
  if (worst.y != 0) std::printf(", %lld", static_cast<long long>(worst.y));
  std::printf(" |%s\n", worst.broken_mirrors == 0 ? "" : " mirror images differ");
  std::fflush(stdout);
  return worst.lsb < 1 && worst.broken_mirrors == 0;
}

enum class Mirror : std::uint8_t { kOdd, kEven, kNone };

struct Function {
  const char* name;
  Q16 (*ours)(Q16);
  double (*exact)(double);
  Mirror mirror = Mirror::kNone;
  /// Arguments beyond these, in LSB, give what these give.
  std::int64_t from = kLeast, to = kMost;
};

constexpr std::array<Function, 6> kFunctions{{
    {"sin", flotilla::core::sin, std::sin, Mirror::kOdd},
    {"cos", flotilla::core::cos, std::cos, Mirror::kEven},
    {"atan", flotilla::core::atan, std::atan, Mirror::kOdd},
    {"tanh", flotilla::core::tanh, std::tanh, Mirror::kOdd, kLeast, 8 * 65536},
    {"exp", flotilla::core::exp, std::exp, Mirror::kNone, -13 * 65536, 12 * 65536},
    {"sqrt", flotilla::core::sqrt, [](double x) { return std::sqrt(std::max(x, 0.0)); },
     Mirror::kNone, 0},
}};

/// What `function` gives of `raw`, against the oracle.
Q16 seen(Worst& worst, const Function& function, std::int64_t raw) {
  const auto ours = [&function](std::int64_t x) {
    return function.ours(Q16::of_raw(static_cast<std::int32_t>(x)));
  };
  const Q16 result = ours(raw);
  const std::int64_t inner = std::clamp(raw, function.from, function.to);
  const double exact =
      inner == raw ? 65536 * function.exact(static_cast<double>(raw) / 65536) : ours(inner).raw();
  worst.see(result, exact, raw);
  return result;
}

Worst over_all(const Function& function) {
  constexpr std::int64_t kChunk = std::int64_t{1} << 22;
  return over(function.name, 512, [&](int index) {
    Worst worst;
    if (index == 0) seen(worst, function, 0);
    for (std::int64_t m = index * kChunk + 1; m <= (index + 1) * kChunk; ++m) {
      const bool has_mirror = m <= kMost && function.mirror != Mirror::kNone;
      if (!has_mirror) seen(worst, function, -m);
      if (m > kMost) continue;
      const Q16 upper = seen(worst, function, m);
      if (!has_mirror) continue;
      const Q16 lower = function.ours(Q16::of_raw(static_cast<std::int32_t>(-m)));
      ++worst.checked;
      if (lower != (function.mirror == Mirror::kOdd ? -upper : upper)) ++worst.broken_mirrors;
    }
    return worst;
  });
}

struct Pair {
  const char* name;
  Q16 (*ours)(Q16, Q16);
  double (*exact)(double, double);  ///< LSB of LSB
};

constexpr std::array<Pair, 3> kPairs{{
    {"atan2", flotilla::core::atan2, [](double y, double x) { return 65536 * std::atan2(y, x); }},
    {"hypot", flotilla::core::hypot, [](double y, double x) { return std::sqrt(x * x + y * y); }},
    {"divide", [](Q16 a, Q16 b) { return a / b; },
     [](double a, double b) { return a == 0 ? 0 : 65536 * a / b; }},
}};

/// Every one up to 1000, then 1000 more at a constant ratio up to the end, and their negatives.
std::vector<std::int32_t> dense_grid() {
  std::vector<std::int32_t> grid;
  for (int i = 0; i <= 2000; ++i) {
    const double value = i <= 1000 ? i : 1000 * std::pow(kMost / 1000.0, (i - 1000) / 1000.0);
    grid.push_back(static_cast<std::int32_t>(std::min(value, double{kMost})));
    grid.push_back(-grid.back() - (i == 2000 ? 1 : 0));
  }
  return grid;
}

Worst over_pairs(const Pair& pair) {
  const std::vector<std::int32_t> grid = dense_grid();
  const auto see = [&](Worst& worst, std::int32_t a, std::int32_t b) {
    worst.see(pair.ours(Q16::of_raw(a), Q16::of_raw(b)), pair.exact(a, b), a, b);
  };
  Worst worst = over(pair.name, static_cast<int>(grid.size()), [&](int index) {
    Worst row;
    for (const std::int32_t b : grid) see(row, grid[static_cast<std::size_t>(index)], b);
    return row;
  });
  worst.merge(over(pair.name, 1000, [&](int index) {
    Worst chunk;
    std::mt19937_64 random(static_cast<std::uint64_t>(index));
    for (int i = 0; i < 1'000'000; ++i) {
      const std::uint64_t both = random();
      const auto a = static_cast<std::int32_t>(both >> 32), b = static_cast<std::int32_t>(both);
      // Half of them of any magnitude: uniform numbers are all large.
      const std::uint64_t places = i % 2 == 0 ? 0 : random();
      see(chunk, a >> (places & 31), b >> (places >> 5 & 31));
    }
    return chunk;
  }));
  return worst;
}

}  // namespace

int main() {
  std::printf("|        |  arguments | max error, LSB | at, in LSB |\n|---|---|---|---|\n");
  bool holds = true;
  for (const Function& function : kFunctions) {
    if (!report(function.name, over_all(function))) holds = false;
  }
  for (const Pair& pair : kPairs) {
    if (!report(pair.name, over_pairs(pair))) holds = false;
  }
  return holds ? EXIT_SUCCESS : EXIT_FAILURE;
}
