// SPDX-License-Identifier: MIT
// From reset to main(): memory, floating-point unit, constructors.
#include <algorithm>
#include <array>

#include "cortex_m/platform.hpp"
#include "cortex_m/semihosting.hpp"

extern "C" {
// Symbols of memory.ld.
extern std::uint32_t data_begin[], data_end[], data_stored[], bss_begin[], bss_end[];
extern std::uint32_t stack_bottom[], stack_top[];
using Constructor = void (*)();
extern Constructor init_begin[], init_end[];
[[noreturn]] void reset();
}

namespace {

using Handler = void (*)();
constexpr std::uint32_t kPaint = 0xDEADBEEF;

[[noreturn]] void fault() {
  flotilla::target::print("fault\n");
  flotilla::target::leave(false);
}

struct Vectors {
  std::uint32_t* stack;
  std::array<Handler, 15> handlers;
};

[[gnu::section(".vectors"), gnu::used]] const Vectors vectors{
    stack_top, {reset, fault, fault, fault, fault, fault}};

}  // namespace

extern "C" [[gnu::naked]] void reset() {
  // Naked: a stack frame would lie in the area that is painted.
  asm volatile(
      "ldr r0, =stack_bottom\n"
      "ldr r1, =stack_top\n"
      "ldr r2, =0xDEADBEEF\n"
      "1: cmp r0, r1\n"
      "bhs 2f\n"
      "str r2, [r0], #4\n"
      "b 1b\n"
      "2: b start\n");
}

extern "C" [[noreturn, gnu::used]] void start() {
  auto& coprocessors = *reinterpret_cast<volatile std::uint32_t*>(0xE000ED88);  // CPACR
  coprocessors = coprocessors | 0xFU << 20U;
  asm volatile("dsb\nisb");
  std::copy(data_stored, data_stored + (data_end - data_begin), data_begin);
  std::fill(bss_begin, bss_end, 0U);
  std::for_each(init_begin, init_end, [](Constructor construct) { construct(); });
  flotilla::target::leave(flotilla::target::run());
}

namespace flotilla::target {

std::size_t most_stack_bytes() {
  const auto used =
      std::find_if(stack_bottom, stack_top, [](std::uint32_t word) { return word != kPaint; });
  return static_cast<std::size_t>(stack_top - used) * sizeof *used;
}

}  // namespace flotilla::target
