// SPDX-License-Identifier: MIT
// The same program on a computer with an operating system, for comparison.
#include <cstdio>

#include "cortex_m/platform.hpp"

namespace flotilla::target {

void print(const char* text) { std::fputs(text, stdout); }

bool read(std::span<std::uint8_t> out) {
  return std::fread(out.data(), 1, out.size(), stdin) == out.size();
}

std::uint32_t instructions() { return 0; }

std::size_t most_stack_bytes() { return 0; }

}  // namespace flotilla::target

int main() { return flotilla::target::run() ? 0 : 1; }
