// SPDX-License-Identifier: MIT
// Every state, request and set of conditions of the supervisor; equivalent conditions are varied
// together.
#pragma once

#include <map>
#include <vector>

#include "core/supervisor.hpp"

namespace flotilla::core {

/// Classes of equivalent conditions, found from the table itself: no row distinguishes the
/// conditions of a class, so one that is not met stands for any of them.
inline std::vector<Conditions> classes() {
  std::map<std::vector<bool>, Conditions> found;
  for (unsigned bit = 0; bit < kConditionCount; ++bit) {
    std::vector<bool> role;
    const auto note = [&](Conditions set) { role.push_back((set >> bit & 1U) != 0); };
    for (const Row& row : kTable) {
      note(row.needs);
      note(row.lacks);
    }
    for (const Conditions set : {kManualDrive, kDrive, kCoastDrive, kTestDrive, kAutoDrive,
                                 kGuidedDrive, kLoiterDrive, kReturnDrive}) {
      note(set);
    }
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

/// Whether the operator's choices can lead to that reaction: to none if nothing is lost, and
/// otherwise to one of the possible reactions.
inline bool is_possible(State state, Conditions met, Reaction reaction) {
  const auto lacks = [&](Conditions needed) { return (met & needed) != needed; };
  const bool behind = state == State::kFormation || state == State::kCoast;
  const bool bound = behind || state == State::kAuto || state == State::kGuided;
  const bool of_limits = (bound || state == State::kLoiter) && lacks(kLimits);
  const bool of_others = (behind && lacks(kFollows)) || (bound && lacks(kGcsHeard));
  if (!of_limits && !of_others) return reaction == Reaction::kNone;
  if (reaction == Reaction::kNone) return false;
  if (reaction == Reaction::kCoast || reaction == Reaction::kManual) {
    const bool over =
        state == State::kCoast && (lacks(kCoastRunning) || reaction == Reaction::kManual);
    return behind && !of_limits && !over;
  }
  return true;
}

/// Calls f(state, request, conditions, reaction) for every situation.
template <class F>
void for_every_situation(F f) {
  static const std::vector<Conditions> kSets = every_set();
  for (unsigned s = 0; s < kStates; ++s) {
    for (unsigned r = 0; r < kRequests; ++r) {
      for (const Conditions met : kSets) {
        const auto state = static_cast<State>(s);
        const auto request = static_cast<Request>(r);
        for (unsigned on = 0; on < kReactions; ++on) {
          const auto reaction = static_cast<Reaction>(on);
          // requests are judged without one
          if (request != Request::kNone ? reaction == Reaction::kNone
                                        : is_possible(state, met, reaction)) {
            f(state, request, met, reaction);
          }
        }
      }
    }
  }
}

inline bool has(Conditions met, Conditions desired) { return (met & desired) == desired; }

}  // namespace flotilla::core
