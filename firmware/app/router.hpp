// SPDX-License-Identifier: MIT
// Which system is behind which link, so that what is addressed to it can be handed on.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "app/mavlink_links.hpp"
#include "link/messages.hpp"

namespace flotilla::app {

/// Only messages that name a system are handed on, unchanged. Broadcasts are not: a navigation
/// unit's hundred states a second would drown a radio, and what others need of them the boat says
/// itself. Nor is what its addressee hears anyway, on the link that the message came by: nothing
/// circles where two links reach the same boats. Source: mavlink.io, routing.
class Router {
 public:
  void heard(link::Address from, std::size_t link, std::int64_t now_us) {
    Place* free = &places_[0];
    for (Place& place : places_) {
      if (place.who == from && place.last_us() != kNever) {
        place.heard_us[link] = now_us;
        return;
      }
      if (place.last_us() < free->last_us()) free = &place;
    }
    *free = Place{};
    free->who = from;
    free->heard_us[link] = now_us;
  }

  /// Links, a bit each, that a message from one link is to be handed on to.
  std::uint8_t beyond(link::Address target, std::size_t from_link, std::int64_t now_us) const {
    if (target.system == 0) return 0;
    unsigned links = 0;
    for (const Place& place : places_) {
      const bool meant = place.who.system == target.system &&
                         (target.component == 0 || place.who.component == target.component);
      for (std::size_t link = 0; meant && link < kMaxLinks; ++link) {
        if (now_us - kGone_us < place.heard_us[link]) links |= 1U << link;
      }
    }
    return (links >> from_link & 1U) != 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(links);
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::int64_t kGone_us = 10'000'000;

  struct Place {
    Place() { heard_us.fill(kNever); }
    std::int64_t last_us() const { return *std::max_element(heard_us.begin(), heard_us.end()); }

    link::Address who{};
    std::array<std::int64_t, kMaxLinks> heard_us;
  };

  std::array<Place, 32> places_{};  // the one unheard for longest gives way
};

}  // namespace flotilla::app
