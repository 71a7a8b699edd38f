// SPDX-License-Identifier: MIT
// Random MAVLink messages of every type that the firmware has, and their fields as numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <variant>
#include <vector>

#include "link/mavlink/decode.hpp"
#include "link/mavlink/encode.hpp"

namespace flotilla::testing {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t kMessages = std::variant_size_v<link::Message>;  // the first is monostate

/// The message as a boat receives it.
link::Message as_read(const link::Message& message);

struct AnyMessage {
  explicit AnyMessage(std::uint32_t seed) : engine(seed) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(engine()); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(engine()); }

  /// 1 … kMessages − 1
  link::Message operator()(std::size_t index);

  std::mt19937 engine;
};

/// All fields of a message, its type first; a long double holds each of them exactly.
std::vector<long double> fields_of(const link::Message& message);

Bytes frame_of(link::MavlinkEncoder& encoder, const link::Message& message);

/// All messages that a decoder finds in these bytes, given at once.
std::vector<link::Received> received_from(link::MavlinkDecoder& decoder,
                                          std::span<const std::uint8_t> bytes,
                                          link::Counters& counters);

}  // namespace flotilla::testing
