// SPDX-License-Identifier: MIT
// Parts of the generated messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace flotilla::link {

/// Sender or addressee of a message; 0 is everybody.
struct Address {
  std::uint8_t system = 0;
  std::uint8_t component = 0;
  bool operator==(const Address&) const = default;
};

/// NUL-padded; a text that fills its array has no NUL.
template <std::size_t N>
using Text = std::array<char, N>;

}  // namespace flotilla::link
