// SPDX-License-Identifier: MIT
// The common part of fixed_exhaustive.cpp: finds each function's largest error on all cores, and
// prints a table.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include "core/scalar/fixed.hpp"

namespace flotilla::testing {

constexpr std::int64_t kMin = std::numeric_limits<std::int32_t>::min();
constexpr std::int64_t kMax = std::numeric_limits<std::int32_t>::max();

/// Greatest error of a result that is rounded once, in LSB, including the oracle's own rounding.
constexpr double kRoundedOnce = 0.50001;

struct Worst {
  double lsb = 0;
  std::array<std::int64_t, 3> at{};
  std::uint64_t checked = 0, broken_mirrors = 0;

  void see(double error_lsb, const std::array<std::int64_t, 3>& where) {
    ++checked;
    if (std::abs(error_lsb) <= lsb) return;
    lsb = std::abs(error_lsb);  // or NaN, which stays
    at = where;
  }
  /// `exact` in LSB; beyond the range, the nearest end of the range is expected.
  void see(core::Q16 result, double exact, const std::array<std::int64_t, 3>& where) {
    see(result.raw() - std::clamp(exact, double{kMin}, double{kMax}), where);
  }
  void merge(const Worst& other) {
    if (!(other.lsb <= lsb)) {
      lsb = other.lsb;
      at = other.at;
    }
    checked += other.checked;
    broken_mirrors += other.broken_mirrors;
  }
};

/// Runs all chunks on all cores; shows one line of progress.
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

/// Prints a line of the table; returns whether the error is below `bound`, in LSB.
inline bool report(const char* name, double bound, const Worst& worst) {
  std::printf("| %-7s | %10llu | %.5f | %g | %lld, %lld, %lld |%s\n", name,
              static_cast<unsigned long long>(worst.checked), worst.lsb, bound,
              static_cast<long long>(worst.at[0]), static_cast<long long>(worst.at[1]),
              static_cast<long long>(worst.at[2]),
              worst.broken_mirrors == 0 ? "" : " mirror images differ");
  std::fflush(stdout);
  return worst.lsb < bound && worst.broken_mirrors == 0;
}

}  // namespace flotilla::testing
