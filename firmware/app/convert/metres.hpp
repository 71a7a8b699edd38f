// SPDX-License-Identifier: MIT
// A coordinate in a local frame as a 64-bit fixed-point number: differences are exact, and cheap on
// processors without double arithmetic.
//
//   value = raw / 2³²      one LSB = 0.23 nm      saturates at ±2³⁰ m
//
// Accepted positions lie within 10⁶ m of their origin, or 10⁷ m in another's plane, so a sum of a
// hundred of them does not wrap.
#pragma once

#include <bit>
#include <compare>
#include <cstdint>

#include "core/scalar/fixed.hpp"

namespace flotilla::app {

class Metres {
 public:
  constexpr Metres() = default;

  constexpr Metres(int whole) : raw_(std::int64_t{whole} * (std::int64_t{1} << kFraction)) {}

  /// Rounds to nearest; saturates; NaN gives the end of the range.
  constexpr Metres(double x) {
    constexpr auto kMax = static_cast<double>(kEnd);
    const double raw = x * kOne;
    if (!(-kMax < raw && raw < kMax)) {
      raw_ = end(x < 0);
      return;
    }
    raw_ = static_cast<std::int64_t>(raw);
    const double rest = raw - static_cast<double>(raw_);
    raw_ += (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0);
  }

  /// The same, by integer arithmetic.
  constexpr Metres(float x) {
    constexpr int kSignificand = 23, kBias = 127, kMax = 0xFF;
    const auto bits = std::bit_cast<std::uint32_t>(x);
    const int exponent = static_cast<int>(bits >> kSignificand & kMax);
    const std::int64_t whole = (bits & ((1U << kSignificand) - 1)) | 1U << kSignificand;
    const int left = exponent - kBias - kSignificand + kFraction;
    const bool negative = bits >> 31U != 0;
    if (left < -kSignificand - 1) return;  // under half an LSB
    if (left > 61 - kSignificand) {
      raw_ = end(negative);
      return;
    }
    const std::int64_t raw = left < 0 ? core::Q16::halved(whole, -left) : whole << left;
    raw_ = negative ? -raw : raw;
  }

  constexpr Metres(core::Q16 x) : raw_(std::int64_t{x.raw()} * 65536) {}

  static constexpr Metres of_raw(std::int64_t raw) {
    Metres x;
    x.raw_ = raw;
    return x;
  }
  constexpr std::int64_t raw() const { return raw_; }

  friend constexpr Metres operator-(Metres a) { return of_raw(-a.raw_); }
  friend constexpr Metres operator+(Metres a, Metres b) { return of_raw(a.raw_ + b.raw_); }
  friend constexpr Metres operator-(Metres a, Metres b) { return of_raw(a.raw_ - b.raw_); }
  friend constexpr bool operator==(Metres a, Metres b) = default;
  friend constexpr auto operator<=>(Metres a, Metres b) = default;

 private:
  static constexpr int kFraction = 32;
  static constexpr double kOne = 4294967296.0;

  static constexpr std::int64_t kEnd = (std::int64_t{1} << 62) - 1;

  static constexpr std::int64_t end(bool negative) { return negative ? -kEnd : kEnd; }

  std::int64_t raw_ = 0;
};

}  // namespace flotilla::app
