// SPDX-License-Identifier: MIT
#include "app/operator/requests/rc_pilots.hpp"

#include <algorithm>
#include <span>

namespace flotilla::app {

bool RcPilots::take(std::size_t link, const link::Received& received, const Rules& rules,
                    Supervisor& supervisor, std::int64_t now_us) {
  RcInput* input = &transmitter_;
  std::uint8_t sender = 0;
  std::span<const std::uint16_t> pulses_us;
  if (const auto* rc = std::get_if<link::RcChannels>(&received.message)) {
    if (received.from.system != rules.own_system) return true;
    sender = received.from.component;
    if (!transmitter_.hears(sender, now_us)) return true;
    pulses_us = std::span(rc->pulses).first(std::min<std::size_t>(rc->chancount, 16));
  } else if (const auto* given = std::get_if<link::RcChannelsOverride>(&received.message)) {
    if (!rules.mode_switch || !rules.may_override) return false;
    sender = received.from.system;
    if (!overrides_.hears(sender, now_us)) return true;
    if (!overrides_link_.accept(received.from, link, now_us)) return true;
    input = &overrides_;
    pulses_us = given->pulses;
  } else {
    const auto* status = std::get_if<link::SysStatus>(&received.message);
    if (status != nullptr && received.from.system == rules.own_system) {
      transmitter_.judge(received.from.component, *status);
    }
    return false;
  }
  const auto channel = rules.mode_switch;
  if (!channel || !input->hear(pulses_us, *channel, supervisor.state(), now_us, sender)) {
    return true;
  }
  const bool yields = input == &overrides_ && transmitter_.pilots(now_us);
  if (const auto sticks = input->sticks(); sticks && !yields) {
    supervisor.take_sticks(*sticks, received.from, now_us, true);
  }
  return true;
}

std::optional<core::Request> RcPilots::take_request(core::State state, std::int64_t now_us) {
  const auto overrides = overrides_.take_request(state, now_us);
  const auto asked = transmitter_.take_request(state, now_us);
  return asked || transmitter_.pilots(now_us) ? asked : overrides;
}

}  // namespace flotilla::app
