// SPDX-License-Identifier: MIT
// The fuzzer's bytes, read from the front; missing bytes at the end are zero.
#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <span>

namespace flotilla::fuzz {

class Stream {
 public:
  explicit Stream(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool empty() const { return bytes_.empty(); }

  /// As many bytes as remain.
  std::span<const std::uint8_t> take(std::size_t count) {
    const auto taken = bytes_.first(std::min(count, bytes_.size()));
    bytes_ = bytes_.subspan(taken.size());
    return taken;
  }

  template <class Number>
    requires std::integral<Number> || std::floating_point<Number>
  Number number() {
    Number out{};
    const auto bytes = take(sizeof out);
    if (!bytes.empty()) std::memcpy(&out, bytes.data(), bytes.size());
    return out;
  }
  std::uint8_t byte() { return number<std::uint8_t>(); }

  /// One of them.
  template <class Table>
  auto one_of(const Table& table) {
    return table[byte() % std::size(table)];
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace flotilla::fuzz
