// SPDX-License-Identifier: MIT
#include "app/plan/errands.hpp"

namespace flotilla::app {
namespace {

constexpr std::string_view kNoWay = "no path inside the fence: boat waits";

}  // namespace

void Errands::sail_to(const Target& target) {
  way_round_.stop();
  errand_.sail_to(target);
}

void Errands::sail_round(const Fence& fence, const convert::Position& here, const Target& target,
                         const Target& meanwhile, float margin_m) {
  if (!look_again(fence, here, target, margin_m)) errand_.sail_to(meanwhile);
}

bool Errands::look_again(const Fence& fence, const convert::Position& here, const Target& target,
                         float margin_m) {
  const bool straight = fence.is_straight(here, target.place, margin_m);
  if (straight) {
    sail_to(target);
  } else {
    way_round_.begin(fence, here, target, margin_m);
    if (is_lost()) news_ = kNoWay;
  }
  return straight;
}

bool Errands::leads_to(const convert::GlobalPoint& place) const {
  const convert::GlobalPoint end = goal().place;
  return end.latitude == place.latitude && end.longitude == place.longitude;
}

bool Errands::look_for_way(const Fence& fence) {
  if (!way_round_.is_searching()) return false;
  way_round_.forward(fence);
  if (way_round_.is_searching()) return false;
  const bool free = way_round_.straight_is_free(fence);
  if (way_round_.found()) {
    news_ = free ? "straight path too near the fence: detour"
                 : "straight path crosses the fence: detour";
    errand_ = way_round_.errand(fence);
  } else if (free) {
    news_ = "no detour found: sailing straight, near the fence";
    sail_to(way_round_.goal());
  } else {
    news_ = kNoWay;
    return false;
  }
  return true;
}

}  // namespace flotilla::app
