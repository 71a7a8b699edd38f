// SPDX-License-Identifier: MIT
#include "app/guidance/plan_check.hpp"

#include <algorithm>

namespace flotilla::app {
namespace {

constexpr int kItemsPerTick = 4;

std::string_view refusal_of(const Fence& fence, const std::optional<convert::GlobalPoint>& from,
                            const convert::GlobalPoint& to, float margin_m) {
  return from ? fence.refusal_of(*from, to, margin_m) : fence.refusal_of(to, margin_m);
}

}  // namespace

bool PlanCheck::forward(const Fence& fence, Plan plan, float margin_m) {
  if (over_) return false;
  for (int n = 0; n < kItemsPerTick && fence.is_on() && at_ < plan.size(); ++n, ++at_) {
    const auto to = place_of(plan[at_]);
    if (!to) continue;
    why_ = refusal_of(fence, from_, *to, margin_m);
    from_ = to;
    if (why_.empty()) continue;
    over_ = true;
    return true;
  }
  over_ = !fence.is_on() || at_ >= plan.size();
  return false;
}

PlanFault fence_fault_of_last(const Fence& fence, Plan plan, float margin_m) {
  if (!fence.is_on()) return {};
  const auto to = place_of(plan.back());
  if (!to) return {};
  std::optional<convert::GlobalPoint> from;
  for (std::size_t i = plan.size() - 1; i > 0 && !from; --i) from = place_of(plan[i - 1]);
  const std::string_view why = refusal_of(fence, from, *to, margin_m);
  return why.empty() ? PlanFault{} : PlanFault{link::mav::kMissionInvalid, why};
}

}  // namespace flotilla::app
