// SPDX-License-Identifier: MIT
// Counts instructions with the processor's timer: under `qemu -icount shift=0` an instruction takes
// 1 ns, and the MPS2 boards' timer runs at 25 MHz.
#include "cortex_m/platform.hpp"

namespace flotilla::target {
namespace {

constexpr std::uint32_t kPerCount = 40, kMax = 0xFF'FFFF;

volatile std::uint32_t& at(std::uintptr_t address) {
  return *reinterpret_cast<volatile std::uint32_t*>(address);
}

}  // namespace

std::uint32_t instructions() {
  constexpr std::uintptr_t kControl = 0xE000'E010, kReload = 0xE000'E014, kCurrent = 0xE000'E018;
  constexpr std::uint32_t kRuns = 1, kProcessorsClock = 4;
  static std::uint32_t last = 0;
  if ((at(kControl) & kRuns) == 0) {
    at(kReload) = kMax;
    at(kControl) = kRuns | kProcessorsClock;
  }
  const std::uint32_t now = at(kCurrent), passed = (last - now) & kMax;  // it counts down
  last = now;
  return passed * kPerCount;
}

}  // namespace flotilla::target
