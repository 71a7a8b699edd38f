// SPDX-License-Identifier: MIT
#include "fleet/esc_receiver.hpp"

#include "link/dronecan/crc16.hpp"

namespace flotilla::fleet {
namespace {

constexpr std::uint8_t kStart = 0x80, kEnd = 0x40, kToggle = 0x20, kTransferId = 0x1F;
constexpr std::int64_t kTransferIdTimeout_us = 2'000'000;
constexpr std::size_t kChecksum = 2, kMaxPayload = 512;

}  // namespace

void EscReceiver::Session::restart(unsigned id) {
  transfer_id = static_cast<std::uint8_t>(id & kTransferId);
  toggle = 0;
  open = false;
  size = 0;
}

void EscReceiver::Session::append(std::span<const std::uint8_t> payload, std::uint16_t crc_seed) {
  for (const std::uint8_t byte : payload) {
    if (size < kChecksum) {
      crc_told = static_cast<std::uint16_t>(size == 0 ? byte : crc_told | byte << 8U);
      crc = crc_seed;
    } else {
      crc = link::crc16(crc, std::span(&byte, 1));
      if (size - kChecksum < first.size()) first[size - kChecksum] = byte;
    }
    ++size;
  }
}

EscReceiver::Session& EscReceiver::session_of(std::uint32_t key) {
  for (Session& session : sessions_) {
    if (session.key == key) return session;
  }
  return sessions_.emplace_back(Session{key});
}

std::optional<EscReceiver::Transfer> EscReceiver::push(std::uint32_t can_id,
                                                       std::span<const std::uint8_t> data,
                                                       std::uint16_t crc_seed,
                                                       std::int64_t now_us) {
  if (data.empty() || data.size() > 8 || can_id >> 29U != 0) return std::nullopt;
  const std::uint8_t tail = data.back();
  const auto payload = data.first(data.size() - 1);
  Session& s = session_of(can_id & 0xFFFFFFU);
  const unsigned transfer_id = tail & kTransferId;
  const bool start = (tail & kStart) != 0, end = (tail & kEnd) != 0;
  const bool skipped = start && ((s.transfer_id - transfer_id) & kTransferId) > 1;
  if (now_us - s.start_us > kTransferIdTimeout_us || skipped) {
    if (!start) return std::nullopt;
    s.restart(transfer_id);
  }
  // Not in the specification: a start inside a transfer, or a transfer without a start.
  if ((tail & kToggle) != s.toggle || transfer_id != s.transfer_id || start == s.open) {
    return std::nullopt;
  }
  if (start) {
    s.start_us = now_us;
    if (end) {
      s.transfer_id = static_cast<std::uint8_t>((transfer_id + 1) & kTransferId);
      return Transfer{payload.size(), payload};
    }
    s.open = true;
  }
  s.append(payload, crc_seed);
  s.toggle ^= kToggle;
  if (!end) {
    if (s.size > kMaxPayload) s.restart(transfer_id + 1);
    return std::nullopt;
  }
  // A transfer too short for a checksum is discarded like a bad one.
  const bool good = s.size >= kChecksum && s.crc == s.crc_told;
  const std::size_t size = s.size - kChecksum;
  s.restart(transfer_id + 1);
  if (!good) return std::nullopt;
  return Transfer{size, std::span(s.first).first(std::min(size, s.first.size()))};
}

}  // namespace flotilla::fleet
