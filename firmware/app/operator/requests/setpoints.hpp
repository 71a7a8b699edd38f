// SPDX-License-Identifier: MIT
// Recent senders of setpoints: PX4 clients send some before they request OFFBOARD.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "link/mavlink/address.hpp"

namespace flotilla::app {

class Setpoints {
 public:
  /// SET_ATTITUDE_TARGET, SET_POSITION_TARGET_LOCAL_NED and _GLOBAL_INT, SET_ACTUATOR_CONTROL_TARGET.
  static constexpr bool is_one(std::uint32_t id) {
    return id == 82 || id == 84 || id == 86 || id == 139;
  }

  void heard(link::Address from, std::int64_t now_us) {
    auto* const known = std::ranges::find(senders_, from.system, &Sender::system);
    *(known == senders_.end() ? std::ranges::min_element(senders_, {}, &Sender::heard_us)
                              : known) = {from.system, now_us};
  }

  /// Whether any component of that system has sent one in the last five seconds.
  bool come_from(link::Address from, std::int64_t now_us) const {
    return std::ranges::any_of(senders_, [&](const Sender& sender) {
      return sender.system == from.system && now_us - sender.heard_us < kRecent_us;
    });
  }

 private:
  static constexpr std::int64_t kRecent_us = 5'000'000;
  struct Sender {
    std::uint8_t system = 0;
    std::int64_t heard_us = -kRecent_us;
  };

  std::array<Sender, 4> senders_{};
};

}  // namespace flotilla::app
