// SPDX-License-Identifier: MIT
// Checks whether a stored plan respects the fence, a few legs per tick, because both may be long.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "app/plan/fence.hpp"

namespace flotilla::app {

class PlanCheck {
 public:
  /// Begins again after a change of the plan or the fence. judged: each leg was judged on arrival.
  void begin(bool judged = false) {
    over_ = judged;
    from_.reset();
    at_ = 0;
    why_ = {};
  }

  /// Judges a few more legs. True if it found the first fault.
  bool forward(const Fence& fence, Plan plan, const PlanDefaults& defaults);

  bool is_over() const { return over_; }
  /// The item that leaves the fence, and why; an empty text: none does, as far as was judged.
  std::size_t item() const { return at_; }
  std::string_view why() const { return why_; }

 private:
  bool over_ = true;
  std::optional<std::size_t> from_;  // the last item that names a place
  std::size_t at_ = 0;
  std::string_view why_{};
};

/// Judges the last item of a plan: its place, a circle round it, and the legs to it from the place
/// before, or from any corner of a circle there; for a jump, the legs back.
PlanFault fence_fault_of_last(const Fence& fence, Plan plan, const PlanDefaults& defaults);

}  // namespace flotilla::app
