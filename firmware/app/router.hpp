// SPDX-License-Identifier: MIT
// Which system is behind which link, so that what is addressed to it can be handed on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "link/messages.hpp"

namespace flotilla::app {

/// Only messages that name a system are handed on, unchanged. Broadcasts are not: a navigation
/// unit's hundred states a second would drown a radio, and what others need of them the boat says
/// itself. Nor is what its addressee hears anyway, on the link that the message came by: nothing
/// circles where two links reach the same boats. Source: mavlink.io, routing.
class Router {
 public:
  void heard(link::Address from, std::size_t link) {
    Place* free = &places_[0];
    for (Place& place : places_) {
      if (place.links != 0 && place.who == from) {
        place.links = static_cast<std::uint8_t>(place.links | bit(link));
        place.last = ++clock_;
        return;
      }
      if (place.last < free->last) free = &place;
    }
    *free = {from, bit(link), ++clock_};
  }

  /// Links, a bit each, that a message from one link is to be handed on to.
  std::uint8_t beyond(link::Address target, std::size_t from_link) const {
    if (target.system == 0) return 0;
    std::uint8_t links = 0;
    for (const Place& place : places_) {
      const bool meant = place.who.system == target.system &&
                         (target.component == 0 || place.who.component == target.component);
      if (meant) links = static_cast<std::uint8_t>(links | place.links);
    }
    return (links & bit(from_link)) != 0 ? 0 : links;
  }

 private:
  struct Place {
    link::Address who{};
    std::uint8_t links = 0;
    std::uint32_t last = 0;
  };

  static constexpr std::uint8_t bit(std::size_t link) {
    return static_cast<std::uint8_t>(1U << link);
  }

  std::array<Place, 32> places_{};  // the one unheard for longest gives way
  std::uint32_t clock_ = 0;
};

}  // namespace flotilla::app
