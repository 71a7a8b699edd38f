// SPDX-License-Identifier: MIT
#include "app/plan/plan_check.hpp"

#include <algorithm>

namespace flotilla::app {
namespace {

constexpr int kItemsPerTick = 4;

/// The place to which an item leads; a jump leads to the first place at or after its target.
std::optional<convert::GlobalPoint> aim_of(Plan plan, std::size_t item,
                                           const PlanDefaults& defaults, bool& jumps) {
  jumps = plan[item].command == link::mav::kDoJump;
  std::size_t at = jumps ? jump_of(plan[item], defaults) : item;
  auto place = place_of(plan[at]);
  while (jumps && !place && ++at < item) place = place_of(plan[at]);
  return place;
}

std::string_view refusal_of(const Fence& fence, const std::optional<convert::GlobalPoint>& from,
                            const convert::GlobalPoint& to, const PlanItem& item,
                            const PlanDefaults& defaults) {
  const auto why = from ? fence.refusal_of(*from, to, defaults.margin_m)
                        : fence.refusal_of(to, defaults.margin_m);
  const float room_m = room_of(item, defaults);
  if (!why.empty() || !(room_m > 0)) return why;
  return fence.refusal_of(to, defaults.margin_m + room_m);
}

}  // namespace

bool PlanCheck::forward(const Fence& fence, Plan plan, const PlanDefaults& defaults) {
  if (over_) return false;
  for (int n = 0; n < kItemsPerTick && fence.is_on() && at_ < plan.size(); ++n, ++at_) {
    bool jumps = false;
    const auto to = aim_of(plan, at_, defaults, jumps);
    if (!to) continue;
    why_ = refusal_of(fence, from_, *to, plan[at_], defaults);
    if (!jumps) from_ = to;
    if (why_.empty()) continue;
    over_ = true;
    return true;
  }
  over_ = !fence.is_on() || at_ >= plan.size();
  return false;
}

PlanFault fence_fault_of_last(const Fence& fence, Plan plan, const PlanDefaults& defaults) {
  if (!fence.is_on()) return {};
  bool jumps = false;
  const auto to = aim_of(plan, plan.size() - 1, defaults, jumps);
  if (!to) return {};
  std::optional<convert::GlobalPoint> from;
  for (std::size_t i = plan.size() - 1; i > 0 && !from; --i) from = place_of(plan[i - 1]);
  const std::string_view why = refusal_of(fence, from, *to, plan.back(), defaults);
  return why.empty() ? PlanFault{} : PlanFault{link::mav::kMissionInvalid, why};
}

}  // namespace flotilla::app
