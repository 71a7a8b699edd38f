// SPDX-License-Identifier: MIT
// Compares Q16's functions with libfixmath's and the C library's float: errors, and times on this
// processor.
//
//   fixed_compared COUNT      prints a line for each function: name, arguments, largest errors of
//                             the three in LSB of Q16, median times in ns a call; nan: libfixmath
//                             does not have the function
//
// Functions of one number take COUNT arguments in equal steps through their row's range, and each
// number within 4096 LSB of 0. Functions of two take COUNT pairs within ±16384, whose sums
// libfixmath can hold; half of the pairs have any magnitude. Left out: results beyond the range,
// where each library saturates differently, and atan2(0, 0), for which libfixmath returns 0 or an
// arbitrary number that depends on earlier calls.
#include <libfixmath/fix16.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <limits>
#include <random>

#include "core/fixed_rivals.hpp"

namespace {

using flotilla::core::Q16;
using flotilla::testing::kRivals;
using flotilla::testing::Rival;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

struct Reference {
  const char* name;
  double (*exact)(double, double);
  std::int32_t (*libfixmath)(std::int32_t, std::int32_t);
};

constexpr std::array<Reference, 10> kReferences{{
    {"sin", [](double x, double) { return std::sin(x); },
     [](std::int32_t x, std::int32_t) { return fix16_sin(x); }},
    {"sin_far", [](double x, double) { return std::sin(x); },
     [](std::int32_t x, std::int32_t) { return fix16_sin(x); }},
    {"cos", [](double x, double) { return std::cos(x); },
     [](std::int32_t x, std::int32_t) { return fix16_cos(x); }},
    {"atan2", [](double y, double x) { return y == 0 && x == 0 ? kNone : std::atan2(y, x); },
     fix16_atan2},
    {"tanh", [](double x, double) { return std::tanh(x); }, nullptr},
    {"exp", [](double x, double) { return std::exp(x); },
     [](std::int32_t x, std::int32_t) { return fix16_exp(x); }},
    {"sqrt", [](double x, double) { return std::sqrt(x); },
     [](std::int32_t x, std::int32_t) { return fix16_sqrt(x); }},
    {"hypot", [](double x, double y) { return std::sqrt(x * x + y * y); }, nullptr},
    {"multiply", [](double a, double b) { return a * b; }, fix16_mul},
    {"divide", [](double a, double b) { return a / b; }, fix16_div},
}};

struct Errors {
  double ours = 0, libfixmath = kNone, floating = 0;
  std::uint64_t arguments = 0;

  void see(const Rival& rival, const Reference& reference, std::int32_t x, std::int32_t y) {
    const double exact = 65536 * reference.exact(x / 65536.0, y / 65536.0);
    // A NaN is left out, too.
    if (!(std::abs(exact) <= std::numeric_limits<std::int32_t>::max())) return;
    ++arguments;
    const Q16 result = rival.ours(Q16::of_raw(x), Q16::of_raw(y));
    ours = std::max(ours, std::abs(result.raw() - exact));
    const float near = rival.floating(static_cast<float>(x) / 65536, static_cast<float>(y) / 65536);
    floating = std::max(floating, std::abs(65536.0 * double{near} - exact));
    if (reference.libfixmath == nullptr) return;
    libfixmath = std::fmax(libfixmath, std::abs(reference.libfixmath(x, y) - exact));
  }
};

Errors errors_of(const Rival& rival, const Reference& reference, std::int64_t count) {
  Errors errors;
  if (rival.arguments == 2) {
    std::mt19937_64 random(1);
    for (std::int64_t i = 0; i < count; ++i) {
      const std::uint64_t both = random(), places = i % 2 == 0 ? 0 : random();
      const auto x = static_cast<std::int32_t>(both >> 32), y = static_cast<std::int32_t>(both);
      errors.see(rival, reference, x >> (1 + places % 31), y >> (1 + (places >> 5) % 31));
    }
    return errors;
  }
  const double least = rival.least * 65536, width = (rival.most - rival.least) * 65536;
  for (std::int64_t i = 0; i < count; ++i) {
    const double x = least + width * static_cast<double>(i) / static_cast<double>(count);
    errors.see(rival, reference, static_cast<std::int32_t>(x), 0);
  }
  for (std::int32_t x = least < 0 ? -4096 : 0; x <= 4096; ++x) errors.see(rival, reference, x, 0);
  return errors;
}

constexpr int kTimed = 1 << 14;
template <class T>
using Arguments = std::array<T, kTimed>;

volatile std::uint8_t seen;

/// ns a call, including the loop, from several thousand independent calls.
template <class T>
double time_of(T (*function)(T, T), const Arguments<T>& x, const Arguments<T>& y) {
  std::array<double, 31> ns{};
  for (double& one : ns) {
    const std::clock_t began = std::clock();  // processor time excludes other programs
    for (std::size_t i = 0; i < x.size(); ++i) {
      const T result = function(x[i], y[i]);
      seen = reinterpret_cast<const std::uint8_t&>(result);
    }
    one = 1e9 / CLOCKS_PER_SEC * static_cast<double>(std::clock() - began) / kTimed;
  }
  std::ranges::nth_element(ns, ns.begin() + ns.size() / 2);
  return ns[ns.size() / 2];
}

void compare(const Rival& rival, const Reference& reference, std::int64_t count) {
  const Errors errors = errors_of(rival, reference, count);
  const flotilla::testing::Timed<kTimed> timed(rival);
  Arguments<std::int32_t> x, y;
  std::ranges::transform(timed.x, x.begin(), &Q16::raw);
  std::ranges::transform(timed.y, y.begin(), &Q16::raw);
  const double libfixmath_ns =
      reference.libfixmath == nullptr ? kNone : time_of<std::int32_t>(reference.libfixmath, x, y);
  std::printf("%s %llu %.4f %.4f %.4f %.2f %.2f %.2f\n", rival.name,
              static_cast<unsigned long long>(errors.arguments), errors.ours, errors.libfixmath,
              errors.floating, time_of<Q16>(rival.ours, timed.x, timed.y), libfixmath_ns,
              time_of<float>(rival.floating, timed.float_x, timed.float_y));
}

}  // namespace

int main(int argc, char** argv) {
  const std::int64_t count = argc == 2 ? std::atoll(argv[1]) : 0;
  if (count <= 0) return EXIT_FAILURE;
  for (std::size_t i = 0; i < kRivals.size(); ++i) {
    if (std::strcmp(kRivals[i].name, kReferences[i].name) != 0) return EXIT_FAILURE;
    compare(kRivals[i], kReferences[i], count);
  }
  return EXIT_SUCCESS;
}
