// SPDX-License-Identifier: MIT
// Here, not in the header: a visit of seventy types takes the compiler seconds.
#include <type_traits>
#include <utility>
#include <variant>

#include "fuzz/mavlink_ops.hpp"
#include "link/fields.hpp"

namespace flotilla::fuzz {

link::Message any_message(Stream& in) {
  link::Message message;
  const std::size_t index = in.byte() % std::variant_size_v<link::Message>;
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    ((I == index ? void(message.emplace<I>()) : void()), ...);
  }(std::make_index_sequence<std::variant_size_v<link::Message>>{});
  const auto fill = [&]<class Field>(Field& field) {
    if constexpr (std::is_arithmetic_v<Field>) {
      field = in.number<Field>();
    } else {
      for (auto& x : field) x = in.number<std::remove_reference_t<decltype(x)>>();
    }
  };
  std::visit([&](auto& m) { testing::each_field(m, fill); }, message);
  return message;
}

}  // namespace flotilla::fuzz
