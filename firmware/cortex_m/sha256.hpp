// SPDX-License-Identifier: MIT
// Full SHA-256, with the functions that MAVLink's signatures use.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace flotilla::target {

class Sha256 {
 public:
  Sha256();

  /// Fewer than 2^29 bytes in all.
  void add(std::span<const std::uint8_t> bytes);

  std::array<std::uint8_t, 32> finish();

 private:
  /// As large as mavlink_sha256_ctx.
  alignas(std::uint64_t) std::array<std::uint8_t, 104> context_;
};

}  // namespace flotilla::target
