// SPDX-License-Identifier: MIT
#include "link/mavlink/decode.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "link/mavlink/crc.hpp"
#include "link/mavlink/entries.hpp"
#include "link/mavlink/read.hpp"

namespace flotilla::link {
namespace {

constexpr std::size_t kChecksumBytes = 2;
constexpr std::uint8_t kEverybody = 0;

struct Header {
  std::size_t header_bytes;
  std::size_t payload_bytes;
  std::size_t frame_bytes;
  std::uint32_t id;
  Address from;
  std::uint8_t sequence;
  bool has_signature;
};

/// Reads a frame's header; nothing while it is incomplete.
std::optional<Header> read_header(std::span<const std::uint8_t> b) {
  if (b[0] == MAVLINK_STX && b.size() >= 10) {
    const bool has_signature = (b[2] & MAVLINK_IFLAG_SIGNED) != 0;
    const std::size_t signature = has_signature ? kSignatureBlockBytes : 0;
    const std::uint32_t id = b[7] | std::uint32_t{b[8]} << 8U | std::uint32_t{b[9]} << 16U;
    return Header{10,   b[1],         10U + b[1] + kChecksumBytes + signature, id, {b[5], b[6]},
                  b[4], has_signature};
  }
  if (b[0] == MAVLINK_STX_MAVLINK1 && b.size() >= 6) {
    return Header{6, b[1], 6U + b[1] + kChecksumBytes, b[5], {b[3], b[4]}, b[2], false};
  }
  return std::nullopt;
}

/// Whether such a frame can exist; if not, it is noise: waiting for its end would delay others.
bool plausible(std::span<const std::uint8_t> b, const Header& h, const mavlink_msg_entry_t* entry) {
  const bool v1 = b[0] == MAVLINK_STX_MAVLINK1;
  return v1 ? entry != nullptr && h.payload_bytes == entry->min_msg_len
            : h.payload_bytes > 0 && (b[2] & ~MAVLINK_IFLAG_SIGNED) == 0;
}

/// The checksum of a message not in our dialect is unknown. Where another frame or nothing follows,
/// it counts as whole, so that its contents are not searched for messages.
bool ends_well(std::span<const std::uint8_t> b, std::size_t frame_bytes) {
  return b.size() == frame_bytes || b[frame_bytes] == MAVLINK_STX ||
         b[frame_bytes] == MAVLINK_STX_MAVLINK1;
}

bool checksum_is_good(std::span<const std::uint8_t> b, const Header& h, std::uint8_t crc_extra) {
  const std::size_t covered = h.header_bytes + h.payload_bytes;
  const std::uint16_t crc = mavlink_crc(b.first(covered).subspan(1), crc_extra);
  return b[covered] == (crc & 0xFFU) && b[covered + 1] == crc >> 8U;
}

/// The addressee of a message, at its table entry's offset; two messages lack that in the table.
Address target_of(std::span<const std::uint8_t> payload, const mavlink_msg_entry_t& entry) {
  const auto byte = [&](std::size_t at) { return at < payload.size() ? payload[at] : kEverybody; };
  switch (entry.msgid) {
    case MAVLINK_MSG_ID_MANUAL_CONTROL:
      return {byte(offsetof(mavlink_manual_control_t, target)), kEverybody};
    case MAVLINK_MSG_ID_TIMESYNC:
      return timesync_target(payload);
    default:
      return {(entry.flags & MAV_MSG_ENTRY_FLAG_HAVE_TARGET_SYSTEM) != 0
                  ? byte(entry.target_system_ofs)
                  : kEverybody,
              (entry.flags & MAV_MSG_ENTRY_FLAG_HAVE_TARGET_COMPONENT) != 0
                  ? byte(entry.target_component_ofs)
                  : kEverybody};
  }
}

bool accepted(SignatureVerdict verdict, Counters& counters) {
  switch (verdict) {
    case SignatureVerdict::kGood:
      ++counters.mavlink_signed;
      return true;
    case SignatureVerdict::kForged:
      ++counters.mavlink_forged;
      return false;
    case SignatureVerdict::kReplayed:
    case SignatureVerdict::kStale:
      ++counters.mavlink_replayed;
      return false;
    case SignatureVerdict::kFuture:
      ++counters.mavlink_future_stamp;
      return false;
    case SignatureVerdict::kNoRoom:
      break;
  }
  ++counters.mavlink_streams_full;
  return false;
}

}  // namespace

std::size_t MavlinkDecoder::fill(std::span<const std::uint8_t> bytes) {
  frame_size_ = 0;
  if (begin_ == end_) {
    begin_ = end_ = 0;
  } else if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t taken = std::min(bytes.size(), buffer_.size() - end_);
  std::memcpy(buffer_.data() + end_, bytes.data(), taken);
  end_ += taken;
  return taken;
}

void MavlinkDecoder::give_up(Counters& counters) {
  if (!waits()) return;
  ++begin_;
  ++counters.mavlink_skipped_bytes;
}

bool MavlinkDecoder::next(Received& out, Counters& counters, Signing* signing) {
  frame_size_ = 0;
  const auto skip_byte = [&] {
    ++begin_;
    ++counters.mavlink_skipped_bytes;
  };
  while (begin_ < end_) {
    const std::span<const std::uint8_t> b(buffer_.data() + begin_, end_ - begin_);
    if (b[0] != MAVLINK_STX && b[0] != MAVLINK_STX_MAVLINK1) {
      skip_byte();
      continue;
    }
    const auto header = read_header(b);
    if (!header) return false;
    const auto* entry = mavlink_entry(header->id);
    if (!plausible(b, *header, entry)) {
      skip_byte();
      continue;
    }
    if (b.size() < header->frame_bytes) return false;
    if (entry == nullptr && ends_well(b, header->frame_bytes)) {
      begin_ += header->frame_bytes;
      ++whole_;
      ++counters.mavlink_unknown;
      continue;
    }
    if (entry == nullptr || !checksum_is_good(b, *header, entry->crc_extra)) {
      if (entry != nullptr) ++counters.mavlink_bad_checksum;
      skip_byte();
      continue;
    }
    begin_ += header->frame_bytes;
    ++whole_;
    const bool is_signed = signing != nullptr && header->has_signature;
    if (is_signed && !accepted(signing->check(b.first(header->frame_bytes)), counters)) continue;
    frame_size_ = header->frame_bytes;
    ++counters.mavlink_received;
    const auto payload = b.subspan(header->header_bytes, header->payload_bytes);
    read_payload(payload, header->id, out.message);
    out.from = header->from;
    out.target = target_of(payload, *entry);
    out.id = header->id;
    out.sequence = header->sequence;
    out.is_signed = is_signed;
    return true;
  }
  return false;
}

std::optional<Received> MavlinkDecoder::next(Counters& counters, Signing* signing) {
  std::optional<Received> received(std::in_place);
  if (!next(*received, counters, signing)) received.reset();
  return received;
}

}  // namespace flotilla::link
