// SPDX-License-Identifier: MIT
// Conversion between the scalars of wire and parameters and the law's scalar.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>

#include "app/convert/metres.hpp"
#include "core/scalar/fixed.hpp"

namespace flotilla::app::convert {

/// The nearest Q16, ties to even, by integer arithmetic. Saturates; NaN gives 0; both set
/// q16_overflow.
inline core::Q16 q16_of(double x) {
  constexpr int kFraction = 52, kBias = 1023, kMax = 0x7FF;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const int exponent = static_cast<int>(bits >> kFraction & kMax);
  const std::uint64_t fraction = bits & ((std::uint64_t{1} << kFraction) - 1);
  if (exponent == kMax && fraction != 0) {
    core::q16_overflow = true;
    return {};
  }
  const int right = kBias + kFraction - 16 - exponent;  // right of the binary point, in LSB
  if (right > kFraction + 1) return {};                 // under half an LSB
  constexpr std::int64_t kBeyond = std::numeric_limits<std::int64_t>::max();
  const std::uint64_t whole = fraction | std::uint64_t{1} << kFraction;
  const int dropped = right > 31 ? right - 31 : 0;
  const bool rest = whole << (63 - dropped) << 1 != 0;
  const auto kept = static_cast<std::int64_t>(whole >> dropped | (rest ? 1U : 0U));
  const std::int64_t raw = right > 0 ? core::Q16::halved(kept, right - dropped) : kBeyond;
  return core::Q16::of_raw(core::Q16::saturated(bits >> 63U != 0 ? -raw : raw));
}

/// The same for a float: 32-bit arithmetic suffices within the range.
inline core::Q16 q16_of(float x) {
  constexpr int kFraction = 23, kBias = 127, kMax = 0xFF;
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const int exponent = static_cast<int>(bits >> kFraction & kMax);
  const int right = kBias + kFraction - 16 - exponent;  // right of the binary point, in LSB
  if (right > kFraction + 1) return {};                 // under half an LSB
  if (exponent >= kBias + 15) return q16_of(double{x});
  const auto kept = static_cast<std::int32_t>((bits & ((1U << kFraction) - 1)) | 1U << kFraction);
  std::int32_t raw = 0;
  if (right > 0) {
    const std::int32_t half = std::int32_t{1} << (right - 1);
    raw = (kept + half - 1 + (kept >> right & 1)) >> right;
  } else {
    raw = kept << -right;
  }
  return core::Q16::of_raw(bits >> 31U != 0 ? -raw : raw);
}

/// A number in the law's scalar, correctly rounded.
template <class S, std::floating_point T>
S scalar(T x) {
  if constexpr (std::same_as<S, core::Q16>) {
    return q16_of(x);
  } else {
    return static_cast<S>(x);
  }
}

/// The same for a coordinate, or the difference of two.
template <class S>
S scalar(Metres x) {
  if constexpr (std::same_as<S, core::Q16>) {
    return core::Q16::of_raw(core::Q16::saturated(core::Q16::halved(x.raw(), 16)));
  } else {
    return static_cast<S>(x.raw()) / S(4294967296);
  }
}
/// The same; Q16, which would overflow, is limited to ±15 km: farther is out of reach in any case.
template <class S>
S limited(Metres x) {
  if constexpr (std::same_as<S, core::Q16>) x = std::clamp(x, Metres(-15'000), Metres(15'000));
  return scalar<S>(x);
}
inline double number(Metres x) { return scalar<double>(x); }

/// The law's number as a double, exactly.
template <std::floating_point S>
double number(S x) {
  return double{x};
}
/// Not inlined: the compiler counts the library's conversion as one instruction, and would copy it.
[[gnu::noinline]] inline double number(core::Q16 x) {
  constexpr std::uint64_t kHalvings = std::uint64_t{16} << 52U;  // subtracts 16 from the exponent
  const double raw = x.raw();
  return x.raw() == 0 ? 0 : std::bit_cast<double>(std::bit_cast<std::uint64_t>(raw) - kHalvings);
}

/// The law's number in fixed point, to the nearest.
template <class S>
core::Q16 q16(S x) {
  if constexpr (std::same_as<S, core::Q16>) {
    return x;
  } else {
    return q16_of(x);
  }
}

/// The integer part, truncated towards zero.
template <std::floating_point S>
int whole(S x) {
  return static_cast<int>(x);
}
inline int whole(core::Q16 x) { return x.raw() / 65536; }

/// A number of the law in float, for estimators that keep float in every law.
template <std::floating_point S>
float in_float(S x) {
  return static_cast<float>(x);
}
inline float in_float(core::Q16 x) { return static_cast<float>(x.raw()) * (1.0F / 65536); }

/// Time, s. Q16 saturates at ±32,767 s (nine hours): older than any limit.
template <class S>
S seconds(std::int64_t us) {
  return scalar<S>(static_cast<double>(us) * 1e-6);
}
template <>
inline core::Q16 seconds(std::int64_t us) {
  constexpr std::int64_t kShort_us = 65'000;  // short enough for a 32-bit division
  if (0 <= us && us <= kShort_us) {
    const auto short_us = static_cast<std::uint32_t>(us);
    return core::Q16::of_raw(
        static_cast<std::int32_t>((short_us * 65536U + 500'000U) / 1'000'000U));
  }
  constexpr std::int64_t kMax_us = 32'767'000'000;
  const std::int64_t near = us < -kMax_us ? -kMax_us : us > kMax_us ? kMax_us : us;
  const std::int64_t half = near < 0 ? -500'000 : 500'000;
  return core::Q16::of_raw(static_cast<std::int32_t>((near * 65536 + half) / 1'000'000));
}

}  // namespace flotilla::app::convert
