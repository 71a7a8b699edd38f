// SPDX-License-Identifier: MIT
// Counters of received, sent and discarded data, for diagnosis only: they wrap.
#pragma once

#include <cstdint>

namespace flotilla::link {

struct Counters {
  std::uint32_t mavlink_received = 0;       ///< whole messages with a good checksum
  std::uint32_t mavlink_bad_checksum = 0;   ///< frame of a known message whose checksum is wrong
  std::uint32_t mavlink_skipped_bytes = 0;  ///< bytes outside any good message
  std::uint32_t mavlink_bad_value = 0;      ///< not finite, out of range, quaternion of zeros
  std::uint32_t mavlink_bad_frame = 0;      ///< coordinate frame that is not north-aligned
  std::uint32_t mavlink_old_stamp = 0;      ///< repeated, late, or from a clock that went back
  std::uint32_t mavlink_jump = 0;           ///< implausible jump of a vessel's state
  std::uint32_t mavlink_no_heading = 0;     ///< position without an ATTITUDE of about the same time
  std::uint32_t reference_refused = 0;      ///< FORMATION_REFERENCE: too old, a jump, impossible
  std::uint32_t mavlink_unknown = 0;        ///< whole frames of messages not in our dialect
  std::uint32_t mavlink_not_sent = 0;       ///< messages dropped: no room in the tick, or no credit
  std::uint32_t requests_dropped = 0;       ///< beyond the inbox's capacity, or void by a stop
  std::uint32_t can_received = 0;           ///< whole transfers
  std::uint32_t can_bad_frame = 0;          ///< no tail byte, wrong order, lost frame, invalid id
  std::uint32_t can_bad_checksum = 0;       ///< multi-frame transfer whose CRC is wrong
  std::uint32_t can_bad_value = 0;          ///< transfer too short for its type
  std::uint32_t can_not_sent = 0;           ///< transfer dropped: this tick's buffer was full
  std::uint32_t clock_went_back = 0;        ///< calls with a time before the boat's clock

  std::uint32_t mavlink_signed = 0;            ///< messages whose signature is good
  std::uint32_t mavlink_forged = 0;            ///< signed with another key, or changed on the way
  std::uint32_t mavlink_replayed = 0;          ///< signed, but not new: heard before, or too old
  std::uint32_t mavlink_future_stamp = 0;      ///< signed more than a minute ahead of our clock
  std::uint32_t mavlink_streams_full = 0;      ///< signed, by a sender beyond the table's capacity
  std::uint32_t mavlink_unsigned_refused = 0;  ///< unsigned on a link that requires signatures
};

}  // namespace flotilla::link
