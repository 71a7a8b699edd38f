// SPDX-License-Identifier: MIT
// A classic CAN frame with a 29-bit identifier.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace flotilla::link {

struct CanFrame {
  std::uint32_t id = 0;
  std::uint8_t size = 0;
  std::array<std::uint8_t, 8> data{};

  std::span<const std::uint8_t> bytes() const { return {data.data(), size}; }
};

}  // namespace flotilla::link
