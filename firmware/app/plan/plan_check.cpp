// SPDX-License-Identifier: MIT
#include "app/plan/plan_check.hpp"

#include <algorithm>

namespace flotilla::app {
namespace {

constexpr int kItemsPerTick = 4;

/// The item to whose place an item leads; a jump leads to the first place at or after its target.
std::optional<std::size_t> aim_of(Plan plan, std::size_t item, const PlanDefaults& defaults,
                                  bool& jumps) {
  jumps = plan[item].command == link::mav::kDoJump;
  std::size_t at = jumps ? jump_of(plan[item], defaults) : item;
  while (jumps && !place_of(plan[at]) && at + 1 < item) ++at;
  return place_of(plan[at]) ? std::optional(at) : std::nullopt;
}

/// Where legs from or to an item may begin or end: its place, or the corners round a circle.
struct Ends {
  const PlanItem& item;
  const PlanDefaults& defaults;

  bool is_circle() const { return extent_of(item, defaults) > 0; }
  std::size_t size() const { return is_circle() ? 8 : 1; }
  convert::GlobalPoint operator[](std::size_t i) const {
    return is_circle() ? corner_of(item, defaults, i) : *place_of(item);
  }
};

/// Judges the legs between two items; without the first, only the second one's place.
std::string_view refusal_of(const Fence& fence, const PlanItem* from_item, const PlanItem& to_item,
                            const PlanDefaults& defaults) {
  const Ends to{to_item, defaults};
  const Ends from{from_item != nullptr ? *from_item : to_item, defaults};
  std::string_view why;
  if (from_item == nullptr) why = fence.refusal_of(*place_of(to_item), defaults.margin_m);
  for (std::size_t leg = 0; why.empty() && leg < from.size() * to.size(); ++leg) {
    why = fence.refusal_of(from[leg / to.size()], to[leg % to.size()], defaults.margin_m);
  }
  if (!why.empty() || !to.is_circle()) return why;
  return fence.refusal_of(*place_of(to_item), defaults.margin_m + extent_of(to_item, defaults));
}

/// Judges the place that an item makes home: failsafes must be able to return there.
std::string_view refusal_of_home(const Fence& fence, const PlanItem& item,
                                 const PlanDefaults& defaults) {
  if (item.command != link::mav::kDoSetHome) return {};
  const auto home = home_of(item);
  return home ? fence.refusal_of(*home, defaults.margin_m) : std::string_view();
}

}  // namespace

bool PlanCheck::forward(const Fence& fence, Plan plan, const PlanDefaults& defaults) {
  if (over_) return false;
  for (int n = 0; n < kItemsPerTick && fence.is_on() && at_ < plan.size(); ++n, ++at_) {
    bool jumps = false;
    const auto to = aim_of(plan, at_, defaults, jumps);
    why_ = refusal_of_home(fence, plan[at_], defaults);
    if (to) why_ = refusal_of(fence, from_ ? &plan[*from_] : nullptr, plan[*to], defaults);
    if (to && !jumps) from_ = to;
    if (why_.empty()) continue;
    over_ = true;
    return true;
  }
  over_ = !fence.is_on() || at_ >= plan.size();
  return false;
}

PlanFault fence_fault_of_last(const Fence& fence, Plan plan, const PlanDefaults& defaults) {
  if (!fence.is_on()) return {};
  const auto fault = [](std::string_view why) {
    return why.empty() ? PlanFault{} : PlanFault{link::mav::kMissionInvalid, why};
  };
  bool jumps = false;
  const auto to = aim_of(plan, plan.size() - 1, defaults, jumps);
  if (!to) return fault(refusal_of_home(fence, plan.back(), defaults));
  const PlanItem* from = nullptr;
  for (std::size_t i = plan.size() - 1; i > 0 && from == nullptr; --i) {
    if (place_of(plan[i - 1])) from = &plan[i - 1];
  }
  return fault(refusal_of(fence, from, plan[*to], defaults));
}

}  // namespace flotilla::app
