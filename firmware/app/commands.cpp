// SPDX-License-Identifier: MIT
#include "app/commands.hpp"

#include <cmath>

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::Request;

constexpr float kForce = 21196;

bool is_disarm(const link::CommandLong& c) {
  return c.command == mav::kCmdComponentArmDisarm && c.param[0] == 0.0F;
}

/// Unused parameters come as 0 or NaN; force is understood, and overrides no check.
Asked arm_or_disarm(const link::CommandLong& c) {
  if (c.param[0] == 0.0F) return {Request::kDisarm, mav::kAccepted};
  const bool force_is_legal = std::isnan(c.param[1]) || c.param[1] == 0.0F || c.param[1] == kForce;
  if (c.param[0] == 1.0F && force_is_legal) return {Request::kArm, mav::kAccepted};
  return {Request::kNone, mav::kDenied};
}

Asked set_mode(const link::CommandLong& c) {
  const float base = c.param[0];
  const bool custom =
      base >= 0.0F && base < 256.0F && (static_cast<unsigned>(base) & mav::kModeFlagCustom) != 0;
  if (custom && c.param[1] == static_cast<float>(mode::kHold))
    return {Request::kHold, mav::kAccepted};
  if (custom && c.param[1] == static_cast<float>(mode::kFormation))
    return {Request::kFormation, mav::kAccepted};
  return {Request::kNone, mav::kDenied};
}

Asked storage(const link::CommandLong& c) {
  if (c.param[0] == 1.0F) return {Request::kNone, mav::kAccepted, true};
  return {Request::kNone, mav::kDenied};
}

}  // namespace

void CommandQueue::push(const PendingCommand& pending, link::Counters& counters) {
  if (count_ < queue_.size()) {
    queue_[count_++] = pending;
    return;
  }
  ++counters.commands_dropped;
  if (is_disarm(pending.command)) queue_.back() = pending;  // which always works
}

Asked meaning_of(const PendingCommand& pending, const Parameters& p) {
  const bool stranger =
      p.MAV_GCS_SYSID != 0.0F && static_cast<float>(pending.from.system) != p.MAV_GCS_SYSID;
  if (stranger && !is_disarm(pending.command)) {
    return {Request::kNone, mav::kDenied};
  }
  switch (pending.command.command) {
    case mav::kCmdComponentArmDisarm:
      return arm_or_disarm(pending.command);
    case mav::kCmdDoSetMode:
      return set_mode(pending.command);
    case mav::kCmdPreflightStorage:
      return storage(pending.command);
    default:
      return {Request::kNone, mav::kUnsupported};
  }
}

bool addressed_to(const link::CommandLong& command, const Parameters& p) {
  const auto fits = [](std::uint8_t target, float self) {
    return target == 0 || static_cast<float>(target) == self;
  };
  return fits(command.target.system, p.MAV_SYSID) && fits(command.target.component, p.MAV_COMPID);
}

}  // namespace flotilla::app
