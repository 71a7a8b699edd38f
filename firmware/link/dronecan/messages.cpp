// SPDX-License-Identifier: MIT
#include "link/dronecan/messages.hpp"

#include <algorithm>

#include "link/dronecan/bit_stream.hpp"
#include "link/dronecan/float16.hpp"

namespace flotilla::link {
namespace {

constexpr std::int32_t kInt14Max = 8191, kInt14Min = -8192, kInt18Max = 131071, kInt18Min = -131072;

void put_signed(BitWriter& bits, std::int32_t value, std::int32_t low, std::int32_t high,
                unsigned width) {
  bits.put(static_cast<std::uint64_t>(std::int64_t{std::clamp(value, low, high)}), width);
}

void put_node_status(BitWriter& bits, const NodeStatus& m) {
  bits.put(m.uptime_sec, 32);
  bits.put(std::min<unsigned>(m.health, 3), 2);
  bits.put(std::min<unsigned>(m.mode, 7), 3);
  bits.put(std::min<unsigned>(m.sub_mode, 7), 3);
  bits.put(m.vendor_specific_status_code, 16);
}

float take_float16(BitReader& bits) {
  return float_from_float16(static_cast<std::uint16_t>(bits.take(16)));
}

}  // namespace

std::size_t write_payload(const RawCommand& m, Payload& out) {
  BitWriter bits(out);
  // Tail array optimization: no length field, the array ends with the payload.
  for (std::size_t i = 0; i < std::min<std::size_t>(m.count, m.cmd.size()); ++i) {
    put_signed(bits, m.cmd[i], kInt14Min, kInt14Max, 14);
  }
  return bits.size_bytes();
}

std::size_t write_payload(const ArmingStatus& m, Payload& out) {
  out[0] = m.status;
  return 1;
}

std::size_t write_payload(const NodeStatus& m, Payload& out) {
  BitWriter bits(out);
  put_node_status(bits, m);
  return bits.size_bytes();
}

std::size_t write_payload(const EscStatus& m, Payload& out) {
  BitWriter bits(out);
  bits.put(m.error_count, 32);
  bits.put(float16_from(m.voltage), 16);
  bits.put(float16_from(m.current), 16);
  bits.put(float16_from(m.temperature), 16);
  put_signed(bits, m.rpm, kInt18Min, kInt18Max, 18);
  bits.put(std::min<unsigned>(m.power_rating_pct, 127), 7);
  bits.put(std::min<unsigned>(m.esc_index, 31), 5);
  return bits.size_bytes();
}

std::size_t write_payload(const NodeInfo& m, Payload& out) {
  constexpr unsigned kVcsCommitKnown = 1;
  BitWriter bits(out);
  put_node_status(bits, m.status);
  bits.put(m.software_major, 8);
  bits.put(m.software_minor, 8);
  bits.put(m.vcs_commit != 0 ? kVcsCommitKnown : 0, 8);
  bits.put(m.vcs_commit, 32);
  bits.put(0, 64);  // image CRC: unknown
  bits.put(m.hardware_major, 8);
  bits.put(m.hardware_minor, 8);
  for (const std::uint8_t byte : m.unique_id) bits.put(byte, 8);
  bits.put(0, 8);  // no certificate of authenticity
  for (const char c : m.name.substr(0, 80)) bits.put(static_cast<std::uint8_t>(c), 8);
  return bits.size_bytes();
}

std::size_t write_payload(const Allocation& m, Payload& out) {
  const std::size_t size = std::min<std::size_t>(m.size, m.unique_id.size());
  out[0] = static_cast<std::uint8_t>(unsigned{m.node_id} << 1U | (m.first_part ? 1U : 0U));
  std::copy_n(m.unique_id.begin(), size, out.begin() + 1);
  return 1 + size;
}

std::optional<RawCommand> read_raw_command(std::span<const std::uint8_t> payload) {
  BitReader bits(payload);
  RawCommand m;
  while (bits.left() >= 14 && m.count < m.cmd.size()) {
    m.cmd[m.count++] = static_cast<std::int16_t>(bits.take_signed(14));
  }
  return m;
}

std::optional<ArmingStatus> read_arming_status(std::span<const std::uint8_t> payload) {
  if (payload.empty()) return std::nullopt;
  return ArmingStatus{payload[0]};
}

std::optional<SafetyState> read_safety_state(std::span<const std::uint8_t> payload) {
  if (payload.empty()) return std::nullopt;
  return SafetyState{payload[0]};
}

std::optional<Button> read_button(std::span<const std::uint8_t> payload) {
  if (payload.size() < 2) return std::nullopt;
  return Button{payload[0]};
}

std::optional<NodeStatus> read_node_status(std::span<const std::uint8_t> payload) {
  if (payload.size() < 7) return std::nullopt;
  BitReader bits(payload);
  NodeStatus m;
  m.uptime_sec = static_cast<std::uint32_t>(bits.take(32));
  m.health = static_cast<std::uint8_t>(bits.take(2));
  m.mode = static_cast<std::uint8_t>(bits.take(3));
  m.sub_mode = static_cast<std::uint8_t>(bits.take(3));
  m.vendor_specific_status_code = static_cast<std::uint16_t>(bits.take(16));
  return m;
}

std::optional<Allocation> read_allocation(std::span<const std::uint8_t> payload) {
  Allocation m;
  if (payload.empty() || payload.size() - 1 > m.unique_id.size()) return std::nullopt;
  m.node_id = payload[0] >> 1U;
  m.first_part = (payload[0] & 1U) != 0;
  m.size = static_cast<std::uint8_t>(payload.size() - 1);
  std::copy(payload.begin() + 1, payload.end(), m.unique_id.begin());
  return m;
}

std::optional<EscStatus> read_esc_status(std::span<const std::uint8_t> payload) {
  if (payload.size() < 14) return std::nullopt;
  BitReader bits(payload);
  EscStatus m;
  m.error_count = static_cast<std::uint32_t>(bits.take(32));
  m.voltage = take_float16(bits);
  m.current = take_float16(bits);
  m.temperature = take_float16(bits);
  m.rpm = static_cast<std::int32_t>(bits.take_signed(18));
  m.power_rating_pct = static_cast<std::uint8_t>(bits.take(7));
  m.esc_index = static_cast<std::uint8_t>(bits.take(5));
  return m;
}

}  // namespace flotilla::link
