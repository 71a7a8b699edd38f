// SPDX-License-Identifier: MIT
// Reports of a boat: to ground stations and other boats as Report, to its host as Snapshot.
#pragma once

#include <cstdint>
#include <optional>

#include "app/boat/parts.hpp"

namespace flotilla::app {

/// State after the last tick, for plots and logs; SI units.
struct Snapshot {
  core::State state;
  core::Conditions conditions;
  std::optional<double> own_age_s, leader_age_s, leader_uncertainty_m;
  std::optional<double> reference_age_s;  ///< while the formation's reference is followed
  Estimates estimates;
  bool error_known;  ///< own and leader's state are fresh, or the boat sails alone
  core::Error<double> error;
  core::Nu<double> nu_star;
  core::Tau<double> asked, given;
  core::Thrust<double> thrust_N;
  core::Limits limits;               ///< limits that acted
  core::TooFast<double> slot_needs;  ///< if above LAW_U_MAX, LAW_R_MAX; else 0
  bool yielding;                     ///< to another vessel
  bool in_slot;  ///< in FORMATION and closed up, or sailing alone and at its place
  std::optional<double> separation_m;  ///< predicted, of the nearest vessel
  link::Counters counters;
};

template <class S>
Report report_of(const Parts<S>& boat, std::int64_t now_us);

template <class S>
Snapshot snapshot_of(const Parts<S>& boat, std::int64_t now_us);

/// Followers of a boat in FORMATION, or in COAST for less than 1 s, follow the formation's
/// reference; after that they follow the boat itself, which comes to rest.
template <class S>
std::optional<link::FormationReference> reference_of(const Parts<S>& boat, std::int64_t now_us);

}  // namespace flotilla::app
