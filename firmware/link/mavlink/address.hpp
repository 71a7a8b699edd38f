// SPDX-License-Identifier: MIT
// Parts of the generated messages.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

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

/// Whether a text equals `other`, which must be shorter than N.
template <std::size_t N>
bool is_text(const Text<N>& text, std::string_view other) {
  return std::string_view(text.data(), other.size()) == other && text[other.size()] == '\0';
}

}  // namespace flotilla::link
