// SPDX-License-Identifier: MIT
// I/O without an operating system, through a debugger or QEMU. Source: ARM, "Semihosting for
// AArch32 and AArch64", 2.0.
#include "cortex_m/semihosting.hpp"

#include <array>

#include "cortex_m/platform.hpp"

namespace flotilla::target {
namespace {

enum Operation : std::uint32_t { kOpen = 0x01, kWrite0 = 0x04, kRead = 0x06, kExit = 0x18 };

std::uint32_t call(Operation operation, std::uintptr_t argument) {
  register std::uint32_t r0 asm("r0") = operation;
  register std::uintptr_t r1 asm("r1") = argument;
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

std::uint32_t call(Operation operation, const std::array<std::uintptr_t, 3>& arguments) {
  return call(operation, reinterpret_cast<std::uintptr_t>(arguments.data()));
}

std::uint32_t standard_input() {
  constexpr std::uintptr_t kBinary = 1, kLength = 3;
  static const std::uint32_t file =
      call(kOpen, {reinterpret_cast<std::uintptr_t>(":tt"), kBinary, kLength});
  return file;
}

}  // namespace

void print(const char* text) { call(kWrite0, reinterpret_cast<std::uintptr_t>(text)); }

void leave(bool well) {
  constexpr std::uintptr_t kApplicationExit = 0x20026, kInternalError = 0x20024;
  while (true) call(kExit, well ? kApplicationExit : kInternalError);
}

bool read(std::span<std::uint8_t> out) {
  // The call returns the number of missing bytes: a pipe delivers only what it holds.
  while (!out.empty()) {
    const std::uint32_t missing =
        call(kRead, {standard_input(), reinterpret_cast<std::uintptr_t>(out.data()), out.size()});
    if (missing >= out.size()) return false;
    out = out.last(missing);
  }
  return true;
}

}  // namespace flotilla::target
