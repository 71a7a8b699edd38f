// SPDX-License-Identifier: MIT
// Short messages to the operator, without a heap.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string_view>

#include "core/supervisor.hpp"
#include "link/messages.hpp"

namespace flotilla::app {

inline std::string_view name_of(core::State state) {
  constexpr std::array<std::string_view, core::kStates> kNames{"DISARMED", "HOLD", "FORMATION",
                                                               "FAULT"};
  return kNames[static_cast<std::size_t>(state)];
}

/// What is wrong, in words: the first condition of the set, or nothing for none.
inline std::string_view complaint_of(core::Conditions unmet) {
  if ((unmet & core::kOwnFresh) != 0) return "own state is not fresh";
  if ((unmet & core::kEscsOnline) != 0) return "ESCs are not online";
  if ((unmet & core::kLeaderFresh) != 0) return "leader's state is not fresh";
  return {};
}

/// Parts joined; what exceeds 50 characters is cut off.
inline link::Statustext text_of(std::uint8_t severity,
                                std::initializer_list<std::string_view> parts) {
  link::Statustext message{severity, {}};
  std::size_t length = 0;
  for (const std::string_view part : parts) {
    const std::size_t n = std::min(part.size(), message.text.size() - length);
    std::copy_n(part.begin(), n, message.text.begin() + static_cast<std::ptrdiff_t>(length));
    length += n;
  }
  return message;
}

}  // namespace flotilla::app
