// SPDX-License-Identifier: MIT
// Learns which system is behind which link, to forward messages addressed to it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "link/mavlink/messages.hpp"

namespace flotilla::app {

/// Forwards only messages that name a target system, unchanged. Broadcasts are not forwarded: a
/// navigation unit's hundred states a second would saturate a radio, and the boat itself sends what
/// others need of them. A message is not forwarded if its target is also on the link it came from,
/// so nothing circulates where two links reach the same boats. Source: mavlink.io, routing.
class Router {
 public:
  static constexpr std::size_t kPlaces = 32;

  /// State of one link: when each known address was last heard on it.
  struct Link {
    std::array<std::int64_t, kPlaces> heard_us;
  };

  /// links: one element for each link; must outlive this object.
  explicit Router(std::span<Link> links) : links_(links) {}

  void heard(link::Address from, std::size_t link, std::int64_t now_us) {
    std::size_t place = 0;
    while (place < used_ && who_[place] != from) ++place;
    if (place == used_) {
      place = used_ < kPlaces ? used_++ : unheard_longest();
      who_[place] = from;
      for (Link& each : links_) each.heard_us[place] = kNever;
    }
    links_[link].heard_us[place] = now_us;
  }

  /// Links, a bit each, that a message from `from_link` is forwarded to.
  std::uint8_t beyond(link::Address target, std::size_t from_link, std::int64_t now_us) const {
    const std::uint8_t links = links_to(target, now_us);
    return (links >> from_link & 1U) != 0 ? std::uint8_t{0} : links;
  }

  /// Links, a bit each, on which the target was heard within 10 s; component 0: any component.
  std::uint8_t links_to(link::Address target, std::int64_t now_us) const {
    if (target.system == 0) return 0;
    unsigned links = 0;
    for (std::size_t place = 0; place < used_; ++place) {
      const link::Address who = who_[place];
      const bool meant = who.system == target.system &&
                         (target.component == 0 || who.component == target.component);
      for (std::size_t link = 0; meant && link < links_.size(); ++link) {
        if (now_us - kGone_us < links_[link].heard_us[place]) links |= 1U << link;
      }
    }
    return static_cast<std::uint8_t>(links);
  }

 private:
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min() / 2;
  static constexpr std::int64_t kGone_us = 10'000'000;

  std::int64_t last_us(std::size_t place) const {
    std::int64_t last = kNever;
    for (const Link& link : links_) last = std::max(last, link.heard_us[place]);
    return last;
  }

  std::size_t unheard_longest() const {
    std::size_t longest = 0;
    for (std::size_t place = 1; place < kPlaces; ++place) {
      if (last_us(place) < last_us(longest)) longest = place;
    }
    return longest;
  }

  std::size_t used_ = 0;
  std::array<link::Address, kPlaces> who_{};  // when full, replaces the one silent for longest
  std::span<Link> links_;
};

}  // namespace flotilla::app
