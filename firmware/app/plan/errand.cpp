// SPDX-License-Identifier: MIT
#include "app/plan/errand.hpp"

#include <algorithm>

namespace flotilla::app {

void Errand::sail_to(const Target& target) { sail_by({}, 0, target); }

void Errand::sail_by(std::span<const convert::GlobalPoint> bends, float radius_m,
                     const Target& target) {
  count_ = 0;
  const auto add = [&](std::uint16_t command, float param, const convert::GlobalPoint& place) {
    PlanItem& item = items_[count_++];
    item = {};
    item.command = command;
    item.param[1] = param;
    item.x = place.latitude;
    item.y = place.longitude;
  };
  add(link::mav::kDoChangeSpeed, 0, {});
  set_speed(target.speed_mps);
  for (const convert::GlobalPoint& bend : bends) add(link::mav::kNavWaypoint, radius_m, bend);
  add(link::mav::kNavLoiterUnlimited, 0, target.place);
}

void Errand::set_speed(float mps) {
  constexpr float kDefault = -2;
  items_[0].param[1] = mps > 0 ? mps : kDefault;
}

Target Errand::target() const {
  const PlanItem& last = items_[count_ - 1];
  return {{last.x, last.y}, std::max(items_[0].param[1], 0.0F)};
}

}  // namespace flotilla::app
