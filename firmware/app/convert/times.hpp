// SPDX-License-Identifier: MIT
// Rates in Hz and times in seconds as microseconds.
#pragma once

#include <cstdint>

namespace flotilla::app::convert {

/// µs, at most one hour; 0 for a rate of 0.
inline std::int64_t period_us(float rate_Hz) {
  if (!(rate_Hz > 0.0F)) return 0;
  const double us = 1e6 / double{rate_Hz} + 0.5;
  return static_cast<std::int64_t>(us < 3.6e9 ? us : 3.6e9);
}

/// Whole microseconds of a time of at most 2²³ s, rounded towards zero; the product is exact.
inline std::int64_t microseconds(float s) { return static_cast<std::int64_t>(1e6 * double{s}); }

}  // namespace flotilla::app::convert
