// SPDX-License-Identifier: MIT
#include "app/sentence.hpp"

#include <algorithm>
#include <cmath>

namespace flotilla::app {

Sentence& Sentence::operator<<(std::string_view text) {
  const std::size_t n = std::min(text.size(), characters_.size() - size_);
  std::copy_n(text.begin(), n, characters_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += n;
  return *this;
}

Sentence& Sentence::add_digits(std::uint32_t digits, int point) {
  std::array<char, 11> text;
  std::size_t begin = text.size();
  do {
    if (point > 0 && text.size() - begin == static_cast<std::size_t>(point)) text[--begin] = '.';
    text[--begin] = static_cast<char>('0' + digits % 10);
    digits /= 10;
  } while (digits > 0 || text.size() - begin <= static_cast<std::size_t>(std::max(point, 0)));
  return *this << std::string_view(text.data() + begin, text.size() - begin);
}

/// Six significant digits. Not std::to_chars: its tables exceed a microcontroller's flash.
Sentence& Sentence::operator<<(float number) {
  if (std::isnan(number)) return *this << "nan";
  if (number < 0) *this << "-";
  if (std::isinf(number)) return *this << "inf";
  double x = std::fabs(static_cast<double>(number));
  int point = 0;  // digits after the decimal point
  for (const bool large = x >= 1e9; large && x >= 1e6; x /= 10) --point;
  for (; x > 0 && x * 10 < 1e6 && point < 9; x *= 10) ++point;
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): never negative; lround is large on the M4
  auto digits = static_cast<std::uint32_t>(x + 0.5);
  if (digits == 0) point = 0;
  for (; point != 0 && digits % 10 == 0; digits /= 10) --point;
  add_digits(digits, point);
  return point < 0 ? (*this << "e").add_digits(static_cast<std::uint32_t>(-point), 0) : *this;
}

}  // namespace flotilla::app
