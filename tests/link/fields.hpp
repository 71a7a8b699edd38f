// SPDX-License-Identifier: MIT
// The members of a plain struct, one after the other, so that a test misses none.
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

namespace flotilla::testing {

struct Anything {
  template <class T>
  operator T() const;
};

/// How many members an aggregate has: as many as it can be initialised with.
template <class T, class... Members>
constexpr std::size_t members_of() {
  if constexpr (requires { T{Members{}..., Anything{}}; }) {
    return members_of<T, Members..., Anything>();
  } else {
    return sizeof...(Members);
  }
}

template <class T>
constexpr bool is_array = false;
template <class T, std::size_t N>
constexpr bool is_array<std::array<T, N>> = true;

/// Calls f with every number and every array in x, those of nested structs too, in their order.
template <class T, class F>
void each_field(T& x, F f) {
  using Struct = std::remove_const_t<T>;
  const auto all = [&](auto&... members) { (each_field(members, f), ...); };
  if constexpr (std::is_arithmetic_v<Struct> || is_array<Struct>) {
    f(x);
  } else if constexpr (constexpr std::size_t n = members_of<Struct>(); n == 1) {
    auto& [a] = x;
    all(a);
  } else if constexpr (n == 2) {
    auto& [a, b] = x;
    all(a, b);
  } else if constexpr (n == 3) {
    auto& [a, b, c] = x;
    all(a, b, c);
  } else if constexpr (n == 4) {
    auto& [a, b, c, d] = x;
    all(a, b, c, d);
  } else if constexpr (n == 5) {
    auto& [a, b, c, d, e] = x;
    all(a, b, c, d, e);
  } else if constexpr (n == 6) {
    auto& [a, b, c, d, e, g] = x;
    all(a, b, c, d, e, g);
  } else if constexpr (n == 7) {
    auto& [a, b, c, d, e, g, h] = x;
    all(a, b, c, d, e, g, h);
  } else if constexpr (n == 8) {
    auto& [a, b, c, d, e, g, h, i] = x;
    all(a, b, c, d, e, g, h, i);
  } else if constexpr (n == 9) {
    auto& [a, b, c, d, e, g, h, i, j] = x;
    all(a, b, c, d, e, g, h, i, j);
  } else if constexpr (n == 10) {
    auto& [a, b, c, d, e, g, h, i, j, k] = x;
    all(a, b, c, d, e, g, h, i, j, k);
  } else if constexpr (n == 11) {
    auto& [a, b, c, d, e, g, h, i, j, k, l] = x;
    all(a, b, c, d, e, g, h, i, j, k, l);
  } else if constexpr (n == 13) {
    auto& [a, b, c, d, e, g, h, i, j, k, l, m, o] = x;
    all(a, b, c, d, e, g, h, i, j, k, l, m, o);
  } else {
    static_assert(n == 15, "add this number of members");
    auto& [a, b, c, d, e, g, h, i, j, k, l, m, o, p, q] = x;
    all(a, b, c, d, e, g, h, i, j, k, l, m, o, p, q);
  }
}

}  // namespace flotilla::testing
