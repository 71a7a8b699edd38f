// SPDX-License-Identifier: MIT
#include "app/operator/requests/rc_input.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace flotilla::app {
namespace {

using core::Request;
using core::State;

constexpr std::size_t kSteering = 0, kThrottle = 2;
constexpr std::uint16_t kSwitchedOn_us = 1700;
// A throttle below this shows that the receiver has lost its transmitter, as with ArduPilot's
// FS_THR_VALUE (910 to 1100). A transmitter's full travel ends at 988.
constexpr std::uint16_t kLostThrottle_us = 975;
constexpr double kMoved = 0.3;
constexpr std::int64_t kSilent_us = 500'000;

bool is_pulse(std::uint16_t us) { return us >= 800 && us <= 2200; }

bool is_neutral(std::uint16_t us) { return us >= 1380 && us <= 1620; }  // as kMoved

double share_of(std::uint16_t us) { return std::clamp((us - 1500) / 400.0, -1.0, 1.0); }

}  // namespace

bool RcInput::hears(std::uint8_t sender, std::int64_t now_us) const {
  const bool free = sender_ == 0 || is_lost(sender_) || !is_heard(now_us);
  return (sender == sender_ || free) && !is_lost(sender);
}

bool RcInput::hear(std::span<const std::uint16_t> pulses_us, std::uint8_t switch_channel,
                   State state, std::int64_t now_us, std::uint8_t sender) {
  const std::size_t needed = std::max<std::size_t>(kThrottle + 1, switch_channel);
  if (pulses_us.size() < needed || switch_channel == 0) return false;
  const std::uint16_t turned = pulses_us[switch_channel - 1U];
  const std::uint16_t steering = pulses_us[kSteering], throttle = pulses_us[kThrottle];
  const bool lost = throttle < kLostThrottle_us;
  if (!is_pulse(turned) || !is_pulse(steering) || !is_pulse(throttle) || lost) return false;
  if (sender != sender_) *this = RcInput(sender, lost_);
  pilots_ = pilots(now_us);
  heard_us_ = now_us;
  sticks_ = {share_of(throttle), share_of(steering)};
  neutral_ = is_neutral(throttle) && is_neutral(steering);
  const bool was_on = std::exchange(on_, turned > kSwitchedOn_us), law = core::law_drives(state);
  if (!std::exchange(resting_, law)) rest_ = sticks_;
  const bool moved =
      std::max(std::abs(sticks_.surge - rest_.surge), std::abs(sticks_.yaw - rest_.yaw)) > kMoved;
  if (on_ || (law && moved)) {
    pilots_ = true;
    if (law) asks_ = Request::kManual;
  } else if (was_on || state != State::kManual) {
    if (pilots_ && state == State::kManual) asks_ = Request::kHold;
    pilots_ = false;
  }
  return true;
}

void RcInput::judge(std::uint8_t component, const link::SysStatus& status) {
  constexpr std::uint32_t kReceiver = link::mav::kSensorRcReceiver;
  if ((status.sensors_present & kReceiver) == 0) return;
  const bool lost = (status.sensors_enabled & ~status.sensors_health & kReceiver) != 0;
  if (lost == is_lost(component)) return;
  if (lost) {
    lost_.components[lost_.next++ % lost_.components.size()] = component;
  } else {
    std::ranges::replace(lost_.components, component, std::uint8_t{0});
  }
}

// Not inlined, and take_request() neither: saves 64 bytes of a microcontroller's flash.
[[gnu::noinline]] bool RcInput::is_heard(std::int64_t now_us) const {
  return now_us - heard_us_ < kSilent_us;
}

bool RcInput::pilots(std::int64_t now_us) const { return pilots_ && is_heard(now_us); }

[[gnu::noinline]] std::optional<Request> RcInput::take_request(State state, std::int64_t now_us) {
  auto asked = std::exchange(asks_, std::nullopt);
  const bool drives = core::law_drives(state);
  if (holds(now_us)) {
    if (drives || state == State::kHold) return Request::kManual;
    if (state == State::kTest) return Request::kHold;
  }
  // A moved stick overrules the law, but not an operator's stop in the same tick.
  if (asked == Request::kManual && !drives) asked.reset();
  return asked;
}

}  // namespace flotilla::app
