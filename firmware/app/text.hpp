// SPDX-License-Identifier: MIT
// Short messages to the operator, without a heap.
#pragma once

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string_view>

#include "core/supervisor.hpp"
#include "link/messages.hpp"

namespace flotilla::app {

inline std::string_view name_of(core::State state) {
  constexpr std::array<std::string_view, core::kStates> kNames{"DISARMED",  "HOLD", "MANUAL",
                                                               "FORMATION", "TEST", "FAULT"};
  return kNames[static_cast<std::size_t>(state)];
}

struct Complaint {
  core::Conditions condition;
  std::string_view sentence;
};

/// What is wrong where a condition is not met, the most important first.
constexpr std::array<Complaint, core::kConditionCount> kComplaints{{
    {core::kSoleController, "another controller on the CAN bus"},
    {core::kBusUp, "CAN bus is down"},
    {core::kOwnFresh, "own state is not fresh"},
    {core::kEscsOnline, "ESCs are not online"},
    {core::kLeaderFresh, "leader's state is not fresh"},
    {core::kParametersSaved, "parameters are not saved"},
    {core::kSticksFresh, "no sticks: MANUAL_CONTROL is silent"},
    {core::kTestRunning, "no motor test is running"},
}};

/// Calls f(sentence) for every condition of the set, the most important first.
template <class F>
void for_each_complaint(core::Conditions unmet, F f) {
  for (const Complaint& complaint : kComplaints) {
    if ((unmet & complaint.condition) != 0) f(complaint.sentence);
  }
}

/// The most important of them, or nothing for none.
inline std::string_view complaint_of(core::Conditions unmet) {
  for (const Complaint& complaint : kComplaints) {
    if ((unmet & complaint.condition) != 0) return complaint.sentence;
  }
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
