// SPDX-License-Identifier: MIT
// IEEE 754 binary16, the float of DroneCAN's telemetry.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace flotilla::link {

/// Rounds to nearest even; saturates at ±65504, infinity too ("saturated float16"). NaN stays NaN.
inline std::uint16_t float16_from(float x) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(x);
  const auto sign = static_cast<std::uint16_t>((bits >> 16U) & 0x8000U);
  const auto signed_ = [sign](std::uint32_t h) { return static_cast<std::uint16_t>(sign | h); };
  if (std::isnan(x)) return signed_(0x7FFF);
  const float magnitude = std::bit_cast<float>(bits & 0x7FFFFFFFU);
  if (magnitude >= 65504.0F) return signed_(0x7BFF);
  if (magnitude < 6.103515625e-5F) {   // subnormal: multiples of 2⁻²⁴
    constexpr float kWhole = 8388608;  // adding 2²³ rounds to whole numbers
    return signed_(std::bit_cast<std::uint32_t>(magnitude * 16777216.0F + kWhole) -
                   std::bit_cast<std::uint32_t>(kWhole));
  }
  const std::uint32_t m = std::bit_cast<std::uint32_t>(magnitude) - (112U << 23U);
  const std::uint32_t odd = (m >> 13U) & 1U;
  return signed_((m + 0xFFFU + odd) >> 13U);
}

inline float float_from_float16(std::uint16_t h) {
  const std::uint32_t sign = (h & 0x8000U) << 16U;
  const std::uint32_t exponent = (h >> 10U) & 0x1FU;
  const std::uint32_t fraction = h & 0x3FFU;
  if (exponent == 0) {
    const float magnitude = static_cast<float>(fraction) / 16777216.0F;
    return sign != 0 ? -magnitude : magnitude;
  }
  const std::uint32_t widened = exponent == 31 ? 255U : exponent + 112U;
  return std::bit_cast<float>(sign | widened << 23U | fraction << 13U);
}

}  // namespace flotilla::link
