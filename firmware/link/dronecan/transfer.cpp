// SPDX-License-Identifier: MIT
#include "link/dronecan/transfer.hpp"

#include <algorithm>
#include <limits>

#include "link/dronecan/crc16.hpp"

namespace flotilla::link {
namespace {

constexpr std::uint8_t kStart = 0x80, kEnd = 0x40, kToggle = 0x20, kTransferIdMask = 0x1F;
constexpr std::size_t kFramePayload = 7;
constexpr std::int64_t kTransferIdTimeout_us = 2'000'000;

constexpr std::uint8_t next_id(std::uint8_t transfer_id) {
  return static_cast<std::uint8_t>((transfer_id + 1U) & kTransferIdMask);
}

/// Steps from a to b on the circle of 32 transfer ids.
constexpr unsigned forward_distance(unsigned a, unsigned b) { return (b - a) & kTransferIdMask; }

CanFrame frame_of(std::uint32_t id, std::span<const std::uint8_t> payload, std::uint8_t tail) {
  CanFrame frame{id, static_cast<std::uint8_t>(payload.size() + 1), {}};
  std::copy(payload.begin(), payload.end(), frame.data.begin());
  frame.data[payload.size()] = tail;
  return frame;
}

}  // namespace

std::uint32_t can_id_of(const Route& r) {
  const std::uint32_t priority = std::uint32_t{r.priority} << 24U;
  if (r.kind == TransferKind::kMessage) return priority | std::uint32_t{r.type} << 8U | r.source;
  const std::uint32_t request = r.kind == TransferKind::kRequest ? 0x8000U : 0U;
  return priority | std::uint32_t{r.type} << 16U | request | std::uint32_t{r.destination} << 8U |
         0x80U | r.source;
}

std::optional<Route> route_of(std::uint32_t can_id) {
  if (can_id >> 29U != 0) return std::nullopt;
  const auto priority = static_cast<std::uint8_t>(can_id >> 24U);
  const auto source = static_cast<std::uint8_t>(can_id & 0x7FU);
  if ((can_id & 0x80U) == 0) {
    const std::uint32_t type = (can_id >> 8U) & (source == 0 ? 0x3U : 0xFFFFU);
    return Route{priority, TransferKind::kMessage, static_cast<std::uint16_t>(type), source, 0};
  }
  const auto destination = static_cast<std::uint8_t>((can_id >> 8U) & 0x7FU);
  if (source == 0 || destination == 0) return std::nullopt;
  const auto kind = (can_id & 0x8000U) != 0 ? TransferKind::kRequest : TransferKind::kResponse;
  return Route{priority, kind, static_cast<std::uint16_t>((can_id >> 16U) & 0xFFU), source,
               destination};
}

std::size_t split_transfer(const Route& route, const DataType& type, std::uint8_t transfer_id,
                           std::span<const std::uint8_t> payload, std::span<CanFrame> out) {
  const std::uint32_t id = can_id_of(route);
  const auto tid = static_cast<std::uint8_t>(transfer_id & kTransferIdMask);
  if (payload.size() <= kFramePayload) {
    if (out.empty()) return 0;
    out[0] = frame_of(id, payload, kStart | kEnd | tid);
    return 1;
  }
  const std::size_t frames = (payload.size() + 2 + kFramePayload - 1) / kFramePayload;
  if (frames > out.size()) return 0;
  const std::uint16_t crc = crc16(type.crc_seed, payload);
  std::array<std::uint8_t, kFramePayload> part{};
  part[0] = static_cast<std::uint8_t>(crc & 0xFFU);
  part[1] = static_cast<std::uint8_t>(crc >> 8U);
  std::size_t filled = 2;
  for (std::size_t i = 0; i < frames; ++i) {
    const std::size_t take = std::min(kFramePayload - filled, payload.size());
    std::copy_n(payload.begin(), take, part.begin() + static_cast<std::ptrdiff_t>(filled));
    payload = payload.subspan(take);
    const auto tail = static_cast<std::uint8_t>(
        (i == 0 ? kStart : 0U) | (i + 1 == frames ? kEnd : 0U) | (i % 2 != 0 ? kToggle : 0U) | tid);
    out[i] = frame_of(id, std::span(part).first(filled + take), tail);
    filled = 0;
  }
  return frames;
}

TransferReceiver::Session& TransferReceiver::session_of(std::uint32_t key) {
  Session* oldest = sessions_.data();
  for (Session& session : sessions_) {
    if (session.key == key) return session;
    if (session.key == 0 || (oldest->key != 0 && session.last_us < oldest->last_us)) {
      oldest = &session;
    }
  }
  *oldest = Session{};
  return *oldest;
}

std::optional<TransferReceiver::Transfer> TransferReceiver::push(
    const Route& route, const DataType& type, std::span<const std::uint8_t> frame,
    std::int64_t now_us, Counters& counters) {
  const auto refuse = [](std::uint32_t& counter) -> std::optional<Transfer> {
    ++counter;
    return std::nullopt;
  };
  if (frame.empty() || frame.size() > 8) return refuse(counters.can_bad_frame);
  const std::uint8_t tail = frame.back();
  const auto tid = static_cast<std::uint8_t>(tail & kTransferIdMask);
  const auto payload = frame.first(frame.size() - 1);
  if ((tail & (kStart | kEnd | kToggle)) == (kStart | kEnd)) {
    // A single-frame transfer needs no session, and its repetition does no harm.
    ++counters.can_received;
    return Transfer{route, tid, payload};
  }
  // The priority is not part of a sender's identity; bit 29 marks the key as used.
  const std::uint32_t key = (can_id_of(route) & 0xFFFFFFU) | 1U << 29U;

  Session& s = session_of(key);
  const bool restart = s.key == 0 || now_us - s.last_us > kTransferIdTimeout_us ||
                       ((tail & kStart) != 0 && forward_distance(tid, s.transfer_id) > 1);
  if (restart) {
    if ((tail & kStart) == 0) return refuse(counters.can_bad_frame);
    s = Session{};
    s.key = key;
    s.transfer_id = tid;
  }
  const bool starts = (tail & kStart) != 0;
  const bool expects_start = !s.toggle && s.size == 0;
  if (tid != s.transfer_id || ((tail & kToggle) != 0) != s.toggle || starts != expects_start ||
      s.size + payload.size() > s.buffer.size()) {
    return refuse(counters.can_bad_frame);
  }
  std::copy(payload.begin(), payload.end(), s.buffer.begin() + s.size);
  s.size = static_cast<std::uint8_t>(s.size + payload.size());
  s.last_us = now_us;
  if ((tail & kEnd) == 0) {
    s.toggle = !s.toggle;
    return std::nullopt;
  }
  std::span<const std::uint8_t> whole(s.buffer.data(), s.size);
  s.transfer_id = next_id(tid);
  s.toggle = false;
  s.size = 0;
  if (whole.size() < 2) return refuse(counters.can_bad_frame);
  const auto received = static_cast<std::uint16_t>(whole[0] | whole[1] << 8U);
  whole = whole.subspan(2);
  if (received != crc16(type.crc_seed, whole)) return refuse(counters.can_bad_checksum);
  ++counters.can_received;
  return Transfer{route, tid, whole};
}

}  // namespace flotilla::link
