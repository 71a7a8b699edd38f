// SPDX-License-Identifier: MIT
// The manoeuvres of the voyage that measures a hull, in sailing order. Their log determines drag,
// inertia, propellers, current and compass.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace flotilla::app {

enum class Manoeuvre : std::uint8_t {
  kDrift,     ///< no thrust
  kAhead,     ///< a step of thrust, then without thrust
  kAstern,    ///< the same astern
  kSpin,      ///< one propeller ahead, the other astern
  kZigZag,    ///< turns to the other side when the heading is 20° off
  kStraight,  ///< turns on the spot to its course, keeps it by weak steering
  kCircle,    ///< unequal thrusts
  kRandom,    ///< exchanges the two thrusts by a pseudo-random sequence of 1 s steps
  kAlone,     ///< one propeller, the other stands still
};

inline std::string_view name_of(Manoeuvre manoeuvre) {
  constexpr std::array<std::string_view, 9> kNames{"drift",  "ahead",   "astern",
                                                   "spin",   "zig-zag", "straight",
                                                   "circle", "random",  "one propeller"};
  return kNames[static_cast<std::size_t>(manoeuvre)];
}

struct VoyageStep {
  Manoeuvre manoeuvre;
  std::int8_t port, stbd;         ///< thrusts, percent of the greatest that the voyage uses
  std::uint8_t driven_s;          ///< time with these thrusts
  std::uint8_t coasting_s;        ///< time without thrust after that
  std::uint8_t eighths_turn = 0;  ///< course of a straight
};

constexpr auto kVoyageSteps = [] {
  using enum Manoeuvre;
  // clang-format off
  return std::to_array<VoyageStep>({
      {kDrift, 0, 0, 60, 0},
      {kAhead, 33, 33, 20, 12},
      {kAhead, 67, 67, 20, 12},
      {kAhead, 100, 100, 15, 16},
      {kAstern, -33, -33, 20, 12},
      {kAstern, -67, -67, 20, 12},
      {kAstern, -100, -100, 15, 16},
      {kSpin, 50, -50, 15, 4},
      {kSpin, -50, 50, 15, 4},
      {kSpin, 100, -100, 12, 4},
      {kSpin, -100, 100, 12, 4},
      {kZigZag, 70, 10, 40, 0},
      {kZigZag, 100, 40, 40, 0},
      {kStraight, 60, 60, 13, 0, 0},
      {kStraight, 60, 60, 13, 0, 4},
      {kStraight, 60, 60, 13, 0, 1},
      {kStraight, 60, 60, 13, 0, 5},
      {kStraight, 60, 60, 13, 0, 2},
      {kStraight, 60, 60, 13, 0, 6},
      {kStraight, 60, 60, 13, 0, 3},
      {kStraight, 60, 60, 13, 0, 7},
      {kStraight, 60, 60, 13, 0, 4},
      {kStraight, 60, 60, 13, 0, 0},
      {kStraight, 60, 60, 13, 0, 5},
      {kStraight, 60, 60, 13, 0, 1},
      {kStraight, 60, 60, 13, 0, 6},
      {kStraight, 60, 60, 13, 0, 2},
      {kStraight, 60, 60, 13, 0, 7},
      {kStraight, 60, 60, 13, 0, 3},
      {kCircle, 40, 20, 32, 0},
      {kCircle, 20, 40, 32, 0},
      {kCircle, 70, 35, 32, 0},
      {kCircle, 35, 70, 32, 0},
      {kCircle, 100, 60, 32, 0},
      {kCircle, 60, 100, 32, 0},
      {kRandom, 50, 10, 63, 0},
      {kRandom, 70, 20, 63, 0},
      {kAlone, 60, 0, 15, 4},
      {kAlone, 0, 60, 15, 4},
      {kAlone, -60, 0, 15, 4},
      {kAlone, 0, -60, 15, 4},
      {kDrift, 0, 0, 60, 0},
  });
  // clang-format on
}();

}  // namespace flotilla::app
