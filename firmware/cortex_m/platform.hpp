// SPDX-License-Identifier: MIT
// Functions that the platform supplies: a microcontroller, or a PC for comparison.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace flotilla::target {

/// The program; returns whether it succeeded.
bool run();

void print(const char* text);

/// Fills `out` from standard input; false at the end of input.
bool read(std::span<std::uint8_t> out);

/// Instructions since the last call, ±40; at most 600 million. 0 if the platform does not count.
std::uint32_t instructions();

/// The most stack ever in use since reset; 0 if unknown.
std::size_t most_stack_bytes();

}  // namespace flotilla::target
