// SPDX-License-Identifier: MIT
// The arguments with which Q16's functions and the C library's float are compared, on a PC and on a
// microcontroller.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/scalar/fixed.hpp"

namespace flotilla::testing {

/// One row; functions of one number ignore the second argument. `least` … `most`: the range of the
/// arguments that are timed, evenly spread, for both arguments of a function of two numbers.
struct Rival {
  const char* name;
  int arguments;
  double least, most;
  core::Q16 (*ours)(core::Q16, core::Q16);
  float (*floating)(float, float);
};

using core::Q16;

inline constexpr std::array<Rival, 10> kRivals{{
    {"sin", 1, -3.14159, 3.14159, [](Q16 x, Q16) { return sin(x); },
     [](float x, float) { return std::sin(x); }},
    {"sin_far", 1, -32'768, 32'767, [](Q16 x, Q16) { return sin(x); },
     [](float x, float) { return std::sin(x); }},
    {"cos", 1, -3.14159, 3.14159, [](Q16 x, Q16) { return cos(x); },
     [](float x, float) { return std::cos(x); }},
    {"atan2", 2, -1000, 1000, [](Q16 y, Q16 x) { return atan2(y, x); },
     [](float y, float x) { return std::atan2(y, x); }},
    {"tanh", 1, -8, 8, [](Q16 x, Q16) { return tanh(x); },
     [](float x, float) { return std::tanh(x); }},
    {"exp", 1, -11, 10.397, [](Q16 x, Q16) { return exp(x); },
     [](float x, float) { return std::exp(x); }},
    {"sqrt", 1, 0, 32'767, [](Q16 x, Q16) { return sqrt(x); },
     [](float x, float) { return std::sqrt(x); }},
    {"hypot", 2, -1000, 1000, [](Q16 x, Q16 y) { return hypot(x, y); },
     [](float x, float y) { return std::hypot(x, y); }},
    {"multiply", 2, -180, 180, [](Q16 a, Q16 b) { return a * b; },
     [](float a, float b) { return a * b; }},
    {"divide", 2, -180, 180, [](Q16 a, Q16 b) { return a / b; },
     [](float a, float b) { return a / b; }},
}};

/// The arguments of a row that is timed.
template <std::size_t N>
struct Timed {
  explicit Timed(const Rival& rival) {
    std::uint32_t state = 1;
    const auto least = static_cast<std::int32_t>(rival.least * 65536);
    const auto width = static_cast<std::uint32_t>((rival.most - rival.least) * 65536);
    const auto next = [&] {
      state = state * 1664525U + 1013904223U;  // Numerical Recipes' generator
      return static_cast<std::int32_t>((std::uint64_t{state} * width) >> 32) + least;
    };
    for (std::size_t i = 0; i < N; ++i) {
      x[i] = Q16::of_raw(next());
      y[i] = Q16::of_raw(next());
      float_x[i] = static_cast<float>(x[i].raw()) / 65536;
      float_y[i] = static_cast<float>(y[i].raw()) / 65536;
    }
  }
  std::array<Q16, N> x, y;
  std::array<float, N> float_x, float_y;
};

}  // namespace flotilla::testing
