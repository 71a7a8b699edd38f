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
    std::size_t place = 0;
    while (place < used_ && who_[place] != from) ++place;
    if (place == used_) {
      place = used_ < kPlaces ? used_++ : unheard_longest();
      who_[place] = from;
      heard_us_[place].fill(kNever);
    }
    heard_us_[place][link] = now_us;
  }

  /// Links, a bit each, that a message from one link is to be handed on to.
  std::uint8_t beyond(link::Address target, std::size_t from_link, std::int64_t now_us) const {
    if (target.system == 0) return 0;
    unsigned links = 0;
    for (std::size_t place = 0; place < used_; ++place) {
      const link::Address who = who_[place];
      const bool meant = who.system == target.system &&
                         (target.component == 0 || who.component == target.component);
      for (std::size_t link = 0; meant && link < kMaxLinks; ++link) {
        if (now_us - kGone_us < heard_us_[place][link]) links |= 1U << link;
      }
    }
    return (links >> from_link & 1U) != 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(links);
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::int64_t kGone_us = 10'000'000;
  static constexpr std::size_t kPlaces = 32;

  std::int64_t last_us(std::size_t place) const { return std::ranges::max(heard_us_[place]); }

  std::size_t unheard_longest() const {
    std::size_t longest = 0;
    for (std::size_t place = 1; place < kPlaces; ++place) {
      if (last_us(place) < last_us(longest)) longest = place;
    }
    return longest;
  }

  std::size_t used_ = 0;
  std::array<link::Address, kPlaces> who_{};  // the one unheard for longest gives way
  /// When each place's owner was heard last on each link.
  std::array<std::array<std::int64_t, kMaxLinks>, kPlaces> heard_us_{};
};

}  // namespace flotilla::app
