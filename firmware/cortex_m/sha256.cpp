// SPDX-License-Identifier: MIT
#include "cortex_m/sha256.hpp"

#include <cstdint>
#include <cstring>
// mavlink_sha256.h relies on the two headers above.
#define MAVLINK_HELPER static inline
#include <mavlink_sha256.h>

namespace flotilla::target {
namespace {

mavlink_sha256_ctx& context_in(void* place) { return *static_cast<mavlink_sha256_ctx*>(place); }

}  // namespace

Sha256::Sha256() {
  static_assert(sizeof(mavlink_sha256_ctx) <= sizeof context_);
  mavlink_sha256_init(&context_in(context_.data()));
}

void Sha256::add(std::span<const std::uint8_t> bytes) {
  mavlink_sha256_update(&context_in(context_.data()), bytes.data(),
                        static_cast<std::uint32_t>(bytes.size()));
}

std::array<std::uint8_t, 32> Sha256::finish() {
  std::array<std::uint8_t, 6> first;
  mavlink_sha256_ctx& context = context_in(context_.data());
  mavlink_sha256_final_48(&context, first.data());
  std::array<std::uint8_t, 32> digest;
  for (std::size_t i = 0; i < digest.size(); ++i) {
    digest[i] = static_cast<std::uint8_t>(context.counter[i / 4] >> (24 - 8 * (i % 4)));
  }
  return digest;
}

}  // namespace flotilla::target
