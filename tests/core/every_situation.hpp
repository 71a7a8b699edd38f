// SPDX-License-Identifier: MIT
// Every state, request and set of conditions of the supervisor, as few as tell all of them apart.
#pragma once

#include <map>
#include <vector>

#include "core/supervisor.hpp"

namespace flotilla::core {

constexpr unsigned kBits = kConditionCount + 4;  // conditions and choices

/// Conditions that no row tells apart, found from the table itself: what holds of one that is not
/// met holds of any of them.
inline std::vector<Conditions> classes() {
  std::map<std::vector<bool>, Conditions> found;
  for (unsigned bit = 0; bit < kBits; ++bit) {
    std::vector<bool> role;
    const auto note = [&](Conditions set) { role.push_back((set >> bit & 1U) != 0); };
    for (const Row& row : kTable) {
      note(row.needs);
      note(row.lacks);
    }
    for (const Conditions set : {kManualDrive, kDrive, kCoastDrive, kTestDrive, kAutoDrive})
      note(set);
    found[role] |= Conditions{1} << bit;
  }
  std::vector<Conditions> out;
  for (const auto& [role, set] : found) out.push_back(set);
  return out;
}

/// Every set of conditions, each class met or not as a whole.
inline std::vector<Conditions> every_set() {
  const std::vector<Conditions> of = classes();
  std::vector<Conditions> out;
  for (unsigned c = 0; c >> of.size() == 0; ++c) {
    Conditions met = 0;
    for (std::size_t i = 0; i < of.size(); ++i) met |= (c >> i & 1U) != 0 ? of[i] : 0;
    out.push_back(met);
  }
  return out;
}

/// Calls f(state, request, conditions) for all there are.
template <class F>
void for_every_situation(F f) {
  static const std::vector<Conditions> kSets = every_set();
  for (unsigned s = 0; s < kStates; ++s) {
    for (unsigned r = 0; r < kRequests; ++r) {
      for (const Conditions met : kSets) f(static_cast<State>(s), static_cast<Request>(r), met);
    }
  }
}

inline bool has(Conditions met, Conditions desired) { return (met & desired) == desired; }

}  // namespace flotilla::core
