// SPDX-License-Identifier: MIT
#include "app/propulsion/can_node.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "app/version.hpp"

namespace flotilla::app {
namespace {

constexpr std::uint8_t kCommandPriority = 7, kArmingPriority = 24, kStatusPriority = 20,
                       kAllocationPriority = 30;
constexpr std::int64_t kForeignGone_us = 2'000'000;
constexpr std::int64_t kNodeOffline_us = 3'000'000;
constexpr std::int64_t kButtonGone_us = 500'000, kSafetyGone_us = 2'000'000;
constexpr std::int64_t kObeysAgain_us = 1'000'000;
constexpr std::uint16_t kRunDown_ms = 500, kWindmills_ms = 5'000;
constexpr std::uint8_t kDrives_pct = 5;
constexpr std::int32_t kTurns_rpm = 300;
constexpr float kDraws_A = 0.5F;
constexpr std::uint8_t kHealthOk = 0, kOperational = 0, kFullyArmed = 255;

std::uint32_t uptime_s(std::int64_t since_us, std::int64_t now_us) {
  return static_cast<std::uint32_t>((now_us - since_us) / 1'000'000);
}

bool carries(const link::Route& route, const link::DataType& type) {
  return route.kind == type.kind && route.type == type.id;
}

}  // namespace

void CanNode::on_frame(std::uint32_t can_id, std::span<const std::uint8_t> data,
                       std::int64_t now_us, link::Counters& counters) {
  const auto route = link::route_of(can_id);
  if (!route) {
    ++counters.can_bad_frame;
    return;
  }
  if (carries(*route, link::RawCommand::kType) || carries(*route, link::RpmCommand::kType) ||
      carries(*route, link::ArmingStatus::kType)) {
    foreign_us_ = now_us;  // whatever the content, even under our own node id
  } else if (carries(*route, link::Allocation::kType)) {
    const auto transfer = receiver_.push(*route, link::Allocation::kType, data, now_us, counters);
    const auto request = transfer ? link::read_allocation(transfer->payload) : std::nullopt;
    // Allocations from a node that has an id are the answers of another allocator.
    if (request && route->source == 0) allocation_ = node_ids_.answer(*request, now_us);
  } else if (route->source != 0 && route->source != identity_.node) {
    take(*route, data, now_us, counters);
  }
}

/// A frame of another node.
void CanNode::take(const link::Route& route, std::span<const std::uint8_t> data,
                   std::int64_t now_us, link::Counters& counters) {
  const auto complete = [&](const link::DataType& type) {
    return receiver_.push(route, type, data, now_us, counters);
  };
  if (carries(route, link::EscStatus::kType)) {
    const auto transfer = complete(link::EscStatus::kType);
    const auto status = transfer ? link::read_esc_status(transfer->payload) : std::nullopt;
    if (transfer && !status) ++counters.can_bad_value;
    if (status) take_esc_status(route.source, *status, now_us);
  } else if (carries(route, link::NodeStatus::kType)) {
    const auto transfer = complete(link::NodeStatus::kType);
    const auto status = transfer ? link::read_node_status(transfer->payload) : std::nullopt;
    if (transfer && !status) ++counters.can_bad_value;
    if (status) take_node_status(route.source, *status, now_us);
  } else if (carries(route, link::SafetyState::kType)) {
    const auto transfer = complete(link::SafetyState::kType);
    const auto state = transfer ? link::read_safety_state(transfer->payload) : std::nullopt;
    if (state) take_safety_state(route.source, *state, now_us);
  } else if (carries(route, link::Button::kType)) {
    const auto transfer = complete(link::Button::kType);
    const auto button = transfer ? link::read_button(transfer->payload) : std::nullopt;
    if (button && button->button == link::Button::kSafety) button_us_ = now_us;
  } else if (carries(route, link::NodeInfo::kRequest) && route.destination == identity_.node) {
    const auto transfer = complete(link::NodeInfo::kRequest);
    if (!transfer) return;
    if (pending_count_ == pending_.size()) {
      ++counters.can_not_sent;
    } else {
      pending_[pending_count_++] = {route.source, route.priority, transfer->transfer_id};
    }
  }
}

void CanNode::take_safety_state(std::uint8_t node, const link::SafetyState& state,
                                std::int64_t now_us) {
  const bool off = state.status == link::SafetyState::kOff;
  if (!off) safety_on_us_ = now_us;
  const auto known = std::ranges::find_if(
      switches_, [&](const SafetySwitch& one) { return one.node == node || one.node == 0; });
  if (known == switches_.end()) return;
  known->node = node;
  if (off) known->off_us = now_us;
}

void CanNode::take_esc_status(std::uint8_t node, const link::EscStatus& status,
                              std::int64_t now_us) {
  if (status.esc_index >= escs_.size()) return;
  Esc& esc = escs_[status.esc_index];
  const bool other = esc.node != node && now_us - esc.heard_us < kNodeOffline_us;
  if (other) {
    esc.claimed_us = now_us;
  } else {
    const std::int64_t since_us = now_us - std::exchange(esc.heard_us, now_us);
    esc.node = node;
    esc.status = status;
    judge(esc, since_us);
  }
}

/// Ignores the sign of rpm: many ESCs do not report it.
void CanNode::judge(Esc& esc, std::int64_t since_us) {
  const auto more = [&](std::uint16_t ms) {
    return static_cast<std::uint16_t>(std::min<std::int64_t>(ms + since_us / 1000, kMinute_ms));
  };
  const auto longer = [&](std::uint16_t& ms, bool goes_on) {
    ms = !goes_on ? std::uint16_t{0} : ms == 0 ? std::uint16_t{1} : more(ms);
  };
  const bool zeros = !std::exchange(esc.driven, false);
  esc.zeros_ms = zeros ? more(esc.zeros_ms) : std::uint16_t{0};
  longer(esc.drives_ms, esc.zeros_ms >= kRunDown_ms && esc.status.power_rating_pct >= kDrives_pct);
  // A current of NaN is unknown; an ESC that cannot measure its current may also report 0.
  if (esc.status.current >= kDraws_A) esc.measures_current = true;
  const bool draws_none = esc.measures_current && esc.status.current < kDraws_A;
  longer(esc.turns_ms, zeros && !draws_none && std::abs(esc.status.rpm) >= kTurns_rpm);
  if (std::abs(esc.status.rpm) >= kTurns_rpm) esc.measures_rpm = true;
  longer(esc.obeyed_ms, esc.drives_ms < kRunDown_ms && esc.turns_ms < kWindmills_ms);
}

bool CanNode::escs_obey(std::uint8_t port, std::uint8_t stbd, std::int64_t now_us) const {
  const auto obeys = [&](std::uint8_t index) {
    const Esc& esc = escs_[index % escs_.size()];
    return esc.obeyed_ms * std::int64_t{1000} + now_us - esc.heard_us >= kObeysAgain_us;
  };
  return obeys(port) && obeys(stbd);
}

bool CanNode::rests(std::uint8_t index) const {
  const Esc& esc = escs_[index % escs_.size()];
  return esc.measures_rpm && std::abs(esc.status.rpm) < kTurns_rpm;
}

std::optional<link::EscStatus> CanNode::esc_status(std::uint8_t index, std::int64_t now_us) const {
  const Esc& esc = escs_[index % escs_.size()];
  if (now_us - esc.heard_us > kNodeOffline_us) return std::nullopt;
  return esc.status;
}

void CanNode::take_node_status(std::uint8_t node, const link::NodeStatus& status,
                               std::int64_t now_us) {
  Node& known = nodes_[node];
  // A rebooted ESC must see zeros before it is driven again, so an armed boat has to stop.
  const bool rebooted = known.heard_us != kNever && status.uptime_sec < known.uptime_sec;
  const std::int64_t since_us = rebooted ? 0 : known.since_reboot_us + (now_us - known.heard_us);
  known.since_reboot_us = static_cast<std::uint32_t>(std::min(since_us, kLongAgo_us)) & 0x7FFFFFFFU;
  known.heard_us = now_us;
  known.uptime_sec = status.uptime_sec;
  known.is_well = status.health == kHealthOk && status.mode == kOperational;
  node_ids_.occupied(node);
}

bool CanNode::esc_online(std::uint8_t index, std::int64_t now_us, std::int64_t limit_us) const {
  const Esc& esc = escs_[index % escs_.size()];
  if (now_us - esc.heard_us >= limit_us) return false;
  if (now_us - esc.claimed_us < kNodeOffline_us) return false;
  const Node& node = nodes_[esc.node];
  const std::int64_t silent_us = now_us - node.heard_us;
  if (node.since_reboot_us + silent_us < kLongAgo_us) return false;
  return silent_us < kNodeOffline_us && node.is_well;
}

bool CanNode::stop_pressed(std::int64_t now_us) const {
  return now_us - button_us_ < kButtonGone_us || now_us - safety_on_us_ <= kSafetyGone_us ||
         std::ranges::any_of(
             switches_,
             [&](const SafetySwitch& one) {
               return one.node != 0 && now_us - one.off_us > kSafetyGone_us;
             });
}

bool CanNode::foreign_controller(std::int64_t now_us) const {
  return foreign_us_ && now_us - *foreign_us_ < kForeignGone_us;
}

template <class Message>
void CanNode::put(const Message& message, const link::Route& route, const link::DataType& type,
                  std::uint8_t transfer_id, link::Counters& counters, CanOutput& out) {
  link::Payload payload;
  const std::size_t size = write_payload(message, payload);
  const std::size_t frames =
      link::split_transfer(route, type, transfer_id, std::span(payload).first(size),
                           std::span(out.frames).subspan(out.count));
  out.count += frames;
  if (frames == 0) ++counters.can_not_sent;
}

template <class Message>
void CanNode::send(const Message& message, const link::DataType& type, std::uint8_t priority,
                   std::uint8_t& transfer_id, link::Counters& counters, CanOutput& out) {
  put(message, {priority, type.kind, type.id, identity_.node, 0}, type, transfer_id, counters, out);
  transfer_id = static_cast<std::uint8_t>((transfer_id + 1U) & 0x1FU);
}

void CanNode::answer(const PendingRequest& request, std::int64_t now_us, link::Counters& counters,
                     CanOutput& out) {
  link::NodeInfo info;
  info.status.uptime_sec = uptime_s(*started_us_, now_us);
  info.software_major = kVersionMajor;
  info.software_minor = kVersionMinor;
  info.unique_id[14] = identity_.system;
  info.unique_id[15] = identity_.node;
  info.name = "org.flotilla.autopilot";
  constexpr link::DataType type = link::NodeInfo::kResponse;
  put(info, {request.priority, type.kind, type.id, identity_.node, request.node}, type,
      request.transfer_id, counters, out);
}

void CanNode::send(const link::RawCommand& command, bool armed, std::int64_t now_us,
                   link::Counters& counters, CanOutput& out) {
  if (!started_us_) started_us_ = now_us;
  for (std::size_t i = 0; armed && i < command.count; ++i) {
    if (command.cmd[i] != 0) escs_[i].driven = true;
  }
  // An ESC must hear that it is armed before its first command.
  if (arming_due_.take_if_due(now_us) || armed != armed_) {
    armed_ = armed;
    const link::ArmingStatus arming{armed ? kFullyArmed : std::uint8_t{0}};
    send(arming, link::ArmingStatus::kType, kArmingPriority, arming_id_, counters, out);
  }
  send(command, link::RawCommand::kType, kCommandPriority, command_id_, counters, out);
  if (status_due_.take_if_due(now_us)) {
    link::NodeStatus status;
    status.uptime_sec = uptime_s(*started_us_, now_us);
    send(status, link::NodeStatus::kType, kStatusPriority, status_id_, counters, out);
  }
  for (std::size_t i = 0; i < pending_count_; ++i) answer(pending_[i], now_us, counters, out);
  pending_count_ = 0;
  if (allocation_) {
    send(*allocation_, link::Allocation::kType, kAllocationPriority, allocation_id_, counters, out);
    allocation_.reset();
  }
}

}  // namespace flotilla::app
