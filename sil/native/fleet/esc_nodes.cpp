// SPDX-License-Identifier: MIT
#include "fleet/esc_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "link/dronecan/crc16.hpp"
#include "link/dronecan/float16.hpp"
#include "link/dronecan/messages.hpp"

namespace flotilla::fleet {
namespace {

constexpr std::int64_t kCommandTimeout_us = 250'000, kArmingTimeout_us = 500'000;
constexpr double kEscStatus_Hz = 25.0, kFullScale = 8191.0;
constexpr std::uint8_t kFullyArmed = 255, kTransferId = 0x1F;
constexpr std::uint8_t kNodeStatusPriority = 20, kEscStatusPriority = 16;
constexpr std::size_t kLongestRawCommand = 35;
constexpr std::array<std::uint8_t, EscNodes::kEscs> kNodes{21, 22};

constexpr std::uint16_t kRawCommandSeed = link::RawCommand::kType.crc_seed,
                        kArmingStatusSeed = link::ArmingStatus::kType.crc_seed,
                        kNodeInfoSeed = link::NodeInfo::kRequest.crc_seed;

/// The bits of an identifier that are neither priority nor source.
constexpr std::uint32_t subject(const link::DataType& type, std::uint8_t destination = 0) {
  if (type.kind == link::TransferKind::kMessage) return std::uint32_t{type.id} << 8U;
  return std::uint32_t{type.id} << 16U | 0x8000U | std::uint32_t{destination} << 8U | 0x80U;
}

/// The constant part of esc.Status: no errors, a battery of 24 V, current and temperature NaN.
constexpr std::array<std::uint8_t, 10> kStatusHead{0, 0, 0, 0, 0x00, 0x4E, 0x00, 0x7E, 0x00, 0x7E};
constexpr std::uint16_t kStatusHeadCrc = link::crc16(link::EscStatus::kType.crc_seed, kStatusHead);

/// Returns a publisher's transfer id and advances it.
std::uint8_t next(std::uint8_t& id) {
  return std::exchange(id, static_cast<std::uint8_t>((id + 1U) & kTransferId));
}

std::uint32_t uptime_s(std::int64_t boot_us, std::int64_t now_us) {
  return static_cast<std::uint32_t>(
      std::clamp<std::int64_t>((now_us - boot_us) / 1'000'000, 0, 0xFFFFFFFF));
}

std::uint8_t low_byte(unsigned bits) { return static_cast<std::uint8_t>(bits & 0xFFU); }

/// rpm: 18 bits, signed; power: 7 bits; index: 5 bits.
std::array<std::uint8_t, 4> status_tail(double rpm, double power_pct, unsigned index) {
  const double whole = std::isnan(rpm) ? 0.0 : std::clamp(std::nearbyint(rpm), -131072.0, 131071.0);
  const auto bits = static_cast<unsigned>(static_cast<std::int32_t>(whole));
  const auto power = static_cast<unsigned>(std::nearbyint(power_pct));
  return {low_byte(bits), low_byte(bits >> 8U), low_byte((bits >> 10U & 0xC0U) | power >> 1U),
          low_byte((power & 1U) << 7U | std::min(index, 31U) << 2U)};
}

}  // namespace

EscNodes::EscNodes(std::array<std::uint8_t, kEscs> esc_indices)
    : escs_{Esc{esc_indices[0]}, Esc{esc_indices[1]}},
      node_status_rate_(1.0),
      esc_status_rate_(kEscStatus_Hz) {}

void EscNodes::on_can(std::uint32_t can_id, std::span<const std::uint8_t> data,
                      std::int64_t now_us) {
  const auto source = static_cast<std::uint8_t>(can_id & 0x7FU);
  if (source == 0) return;  // messages read here are never anonymous
  const std::uint32_t about = can_id & 0xFFFF80U;
  if (about == subject(link::RawCommand::kType)) {
    if (const auto transfer = receiver_.push(can_id, data, kRawCommandSeed, now_us)) {
      take_raw_command(*transfer, now_us);
    }
    return;
  }
  if (about == subject(link::ArmingStatus::kType)) {
    const auto transfer = receiver_.push(can_id, data, kArmingStatusSeed, now_us);
    if (!transfer || transfer->size != 1) return;
    const std::int64_t armed_us = transfer->first[0] == kFullyArmed ? now_us : kNever_us;
    for (Esc& esc : escs_) {
      if (!esc.off) esc.armed_us = armed_us;
    }
    return;
  }
  for (std::size_t esc = 0; esc < kEscs; ++esc) {
    if (about != subject(link::NodeInfo::kRequest, kNodes[esc])) continue;
    if (!receiver_.push(can_id, data, kNodeInfoSeed, now_us)) return;
    pending_.push_back({esc, source, static_cast<std::uint8_t>(can_id >> 24U & 0x1FU),
                        static_cast<std::uint8_t>(data.back() & kTransferId)});
  }
}

void EscNodes::take_raw_command(const EscReceiver::Transfer& transfer, std::int64_t now_us) {
  if (transfer.size > kLongestRawCommand) return;
  const auto message = link::read_raw_command(transfer.first);
  for (Esc& esc : escs_) {
    if (esc.index >= message->count || esc.off) continue;
    esc.raw = message->cmd[esc.index];
    esc.raw_us = now_us;
    esc.zero_seen = esc.zero_seen || esc.raw == 0;
  }
}

double EscNodes::told(const Esc& esc, std::int64_t now_us) const {
  if (!esc.zero_seen || now_us - esc.raw_us > kCommandTimeout_us) return 0.0;
  if (now_us - esc.armed_us > kArmingTimeout_us) return 0.0;
  return std::max(esc.raw / kFullScale, -1.0);
}

double EscNodes::command(std::size_t i, std::int64_t now_us) const {
  const Esc& esc = escs_[i];
  if (esc.stuck) return *esc.stuck;
  const double command = told(esc, now_us);
  return esc.reversed ? -command : command;
}

void EscNodes::set_fault(const Fault& fault, std::int64_t now_us) {
  const auto [kind, value, which, seed] = fault;
  for (std::size_t i = 0; i < kEscs; ++i) {
    if (which && *which != i) continue;
    Esc& esc = escs_[i];
    if (kind == FaultKind::kEscSilent) esc.silent = true;
    if (kind == FaultKind::kEscStuck) esc.stuck = command(i, now_us);
    if (kind == FaultKind::kEscReversed) esc.reversed = true;
    if (kind == FaultKind::kEscVoltage) esc.voltage_V = static_cast<float>(value);
    if (kind == FaultKind::kEscReboot) {
      esc = {.index = esc.index, .silent = esc.silent, .reversed = esc.reversed, .off = true};
    }
  }
}

void EscNodes::clear_fault(FaultKind kind, std::optional<std::size_t> which) {
  for (std::size_t i = 0; i < kEscs; ++i) {
    if (which && *which != i) continue;
    Esc& esc = escs_[i];
    if (kind == FaultKind::kEscSilent) esc.silent = false;
    if (kind == FaultKind::kEscStuck) esc.stuck.reset();
    if (kind == FaultKind::kEscReversed) esc.reversed = false;
    if (kind == FaultKind::kEscVoltage) esc.voltage_V.reset();
    if (kind == FaultKind::kEscReboot) esc.off = false;
  }
}

void EscNodes::tick(std::int64_t now_us, const double* rpm, Frames& out) {
  const bool node_due = node_status_rate_.due(now_us), esc_due = esc_status_rate_.due(now_us);
  if (!node_due && !esc_due && pending_.empty()) return;
  for (std::size_t esc = 0; esc < kEscs; ++esc) {
    Esc& it = escs_[esc];
    if (it.silent || it.off) continue;
    if (it.boot_us == kNever_us) it.boot_us = now_us;
    if (node_due) tell_node_status(esc, now_us, out);
    if (esc_due) tell_esc_status(esc, now_us, it.reversed ? -rpm[esc] : rpm[esc], out);
    for (const PendingRequest& request : pending_) {
      if (request.esc == esc) answer(request, now_us, out);
    }
  }
  pending_.clear();
}

void EscNodes::tell_node_status(std::size_t esc, std::int64_t now_us, Frames& out) {
  constexpr link::DataType type = link::NodeStatus::kType;
  link::NodeStatus status;
  status.uptime_sec = uptime_s(escs_[esc].boot_us, now_us);
  link::Payload payload;
  const std::size_t size = write_payload(status, payload);
  link::CanFrame& frame = out.emplace_back();
  // Fits into one frame.
  static_cast<void>(split_transfer({kNodeStatusPriority, type.kind, type.id, kNodes[esc], 0}, type,
                                   next(escs_[esc].node_status_id), std::span(payload).first(size),
                                   std::span(&frame, 1)));
}

void EscNodes::tell_esc_status(std::size_t esc, std::int64_t now_us, double rpm, Frames& out) {
  constexpr link::DataType type = link::EscStatus::kType;
  const auto tail = status_tail(rpm, 100.0 * std::abs(command(esc, now_us)), escs_[esc].index);
  auto h = kStatusHead;
  std::uint16_t crc = kStatusHeadCrc;
  if (const auto volts = escs_[esc].voltage_V) {
    const std::uint16_t half = link::float16_from(*volts);
    h[4] = low_byte(half);
    h[5] = low_byte(half >> 8U);
    crc = link::crc16(type.crc_seed, h);
  }
  crc = link::crc16(crc, tail);
  const std::uint32_t id =
      link::can_id_of({kEscStatusPriority, type.kind, type.id, kNodes[esc], 0});
  const std::uint8_t n = next(escs_[esc].esc_status_id);
  const auto flagged = [n](unsigned flags) { return low_byte(flags | n); };
  out.push_back(
      {id, 8, {low_byte(crc), low_byte(crc >> 8U), h[0], h[1], h[2], h[3], h[4], flagged(0x80)}});
  out.push_back({id, 8, {h[5], h[6], h[7], h[8], h[9], tail[0], tail[1], flagged(0x20)}});
  out.push_back({id, 3, {tail[2], tail[3], flagged(0x40)}});
}

void EscNodes::answer(const PendingRequest& request, std::int64_t now_us, Frames& out) const {
  constexpr link::DataType type = link::NodeInfo::kResponse;
  constexpr std::size_t kMaxFrames = 16;
  link::NodeInfo info;
  info.status.uptime_sec = uptime_s(escs_[request.esc].boot_us, now_us);
  info.software_major = 1;
  info.unique_id = {kNodes[request.esc],
                    escs_[request.esc].index,
                    'f',
                    'l',
                    'o',
                    't',
                    'i',
                    'l',
                    'l',
                    'a',
                    '.',
                    's',
                    'i',
                    'l',
                    '.',
                    'e'};
  info.name = "org.flotilla.sil.esc";
  link::Payload payload;
  const std::size_t size = write_payload(info, payload);
  std::array<link::CanFrame, kMaxFrames> frames;
  const std::size_t count =
      split_transfer({request.priority, type.kind, type.id, kNodes[request.esc], request.source},
                     type, request.transfer_id, std::span(payload).first(size), frames);
  out.insert(out.end(), frames.begin(), frames.begin() + std::ptrdiff_t(count));
}

}  // namespace flotilla::fleet
