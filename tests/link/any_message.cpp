// SPDX-License-Identifier: MIT
// Here, not in the header: a visit of seventy types takes the compiler three seconds.
#include "link/any_message.hpp"

#include <array>
#include <type_traits>

#include "link/fields.hpp"

namespace flotilla::testing {
namespace {

template <std::size_t I = 1>
link::Message of_type(std::size_t index) {
  if constexpr (I + 1 < kMessages) {
    if (index != I) return of_type<I + 1>(index);
  }
  return link::Message(std::in_place_index<I>);
}

struct Filler {
  AnyMessage& any;

  template <class Number>
  void fill(Number& x) {
    if constexpr (std::is_floating_point_v<Number>) {
      x = std::uniform_real_distribution<Number>(-1000, 1000)(any.engine);
    } else {
      x = static_cast<Number>(std::uint64_t{any.engine()} << 32U | any.engine());
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
    const std::size_t length = any.engine() % (N + 1);
    for (std::size_t i = 0; i < length; ++i) text[i] = static_cast<char>('A' + any.u8() % 26);
  }
};

}  // namespace

link::Message as_read(const link::Message& message) {
  const auto read = [&](const auto& m) {
    if constexpr (requires { m.kIsRead; }) return m.kIsRead ? message : link::Message{};
    return link::Message{};
  };
  return std::visit(read, message);
}

link::Message AnyMessage::operator()(std::size_t index) {
  link::Message message = of_type(index);
  Filler filler{*this};
  std::visit([&](auto& m) { each_field(m, [&](auto& field) { filler.fill(field); }); }, message);
  return message;
}

std::vector<long double> fields_of(const link::Message& message) {
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

Bytes frame_of(link::MavlinkEncoder& encoder, const link::Message& message) {
  Bytes out(300);
  out.resize(encoder.encode(message, out));
  return out;
}

std::vector<link::Received> received_from(link::MavlinkDecoder& decoder,
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
