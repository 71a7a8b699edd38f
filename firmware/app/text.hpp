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
  if ((unmet & core::kSoleController) != 0) return "another controller on the CAN bus";
  if ((unmet & core::kBusUp) != 0) return "CAN bus is down";
  if ((unmet & core::kOwnFresh) != 0) return "own state is not fresh";
  if ((unmet & core::kEscsOnline) != 0) return "ESCs are not online";
  if ((unmet & core::kLeaderFresh) != 0) return "leader's state is not fresh";
  if ((unmet & core::kParametersSaved) != 0) return "parameters are not saved";
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

/// A number with a name of up to 10 characters, for plots.
inline link::NamedValueFloat value_of(std::string_view name, float value, std::uint32_t boot_ms) {
  link::NamedValueFloat message{boot_ms, value, {}};
  std::copy_n(name.begin(), std::min(name.size(), message.name.size()), message.name.begin());
  return message;
}

}  // namespace flotilla::app
