// SPDX-License-Identifier: MIT
// Predicted motion of a boat that leads its fleet.
#pragma once

#include <array>

#include "app/convert/convert_scalar.hpp"
#include "app/fleet/assignment.hpp"
#include "app/guidance/guidance.hpp"

namespace flotilla::app {

/// Predicted from the plan in AUTO, else at the present velocity.
template <class S>
FleetOutlook outlook_of(const Guidance<S>& guidance, bool sails_plan, float most_mps) {
  std::array<core::Motion<S>, FleetOutlook::kMax> motions{};
  FleetOutlook out{.count = sails_plan ? motions.size() : 1, .most_mps = most_mps};
  if (sails_plan) {
    guidance.plan_vessel().foresee(motions, FleetOutlook::kEvery_s);
  } else {
    motions[0] = guidance.motion();
    motions[0].nu.r = S(0);
  }
  const auto of = [](S x) { return static_cast<float>(convert::number(x)); };
  for (std::size_t k = 0; k < out.count; ++k) {
    out.at[k] = {of(motions[k].nu.u), of(motions[k].psi), of(motions[k].nu.r)};
  }
  return out;
}

}  // namespace flotilla::app
