// SPDX-License-Identifier: MIT
#include <cstddef>
// Before mavlink.h, whose tables use offsetof().
#define MAVLINK_USE_MESSAGE_INFO
#include <flotilla/mavlink.h>
// After mavlink.h: the search in its tables.
#include <mavlink_get_info.h>

#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

#include "fuzz/wire_numbers.hpp"
#include "link/mavlink/crc.hpp"
#include "link/mavlink/entries.hpp"
#include "link/mavlink/frame.hpp"

namespace flotilla::fuzz {
namespace {

struct Frame {
  link::FrameHeader header;
  std::uint8_t crc_extra;
};

/// Nothing unless a whole frame of the dialect begins here.
std::optional<Frame> read(std::span<const std::uint8_t> b) {
  const auto header = link::read_header(b);
  const auto* entry = header ? link::mavlink_entry(header->id) : nullptr;
  if (entry == nullptr || b.size() < header->frame_bytes()) return std::nullopt;
  return Frame{*header, entry->crc_extra};
}

/// NaN means unknown in this field of the protocol, or was forwarded from an ESC's report.
bool may_be_unknown(std::string_view field) {
  return field == "pose_covariance" || field == "velocity_covariance" || field == "voltage" ||
         field == "current";
}

}  // namespace

std::size_t frame_size(std::span<const std::uint8_t> bytes) {
  const auto frame = read(bytes);
  const bool good = frame && link::checksum_is_good(bytes, frame->header, frame->crc_extra);
  return good ? frame->header.frame_bytes() : 0;
}

void repair(std::span<std::uint8_t> bytes, link::Signing& signing, std::uint8_t link_id) {
  const auto frame = read(bytes);
  if (!frame) return;
  const std::size_t covered = frame->header.covered();
  const auto crc = link::mavlink_crc(bytes.first(covered).subspan(1), frame->crc_extra);
  bytes[covered] = static_cast<std::uint8_t>(crc & 0xFFU);
  bytes[covered + 1] = static_cast<std::uint8_t>(crc >> 8U);
  if (!frame->header.is_signed()) return;
  const std::size_t end = covered + link::kChecksumBytes;
  signing.sign(bytes.first(end), link_id, bytes.subspan(end).first<link::kSignatureBlockBytes>());
}

const char* unsound_number(std::span<const std::uint8_t> b) {
  const auto header = link::read_header(b);
  std::array<std::uint8_t, 256> payload{};  // zeros at its end are not sent
  std::memcpy(payload.data(), b.data() + header->header_bytes, header->payload_bytes);
  const auto* const info = mavlink_get_message_info_by_id(header->id);
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
