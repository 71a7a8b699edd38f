// SPDX-License-Identifier: MIT
#include <cstddef>
// Before it: the tables use offsetof().
#define MAVLINK_USE_MESSAGE_INFO
#include <flotilla/mavlink.h>
// After it: the search in them.
#include <mavlink_get_info.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include "fuzz/wire_numbers.hpp"
#include "link/mavlink/crc.hpp"
#include "link/mavlink/entries.hpp"

namespace flotilla::fuzz {
namespace {

constexpr std::size_t kChecksumBytes = 2;

/// What a frame's header says; no entry: nothing that is known, or not whole.
struct Frame {
  const mavlink_msg_entry_t* entry = nullptr;
  std::size_t header = 0, payload = 0, block = 0;
  std::size_t covered() const { return header + payload; }
  std::size_t size() const { return covered() + kChecksumBytes + block; }
};

Frame read(std::span<const std::uint8_t> b) {
  Frame out;
  if (b.size() >= 10 && b[0] == MAVLINK_STX) {
    const bool has_signature = (b[2] & MAVLINK_IFLAG_SIGNED) != 0;
    const std::uint32_t id = b[7] | std::uint32_t{b[8]} << 8U | std::uint32_t{b[9]} << 16U;
    out = {link::mavlink_entry(id), 10, b[1], has_signature ? link::kSignatureBlockBytes : 0};
  } else if (b.size() >= 6 && b[0] == MAVLINK_STX_MAVLINK1) {
    out = {link::mavlink_entry(b[5]), 6, b[1]};
  }
  if (b.size() < out.size()) out.entry = nullptr;
  return out;
}

std::array<std::uint8_t, kChecksumBytes> checksum(std::span<const std::uint8_t> b,
                                                  const Frame& frame) {
  const auto crc = link::mavlink_crc(b.first(frame.covered()).subspan(1), frame.entry->crc_extra);
  return {static_cast<std::uint8_t>(crc & 0xFFU), static_cast<std::uint8_t>(crc >> 8U)};
}

/// NaN is what the protocol calls unknown there, or what an ESC said of itself.
bool may_be_unknown(std::string_view field) {
  return field == "pose_covariance" || field == "velocity_covariance" || field == "voltage" ||
         field == "current";
}

}  // namespace

std::size_t frame_size(std::span<const std::uint8_t> bytes) {
  const Frame frame = read(bytes);
  if (frame.entry == nullptr) return 0;
  const auto sum = checksum(bytes, frame);
  const auto there = bytes.subspan(frame.covered());
  return there[0] == sum[0] && there[1] == sum[1] ? frame.size() : 0;
}

void repair(std::span<std::uint8_t> bytes, link::Signing& signing, std::uint8_t link_id) {
  const Frame frame = read(bytes);
  if (frame.entry == nullptr) return;
  const auto sum = checksum(bytes, frame);
  bytes[frame.covered()] = sum[0];
  bytes[frame.covered() + 1] = sum[1];
  if (frame.block == 0) return;
  const std::size_t end = frame.covered() + kChecksumBytes;
  signing.sign(bytes.first(end), link_id, bytes.subspan(end).first<link::kSignatureBlockBytes>());
}

const char* unsound_number(std::span<const std::uint8_t> b) {
  const Frame frame = read(b);
  std::array<std::uint8_t, 256> payload{};  // zeros at its end are not sent
  std::memcpy(payload.data(), b.data() + frame.header, frame.payload);
  const auto* const info = mavlink_get_message_info_by_id(frame.entry->msgid);
  for (unsigned i = 0; info != nullptr && i < info->num_fields; ++i) {
    const mavlink_field_info_t& field = info->fields[i];
    if (field.type != MAVLINK_TYPE_FLOAT || may_be_unknown(field.name)) continue;
    for (unsigned k = 0; k < std::max(field.array_length, 1U); ++k) {
      float value = 0;
      std::memcpy(&value, payload.data() + field.wire_offset + k * sizeof value, sizeof value);
      if (!std::isfinite(value)) return field.name;
    }
  }
  return nullptr;
}

}  // namespace flotilla::fuzz
