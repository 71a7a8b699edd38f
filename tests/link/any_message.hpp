// SPDX-License-Identifier: MIT
// Random MAVLink messages of every type that the firmware has, and their fields as numbers.
#pragma once

#include <algorithm>
#include <random>
#include <type_traits>
#include <vector>

#include "link/fields.hpp"
#include "link/mavlink/decode.hpp"
#include "link/mavlink/encode.hpp"

namespace flotilla::testing {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t kMessages = std::variant_size_v<link::Message>;  // the first is monostate

/// The message as a boat receives it.
inline link::Message as_read(const link::Message& message) {
  const auto read = [&](const auto& m) {
    if constexpr (requires { m.kIsRead; }) return m.kIsRead ? message : link::Message{};
    return link::Message{};
  };
  return std::visit(read, message);
}

struct AnyMessage {
  explicit AnyMessage(std::uint32_t seed) : engine(seed) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(engine()); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(engine()); }

  template <class Number>
  void fill(Number& x) {
    if constexpr (std::is_floating_point_v<Number>) {
      x = std::uniform_real_distribution<Number>(-1000, 1000)(engine);
    } else {
      x = static_cast<Number>(std::uint64_t{engine()} << 32U | engine());
    }
  }

  template <class Number, std::size_t N>
  void fill(std::array<Number, N>& numbers) {
    for (Number& x : numbers) fill(x);
  }

  /// A text of any length; the longest has no room for a NUL.
  template <std::size_t N>
  void fill(link::Text<N>& text) {
    text = {};
    const std::size_t length = engine() % (N + 1);
    for (std::size_t i = 0; i < length; ++i) text[i] = static_cast<char>('A' + u8() % 26);
  }

  /// 1 … kMessages − 1
  link::Message operator()(std::size_t index) {
    link::Message message = of_type<1>(index);
    std::visit([&](auto& m) { each_field(m, [&](auto& field) { fill(field); }); }, message);
    return message;
  }

  template <std::size_t I>
  static link::Message of_type(std::size_t index) {
    if constexpr (I + 1 < kMessages) {
      if (index != I) return of_type<I + 1>(index);
    }
    return link::Message(std::in_place_index<I>);
  }

  std::mt19937 engine;
};

/// All fields of a message, its type first; a long double holds each of them exactly.
inline std::vector<long double> fields_of(const link::Message& message) {
  std::vector<long double> out{static_cast<long double>(message.index())};
  const auto put = [&](const auto& field) {
    if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(field)>>) {
      out.push_back(static_cast<long double>(field));
    } else {
      for (const auto x : field) out.push_back(static_cast<long double>(x));
    }
  };
  std::visit([&](const auto& m) { each_field(m, put); }, message);
  return out;
}

inline Bytes frame_of(link::MavlinkEncoder& encoder, const link::Message& message) {
  Bytes out(300);
  out.resize(encoder.encode(message, out));
  return out;
}

/// All messages that a decoder finds in these bytes, given at once.
inline std::vector<link::Received> received_from(link::MavlinkDecoder& decoder,
                                                 std::span<const std::uint8_t> bytes,
                                                 link::Counters& counters) {
  std::vector<link::Received> out;
  while (!bytes.empty()) {
    bytes = bytes.subspan(decoder.fill(bytes));
    while (const auto received = decoder.next(counters)) out.push_back(*received);
  }
  return out;
}

}  // namespace flotilla::testing
