// SPDX-License-Identifier: MIT
// Whether a stored plan keeps the fence: judged a few legs a tick, as both may be long.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

#include "app/guidance/fence.hpp"

namespace flotilla::app {

class PlanCheck {
 public:
  /// After a change of the plan or the fence; judged: each leg was on its way in.
  void begin(bool judged = false) {
    over_ = judged;
    from_.reset();
    at_ = 0;
    why_ = {};
  }

  /// A few legs further. True if that has found the first fault.
  bool forward(const Fence& fence, Plan plan, const PlanDefaults& defaults);

  bool is_over() const { return over_; }
  /// The item that leaves the fence, and how; empty: none does, as far as was judged.
  std::size_t item() const { return at_; }
  std::string_view why() const { return why_; }

 private:
  bool over_ = true;
  std::optional<convert::GlobalPoint> from_;
  std::size_t at_ = 0;
  std::string_view why_{};
};

/// Judges the last item of a plan: its place, a circle round it, and the leg to it from the place
/// before; of a jump the leg back.
PlanFault fence_fault_of_last(const Fence& fence, Plan plan, const PlanDefaults& defaults);

}  // namespace flotilla::app
