// SPDX-License-Identifier: MIT
// Saturating sums of 32-bit integers, and whether one has saturated. A Cortex-M4 has instructions
// for such sums, which set its flag Q. They take half as much code as a check for overflow, and the
// law has some 600 sums.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

namespace flotilla::core {

/// Whether a result of this thread has saturated since the flag was last cleared. A microcontroller
/// has only one thread.
#ifdef __linux__
inline thread_local bool q16_overflow = false;
#else
inline bool q16_overflow = false;
#endif

namespace fixed {

#if defined(__ARM_FEATURE_DSP) && !defined(__linux__)  // on Linux a library might set the flag too
constexpr bool kSaturates = true;
#else
constexpr bool kSaturates = false;
#endif

/// The lower or upper end of the range; sets q16_overflow. A call is shorter than inline code.
[[gnu::cold, gnu::noinline]] inline std::int32_t end(bool negative) {
  q16_overflow = true;
  return negative ? std::numeric_limits<std::int32_t>::min()
                  : std::numeric_limits<std::int32_t>::max();
}

/// Whether the compiler knows both numbers, and computes their sum itself.
[[gnu::always_inline]] constexpr bool are_known(std::int32_t a, std::int32_t b) {
  return std::is_constant_evaluated() || (__builtin_constant_p(a) && __builtin_constant_p(b));
}

[[gnu::always_inline]] constexpr std::int32_t sum(std::int32_t a, std::int32_t b) {
  std::int32_t out = 0;
  if constexpr (kSaturates) {
    if (!are_known(a, b)) {
      asm volatile("qadd %0, %1, %2" : "=r"(out) : "r"(a), "r"(b));
      return out;
    }
  }
  return __builtin_add_overflow(a, b, &out) ? end(a < 0) : out;
}

[[gnu::always_inline]] constexpr std::int32_t difference(std::int32_t a, std::int32_t b) {
  std::int32_t out = 0;
  if constexpr (kSaturates) {
    if (!are_known(a, b)) {
      asm volatile("qsub %0, %1, %2" : "=r"(out) : "r"(a), "r"(b));
      return out;
    }
  }
  return __builtin_sub_overflow(a, b, &out) ? end(a < 0) : out;
}

/// Whether the processor has saturated a sum since the last call. Nothing else may set its flag.
/// tests/cortex_m checks the image for such instructions, except the smlabb of a few sums of
/// indices, which set it only beyond 32 bits.
inline bool take_saturation() {
  std::uint32_t flags = 0;
  if constexpr (kSaturates) {
    asm volatile("mrs %0, apsr\n\tmsr apsr_nzcvq, %1" : "=&r"(flags) : "r"(0) : "cc");
  }
  return (flags >> 27 & 1) != 0;
}

}  // namespace fixed
}  // namespace flotilla::core
