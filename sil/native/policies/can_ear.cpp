// SPDX-License-Identifier: MIT
#include "policies/can_ear.hpp"

#include <algorithm>
#include <cstdlib>

#include "link/dronecan/crc16.hpp"
#include "link/dronecan/messages.hpp"

namespace flotilla::policies {
namespace {

constexpr std::uint8_t kStart = 0x80, kEnd = 0x40, kToggle = 0x20, kTransferId = 0x1F;

bool is(std::uint16_t type, const link::DataType& desired) { return type == desired.id; }

/// A RawCommand's i-th value: 14 bits, the low byte first.
std::int16_t command_at(std::span<const std::uint8_t> payload, std::size_t i) {
  const std::size_t bit = 14 * i, at = bit / 8;
  const auto byte = [&](std::size_t k) { return k < payload.size() ? payload[k] : 0U; };
  const unsigned three = byte(at) << 16U | byte(at + 1) << 8U | byte(at + 2);
  const unsigned word = three >> (10U - bit % 8) & 0x3FFFU;
  const unsigned value = (word & 0x3FU) << 8U | word >> 6U;
  return static_cast<std::int16_t>(static_cast<int>(value ^ 0x2000U) - 0x2000);
}

/// Seed of a multi-frame transfer's checksum; 0 for a type that a boat does not send.
std::uint16_t seed_of(const link::Route& route) {
  for (const link::DataType& type : {link::RawCommand::kType, link::Allocation::kType,
                                     link::NodeInfo::kResponse, link::NodeStatus::kType}) {
    if (route.kind == type.kind && route.type == type.id) return type.crc_seed;
  }
  return 0;
}

}  // namespace

void CanEar::hear(std::uint32_t can_id, std::span<const std::uint8_t> data,
                  const app::Parameters& p, Heard& heard) {
  const auto route = link::route_of(can_id);
  if (!route || route->kind != link::TransferKind::kMessage) return;
  heard.stop_switch |=
      is(route->type, link::Button::kType) || is(route->type, link::SafetyState::kType);
  if (is(route->type, link::RawCommand::kType) || is(route->type, link::ArmingStatus::kType)) {
    heard.controller = true;
  } else if (route->source == 0 || route->source == node_) {
    return;
  } else if (is(route->type, link::EscStatus::kType)) {
    hear_esc(route->source, data, p, heard);
  } else if (is(route->type, link::NodeStatus::kType)) {
    hear_node(route->source, data, heard);
  }
}

/// Reads only the last of three frames, which holds the index.
void CanEar::hear_esc(std::uint8_t node, std::span<const std::uint8_t> data,
                      const app::Parameters& p, Heard& heard) {
  if (data.size() != 3 || (data[2] & kEnd) == 0) return;
  const auto index = static_cast<float>(data[1] >> 2U & 0x1FU);
  for (const std::size_t esc : {0U, 1U}) {
    if (index != (esc == 0 ? p.ESC_PORT : p.ESC_STBD)) continue;
    heard.escs[esc] = true;
    if (escs_[esc].node != node) escs_[esc] = {node, false, 0};
  }
}

void CanEar::hear_node(std::uint8_t node, std::span<const std::uint8_t> data, Heard& heard) {
  constexpr std::size_t kWhole = 8;
  if (data.size() != kWhole || (data[7] & (kStart | kEnd | kToggle)) != (kStart | kEnd)) return;
  const std::uint32_t uptime_s = data[0] | std::uint32_t{data[1]} << 8U |
                                 std::uint32_t{data[2]} << 16U | std::uint32_t{data[3]} << 24U;
  for (Esc& esc : escs_) {
    if (esc.node != node) continue;
    heard.rebooted = heard.rebooted || (esc.counts && uptime_s < esc.uptime_s);
    esc.counts = true;
    esc.uptime_s = uptime_s;
  }
}

void CanEar::read(std::span<const link::CanFrame> frames, const app::Parameters& p, Moment& n) {
  Part part;
  n.port = n.stbd = 0;
  n.bus.frames = static_cast<std::uint8_t>(std::min<std::size_t>(frames.size(), 255));
  for (const link::CanFrame& frame : frames) {
    if (frame.size == 0 || frame.size > 8) {
      n.bus.whole = false;
      continue;
    }
    n.bus.ours = n.bus.ours && (frame.id & 0x7FU) == node_;
    const std::uint8_t tail = frame.data[frame.size - 1U];
    const auto transfer_id = static_cast<std::uint8_t>(tail & kTransferId);
    if ((tail & (kStart | kEnd | kToggle)) == (kStart | kEnd)) {
      n.bus.whole = n.bus.whole && part.size == 0;
      take(frame.id, transfer_id, frame.bytes().first(frame.size - 1U), p, n);
    } else if (!join(frame, part)) {
      n.bus.whole = false;
      part.size = 0;
    } else if ((tail & kEnd) != 0) {
      const auto payload = std::span(part.bytes).first(part.size).subspan(2);
      const auto route = link::route_of(frame.id);
      const std::uint16_t crc = route ? link::crc16(seed_of(*route), payload) : 0;
      n.bus.whole = n.bus.whole && part.bytes[0] == (crc & 0xFFU) && part.bytes[1] == crc >> 8U;
      take(frame.id, transfer_id, payload, p, n);
      part.size = 0;
    }
  }
  n.bus.whole = n.bus.whole && part.size == 0;
}

/// Whether the frame continues the transfer.
bool CanEar::join(const link::CanFrame& frame, Part& part) const {
  const std::size_t size = frame.size - 1U;
  const std::uint8_t tail = frame.data[size];
  if ((tail & kStart) != 0) {
    if (part.size != 0 || (tail & kToggle) != 0 || size < 2) return false;
    part.id = frame.id;
  } else if (part.size == 0 || frame.id != part.id ||
             (tail & kTransferId) != (part.tail & kTransferId) ||
             (tail & kToggle) == (part.tail & kToggle) || part.size + size > part.bytes.size()) {
    return false;
  }
  std::copy_n(frame.data.begin(), size,
              part.bytes.begin() + static_cast<std::ptrdiff_t>(part.size));
  part.size += size;
  part.tail = tail;
  return true;
}

bool CanEar::counts_on(Next& next, std::uint8_t transfer_id) {
  const bool good = !next.known || transfer_id == next.id;
  next = {true, static_cast<std::uint8_t>((transfer_id + 1U) & kTransferId)};
  return good;
}

void CanEar::take(std::uint32_t can_id, std::uint8_t transfer_id,
                  std::span<const std::uint8_t> payload, const app::Parameters& p, Moment& n) {
  OnBus& bus = n.bus;
  const bool message = (can_id & 0x80U) == 0;
  const auto type = static_cast<std::uint16_t>(can_id >> 8U & 0xFFFFU);
  if (message && is(type, link::RawCommand::kType)) {
    const auto port = static_cast<std::size_t>(p.ESC_PORT),
               stbd = static_cast<std::size_t>(p.ESC_STBD);
    bus.commands++;
    bus.counted &= counts_on(command_, transfer_id);
    bus.size = static_cast<std::uint8_t>(payload.size() * 8 / 14);
    for (std::size_t i = 0; i < bus.size; ++i) {
      const std::int16_t command = command_at(payload, i);
      bus.loudest = std::max(bus.loudest, static_cast<std::int16_t>(std::abs(command)));
      if (i == port) {
        n.port = command;
      } else if (i == stbd) {
        n.stbd = command;
      } else {
        bus.strangers_idle &= command == 0;
      }
    }
  } else if (message && is(type, link::ArmingStatus::kType)) {
    bus.armings++;
    bus.counted = bus.counted && counts_on(arming_, transfer_id);
    bus.told_before = bus.told_before && bus.commands == 0;
    n.arming = payload.size() == 1 ? payload[0] : std::uint8_t{1};
    n.arming_us = n.now_us;
  } else if (message && is(type, link::NodeStatus::kType)) {
    const auto status = link::read_node_status(payload);
    bus.statuses++;
    bus.counted = bus.counted && counts_on(status_, transfer_id);
    n.uptime_s = status ? status->uptime_sec : 0;
    n.health = static_cast<std::uint8_t>(status ? status->health << 3U | status->mode : 255);
    n.status_us = n.now_us;
  } else {
    bus.others++;
  }
}

}  // namespace flotilla::policies
