// SPDX-License-Identifier: MIT
// What the program needs of what it runs on: a microcontroller, or a PC that it is compared with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace flotilla::target {

/// The program; whether it went well.
bool run();

void print(const char* text);

/// Fills `out` from standard input; false where that has less.
bool read(std::span<std::uint8_t> out);

/// Since it was called last, within 40; at most 600 million. 0 where nobody counts.
std::uint32_t instructions();

/// As much of the stack as was ever in use since reset. 0 where nobody knows.
std::size_t most_stack_bytes();

}  // namespace flotilla::target
