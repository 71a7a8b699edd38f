// SPDX-License-Identifier: MIT
// The members of a message, one after the other, so that a test misses none.
#pragma once

#include <cstddef>
#include <type_traits>
#include <variant>

namespace flotilla::testing {

/// Calls f with every number and every array in m, in their order; a target is two numbers.
template <class M, class F>
void each_field(M& m, F f) {
  if constexpr (!std::is_same_v<std::remove_const_t<M>, std::monostate>) {
    m.fields(m, [&](std::size_t, auto& field) { f(field); });
  }
}

}  // namespace flotilla::testing
