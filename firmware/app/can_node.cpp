// SPDX-License-Identifier: MIT
#include "app/can_node.hpp"

#include "app/version.hpp"

namespace flotilla::app {
namespace {

constexpr std::uint8_t kCommandPriority = 7, kArmingPriority = 24, kStatusPriority = 20;
constexpr std::int64_t kNodeOffline_us = 3'000'000;
constexpr std::uint8_t kHealthOk = 0, kFullyArmed = 255;

std::uint32_t uptime_s(std::int64_t since_us, std::int64_t now_us) {
  return static_cast<std::uint32_t>((now_us - since_us) / 1'000'000);
}

}  // namespace

void CanNode::on_frame(std::uint32_t can_id, std::span<const std::uint8_t> data,
                       std::int64_t now_us, link::Counters& counters) {
  const auto route = link::route_of(can_id);
  if (!route) {
    ++counters.can_bad_frame;
    return;
  }
  if (route->source == 0 || route->source == identity_.node) return;
  const auto is = [&](const link::DataType& type) {
    return route->kind == type.kind && route->type == type.id;
  };
  const auto complete = [&](const link::DataType& type) {
    return receiver_.push(*route, type, data, now_us, counters);
  };
  if (is(link::EscStatus::kType)) {
    const auto transfer = complete(link::EscStatus::kType);
    if (!transfer) return;
    const auto status = link::read_esc_status(transfer->payload);
    if (!status) {
      ++counters.can_bad_value;
      return;
    }
    escs_[status->esc_index] = {now_us, route->source};
  } else if (is(link::NodeStatus::kType)) {
    const auto transfer = complete(link::NodeStatus::kType);
    if (!transfer) return;
    const auto status = link::read_node_status(transfer->payload);
    if (!status) {
      ++counters.can_bad_value;
      return;
    }
    nodes_[route->source] = {now_us, status->health};
  } else if (is(link::NodeInfo::kRequest) && route->destination == identity_.node) {
    if (const auto transfer = complete(link::NodeInfo::kRequest)) {
      question_ = {route->source, route->priority, transfer->transfer_id};
    }
  }
}

bool CanNode::esc_online(std::uint8_t index, std::int64_t now_us, std::int64_t limit_us) const {
  const Esc& esc = escs_[index % escs_.size()];
  if (!esc.heard_us || now_us - *esc.heard_us >= limit_us) return false;
  const Node& node = nodes_[esc.node];
  return node.heard_us && now_us - *node.heard_us < kNodeOffline_us && node.health == kHealthOk;
}

template <class Message>
void CanNode::send(const Message& message, const link::DataType& type, std::uint8_t priority,
                   std::uint8_t& transfer_id, link::Counters& counters, CanOutput& out) {
  link::Payload payload;
  const std::size_t size = write_payload(message, payload);
  const link::Route route{priority, type.kind, type.id, identity_.node, 0};
  const std::size_t frames =
      link::split_transfer(route, type, transfer_id, std::span(payload).first(size),
                           std::span(out.frames).subspan(out.count));
  out.count += frames;
  if (frames == 0) ++counters.can_not_sent;
  transfer_id = static_cast<std::uint8_t>((transfer_id + 1U) & 0x1FU);
}

void CanNode::answer(std::int64_t now_us, link::Counters& counters, CanOutput& out) {
  link::NodeInfo info;
  info.status.uptime_sec = uptime_s(*started_us_, now_us);
  info.software_major = kVersionMajor;
  info.software_minor = kVersionMinor;
  info.unique_id[14] = identity_.system;
  info.unique_id[15] = identity_.node;
  info.name = "org.flotilla.autopilot";
  link::Payload payload;
  const std::size_t size = write_payload(info, payload);
  const link::Route route{question_->priority, link::NodeInfo::kResponse.kind,
                          link::NodeInfo::kResponse.id, identity_.node, question_->node};
  const std::size_t frames = link::split_transfer(
      route, link::NodeInfo::kResponse, question_->transfer_id, std::span(payload).first(size),
      std::span(out.frames).subspan(out.count));
  out.count += frames;
  if (frames == 0) ++counters.can_not_sent;
  question_.reset();
}

void CanNode::send(const link::RawCommand& command, bool armed, std::int64_t now_us,
                   link::Counters& counters, CanOutput& out) {
  if (!started_us_) started_us_ = now_us;
  send(command, link::RawCommand::kType, kCommandPriority, command_id_, counters, out);
  if (arming_due_.due(now_us) || armed != armed_) {
    armed_ = armed;
    const link::ArmingStatus arming{armed ? kFullyArmed : std::uint8_t{0}};
    send(arming, link::ArmingStatus::kType, kArmingPriority, arming_id_, counters, out);
  }
  if (status_due_.due(now_us)) {
    link::NodeStatus status;
    status.uptime_sec = uptime_s(*started_us_, now_us);
    send(status, link::NodeStatus::kType, kStatusPriority, status_id_, counters, out);
  }
  if (question_) answer(now_us, counters, out);
}

}  // namespace flotilla::app
