// SPDX-License-Identifier: MIT
#include "link/mavlink/decode.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>

#include "link/mavlink/entries.hpp"
#include "link/mavlink/frame.hpp"
#include "link/mavlink/read.hpp"

namespace flotilla::link {
namespace {

constexpr std::uint8_t kEverybody = 0;

/// Whether the header can begin a frame. If noise passed for a header, the decoder would wait for
/// the rest of its frame and delay the frames behind it.
bool plausible(std::uint8_t start, const FrameHeader& h, const MavlinkEntry* entry) {
  return start == kStart1 ? entry != nullptr && h.payload_bytes == entry->min_bytes
                          : h.payload_bytes > 0 && h.is_known();
}

/// Whether a message outside our dialect, whose checksum seed is unknown, counts as whole: it does
/// if another frame or nothing follows. Its contents are then not searched for messages.
bool ends_well(std::span<const std::uint8_t> b, std::size_t frame_bytes) {
  return b.size() == frame_bytes || is_start(b[frame_bytes]);
}

/// The addressee of a message.
Address target_of(std::span<const std::uint8_t> payload, const MavlinkEntry& entry) {
  const auto byte = [&](std::size_t at) { return at < payload.size() ? payload[at] : kEverybody; };
  return {byte(entry.target_system), byte(entry.target_component)};
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
  if (!has_bytes()) return;
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
    if (!is_start(b[0])) {
      skip_byte();
      continue;
    }
    const auto header = read_header(b);
    if (!header) return false;
    const auto* entry = mavlink_entry(header->id);
    if (!plausible(b[0], *header, entry)) {
      skip_byte();
      continue;
    }
    const std::size_t frame_bytes = header->frame_bytes();
    if (b.size() < frame_bytes) return false;
    if (entry == nullptr && ends_well(b, frame_bytes)) {
      begin_ += frame_bytes;
      ++whole_;
      ++counters.mavlink_unknown;
      continue;
    }
    if (entry == nullptr || !checksum_is_good(b, *header, entry->crc_extra)) {
      if (entry != nullptr) ++counters.mavlink_bad_checksum;
      skip_byte();
      continue;
    }
    begin_ += frame_bytes;
    ++whole_;
    const bool is_signed = signing != nullptr && header->is_signed();
    const auto verdict = is_signed ? signing->check(b.first(frame_bytes)) : SignatureVerdict::kGood;
    const bool untimely =
        verdict == SignatureVerdict::kStale || verdict == SignatureVerdict::kFuture;
    if (is_signed && !accepted(verdict, counters) && !untimely) continue;
    const auto payload = b.subspan(header->header_bytes, header->payload_bytes);
    read_payload(payload, header->id, out.message);
    if (untimely && !signing->take_exemption(b.first(frame_bytes), out.message)) continue;
    frame_size_ = frame_bytes;
    ++counters.mavlink_received;
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
