// SPDX-License-Identifier: MIT
// A sentence for the operator, put together without a heap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace flotilla::app {

/// A text of at most 120 characters; longer text is cut off.
class Sentence {
 public:
  Sentence& operator<<(std::string_view text);
  /// A literal, whose length is not counted at run time.
  template <std::size_t N>
  [[gnu::always_inline]] Sentence& operator<<(const char (&text)[N]) {
    return *this << std::string_view(text, N - 1);
  }
  Sentence& operator<<(float number);
  std::string_view text() const { return {characters_.data(), size_}; }

 private:
  Sentence& add_digits(std::uint32_t digits, int point);

  std::array<char, 120> characters_{};
  std::size_t size_ = 0;
};

}  // namespace flotilla::app
