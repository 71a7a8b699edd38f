// SPDX-License-Identifier: MIT
#include "link/mavlink_decode.hpp"

#include <flotilla/mavlink.h>

#include <algorithm>
#include <cstring>

namespace flotilla::link {
namespace {

constexpr std::size_t kChecksumBytes = 2;

struct Header {
  std::size_t header_bytes;
  std::size_t payload_bytes;
  std::size_t frame_bytes;
  std::uint32_t id;
  Address from;
};

/// Reads a frame's header; nothing while it is not whole.
std::optional<Header> read_header(std::span<const std::uint8_t> b) {
  if (b[0] == MAVLINK_STX && b.size() >= 10) {
    const std::size_t signature =
        (b[2] & MAVLINK_IFLAG_SIGNED) != 0 ? MAVLINK_SIGNATURE_BLOCK_LEN : 0;
    const std::uint32_t id = b[7] | std::uint32_t{b[8]} << 8U | std::uint32_t{b[9]} << 16U;
    return Header{10, b[1], 10U + b[1] + kChecksumBytes + signature, id, {b[5], b[6]}};
  }
  if (b[0] == MAVLINK_STX_MAVLINK1 && b.size() >= 6) {
    return Header{6, b[1], 6U + b[1] + kChecksumBytes, b[5], {b[3], b[4]}};
  }
  return std::nullopt;
}

/// Whether such a frame can exist; what cannot is noise: waiting for its end would delay others.
bool plausible(std::span<const std::uint8_t> b, const Header& h, const mavlink_msg_entry_t* entry) {
  const bool v1 = b[0] == MAVLINK_STX_MAVLINK1;
  return v1 ? entry != nullptr && h.payload_bytes == entry->min_msg_len
            : h.payload_bytes > 0 && (b[2] & ~MAVLINK_IFLAG_SIGNED) == 0;
}

/// A message that our dialect lacks cannot be checked. Where another frame follows it, or nothing,
/// it is taken for whole, so that nobody looks for messages among its contents.
bool ends_well(std::span<const std::uint8_t> b, std::size_t frame_bytes) {
  return b.size() == frame_bytes || b[frame_bytes] == MAVLINK_STX ||
         b[frame_bytes] == MAVLINK_STX_MAVLINK1;
}

bool checksum_is_good(std::span<const std::uint8_t> b, const Header& h, std::uint8_t crc_extra) {
  const std::size_t covered = h.header_bytes + h.payload_bytes;
  std::uint16_t crc = crc_calculate(b.data() + 1, static_cast<std::uint16_t>(covered - 1));
  crc_accumulate(crc_extra, &crc);
  return b[covered] == (crc & 0xFFU) && b[covered + 1] == crc >> 8U;
}

template <class Wire, class Decode>
Wire decoded(const mavlink_message_t& m, Decode decode) {
  Wire wire{};
  decode(&m, &wire);
  return wire;
}

Message read_message(const mavlink_message_t& m) {
  switch (m.msgid) {
    case MAVLINK_MSG_ID_HEARTBEAT: {
      const auto w = decoded<mavlink_heartbeat_t>(m, mavlink_msg_heartbeat_decode);
      return Heartbeat{w.custom_mode, w.type, w.autopilot, w.base_mode, w.system_status};
    }
    case MAVLINK_MSG_ID_ATTITUDE: {
      const auto w = decoded<mavlink_attitude_t>(m, mavlink_msg_attitude_decode);
      return Attitude{w.time_boot_ms, w.roll,       w.pitch,   w.yaw,
                      w.rollspeed,    w.pitchspeed, w.yawspeed};
    }
    case MAVLINK_MSG_ID_LOCAL_POSITION_NED: {
      const auto w =
          decoded<mavlink_local_position_ned_t>(m, mavlink_msg_local_position_ned_decode);
      return LocalPositionNed{w.time_boot_ms, w.x, w.y, w.z, w.vx, w.vy, w.vz};
    }
    case MAVLINK_MSG_ID_ODOMETRY: {
      const auto w = decoded<mavlink_odometry_t>(m, mavlink_msg_odometry_decode);
      return Odometry{w.time_usec,
                      w.x,
                      w.y,
                      w.z,
                      {w.q[0], w.q[1], w.q[2], w.q[3]},
                      w.vx,
                      w.vy,
                      w.vz,
                      w.rollspeed,
                      w.pitchspeed,
                      w.yawspeed,
                      w.frame_id,
                      w.child_frame_id};
    }
    case MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: {
      const auto w = decoded<mavlink_gps_global_origin_t>(m, mavlink_msg_gps_global_origin_decode);
      return GpsGlobalOrigin{w.latitude, w.longitude, w.altitude, w.time_usec};
    }
    case MAVLINK_MSG_ID_TIMESYNC: {
      const auto w = decoded<mavlink_timesync_t>(m, mavlink_msg_timesync_decode);
      return Timesync{w.tc1, w.ts1};
    }
    case MAVLINK_MSG_ID_COMMAND_LONG: {
      const auto w = decoded<mavlink_command_long_t>(m, mavlink_msg_command_long_decode);
      return CommandLong{w.command,
                         {w.param1, w.param2, w.param3, w.param4, w.param5, w.param6, w.param7},
                         {w.target_system, w.target_component},
                         w.confirmation};
    }
    case MAVLINK_MSG_ID_COMMAND_ACK: {
      const auto w = decoded<mavlink_command_ack_t>(m, mavlink_msg_command_ack_decode);
      return CommandAck{w.command, w.result, {w.target_system, w.target_component}};
    }
    case MAVLINK_MSG_ID_STATUSTEXT: {
      const auto w = decoded<mavlink_statustext_t>(m, mavlink_msg_statustext_decode);
      Statustext text{w.severity, {}};
      std::copy(std::begin(w.text), std::end(w.text), text.text.begin());
      return text;
    }
    case MAVLINK_MSG_ID_NAMED_VALUE_FLOAT: {
      const auto w = decoded<mavlink_named_value_float_t>(m, mavlink_msg_named_value_float_decode);
      NamedValueFloat value{w.time_boot_ms, w.value, {}};
      std::copy(std::begin(w.name), std::end(w.name), value.name.begin());
      return value;
    }
    default:
      return std::monostate{};
  }
}

/// The payload alone matters to the generated decoders; what the frame leaves out is zero.
Message read_payload(std::span<const std::uint8_t> payload, std::uint32_t id) {
  mavlink_message_t m;
  m.msgid = id & 0xFFFFFFU;
  m.len = static_cast<std::uint8_t>(payload.size());
  auto* bytes = _MAV_PAYLOAD_NON_CONST(&m);
  std::memcpy(bytes, payload.data(), payload.size());
  std::memset(bytes + payload.size(), 0, MAVLINK_MAX_PAYLOAD_LEN - payload.size());
  return read_message(m);
}

}  // namespace

std::size_t MavlinkDecoder::fill(std::span<const std::uint8_t> bytes) {
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  const std::size_t taken = std::min(bytes.size(), buffer_.size() - end_);
  std::memcpy(buffer_.data() + end_, bytes.data(), taken);
  end_ += taken;
  return taken;
}

std::optional<Received> MavlinkDecoder::next(Counters& counters) {
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
    if (!header) return std::nullopt;
    const auto* entry = mavlink_get_msg_entry(header->id);
    if (!plausible(b, *header, entry)) {
      skip_byte();
      continue;
    }
    if (b.size() < header->frame_bytes) return std::nullopt;
    if (entry == nullptr) {
      if (!ends_well(b, header->frame_bytes)) {
        skip_byte();
        continue;
      }
      begin_ += header->frame_bytes;
      ++counters.mavlink_unknown;
      continue;
    }
    if (!checksum_is_good(b, *header, entry->crc_extra)) {
      ++counters.mavlink_bad_checksum;
      skip_byte();
      continue;
    }
    begin_ += header->frame_bytes;
    ++counters.mavlink_received;
    return Received{
        header->from,
        read_payload(b.subspan(header->header_bytes, header->payload_bytes), header->id)};
  }
  return std::nullopt;
}

}  // namespace flotilla::link
