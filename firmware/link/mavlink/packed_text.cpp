// SPDX-License-Identifier: MIT
#include "link/mavlink/packed_text.hpp"

#include <algorithm>

namespace flotilla::link {

std::size_t PackedText::read(std::size_t offset, std::span<std::uint8_t> out) const {
  if (offset >= size()) return 0;
  const std::size_t taken = std::min<std::size_t>(out.size(), size() - offset);
  if (packed_.pairs == nullptr) {
    std::copy_n(plain_.begin() + static_cast<std::ptrdiff_t>(offset), taken, out.begin());
  } else {
    unpack(offset, out.first(taken));
  }
  return taken;
}

void PackedText::unpack(std::size_t offset, std::span<std::uint8_t> out) const {
  const Pairs& pairs = *packed_.pairs;
  const std::uint8_t* next = packed_.bytes.data() + packed_.pages[offset / kPage];
  std::array<std::uint8_t, kDepth> waiting;  // second halves of pairs
  std::size_t count = 0;
  std::size_t skipped = offset % kPage;
  for (std::size_t written = 0; written < out.size();) {
    std::uint8_t byte = count > 0 ? waiting[--count] : *next++;
    for (; pairs[byte][1] != 0; byte = pairs[byte][0]) waiting[count++] = pairs[byte][1];
    if (skipped > 0) {
      --skipped;
    } else {
      out[written++] = byte;
    }
  }
}

}  // namespace flotilla::link
