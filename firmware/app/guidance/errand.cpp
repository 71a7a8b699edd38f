// SPDX-License-Identifier: MIT
#include "app/guidance/errand.hpp"

namespace flotilla::app {

void Errand::sail_to(const Target& target) {
  constexpr float kDefault = -2;
  items_ = {};
  items_[0].command = link::mav::kDoChangeSpeed;
  items_[0].param[1] = target.speed_mps > 0 ? target.speed_mps : kDefault;
  items_[1].command = link::mav::kNavLoiterUnlimited;
  items_[1].x = target.place.latitude;
  items_[1].y = target.place.longitude;
}

}  // namespace flotilla::app
