// SPDX-License-Identifier: MIT
// Which system is behind which link, so that what is addressed to it can be handed on.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "app/mavlink_links.hpp"
#include "link/messages.hpp"

namespace flotilla::app {

/// Only messages that name a system are handed on, unchanged. Broadcasts are not: a navigation
/// unit's hundred states a second would drown a radio, and what others need of them the boat says
/// itself. Nor is what its addressee hears anyway, on the link that the message came by: nothing
/// circles where two links reach the same boats. Source: mavlink.io, routing.
class Router {
 public:
  explicit Router(std::size_t links = kMaxLinks)
      : links_(links), heard_us_(links * kPlaces, kNever) {}

  void heard(link::Address from, std::size_t link, std::int64_t now_us) {
    std::size_t place = 0;
    while (place < used_ && who_[place] != from) ++place;
    if (place == used_) {
      place = used_ < kPlaces ? used_++ : unheard_longest();
      who_[place] = from;
      std::ranges::fill(row(place), kNever);
    }
    row(place)[link] = now_us;
  }

  /// Links, a bit each, that a message from one link is to be handed on to.
  std::uint8_t beyond(link::Address target, std::size_t from_link, std::int64_t now_us) const {
    if (target.system == 0) return 0;
    unsigned links = 0;
    for (std::size_t place = 0; place < used_; ++place) {
      const link::Address who = who_[place];
      const bool meant = who.system == target.system &&
                         (target.component == 0 || who.component == target.component);
      for (std::size_t link = 0; meant && link < row(place).size(); ++link) {
        if (now_us - kGone_us < row(place)[link]) links |= 1U << link;
      }
    }
    return (links >> from_link & 1U) != 0 ? std::uint8_t{0} : static_cast<std::uint8_t>(links);
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::int64_t kGone_us = 10'000'000;
  static constexpr std::size_t kPlaces = 32;

  /// When that place's owner was heard last on each link.
  std::span<std::int64_t> row(std::size_t place) {
    return std::span(heard_us_).subspan(place * links_, links_);
  }
  std::span<const std::int64_t> row(std::size_t place) const {
    return std::span(heard_us_).subspan(place * links_, links_);
  }
  std::int64_t last_us(std::size_t place) const { return std::ranges::max(row(place)); }

  std::size_t unheard_longest() const {
    std::size_t longest = 0;
    for (std::size_t place = 1; place < kPlaces; ++place) {
      if (last_us(place) < last_us(longest)) longest = place;
    }
    return longest;
  }

  std::size_t links_, used_ = 0;
  std::array<link::Address, kPlaces> who_{};  // the one unheard for longest gives way
  std::vector<std::int64_t> heard_us_;
};

}  // namespace flotilla::app
