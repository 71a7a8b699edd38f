// SPDX-License-Identifier: MIT
// Random MAVLink messages of every type that the firmware has, and their fields as numbers.
#pragma once

#include <random>
#include <vector>

#include "link/mavlink_decode.hpp"
#include "link/mavlink_encode.hpp"

namespace flotilla::testing {

using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t kMessages = std::variant_size_v<link::Message>;  // the first is monostate

struct AnyMessage {
  explicit AnyMessage(std::uint32_t seed) : engine(seed) {}

  std::uint8_t u8() { return static_cast<std::uint8_t>(engine()); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(engine()); }
  std::uint32_t u32() { return static_cast<std::uint32_t>(engine()); }
  std::int32_t i32() { return static_cast<std::int32_t>(engine()); }
  std::int64_t i64() { return static_cast<std::int64_t>(engine()) << 20U; }  // exact as a double
  float real() { return std::uniform_real_distribution<float>(-1000, 1000)(engine); }

  /// 1 … kMessages − 1
  link::Message operator()(std::size_t index) {
    switch (index) {
      case 1:
        return link::Heartbeat{u32(), u8(), u8(), u8(), u8()};
      case 2:
        return link::Attitude{u32(), real(), real(), real(), real(), real(), real()};
      case 3:
        return link::LocalPositionNed{u32(), real(), real(), real(), real(), real(), real()};
      case 4:
        return link::Odometry{static_cast<std::uint64_t>(i64()),
                              real(),
                              real(),
                              real(),
                              {real(), real(), real(), real()},
                              real(),
                              real(),
                              real(),
                              real(),
                              real(),
                              real(),
                              u8(),
                              u8()};
      case 5:
        return link::GpsGlobalOrigin{i32(), i32(), i32(), static_cast<std::uint64_t>(i64())};
      case 6:
        return link::Timesync{i64(), i64()};
      case 7:
        return link::CommandLong{
            u16(), {real(), real(), real(), real(), real(), real(), real()}, u8(), u8(), u8()};
      case 8:
        return link::CommandAck{u16(), u8(), u8(), u8()};
      default: {
        link::Statustext text{u8(), {}};
        for (char& c : text.text) c = static_cast<char>('A' + u8() % 26);
        return text;
      }
    }
  }

  std::mt19937 engine;
};

/// All fields of a message, its type first.
inline std::vector<double> fields_of(const link::Message& message) {
  std::vector<double> out{static_cast<double>(message.index())};
  const auto put = [&](auto... values) { (out.push_back(static_cast<double>(values)), ...); };
  if (const auto* h = std::get_if<link::Heartbeat>(&message)) {
    put(h->custom_mode, h->type, h->autopilot, h->base_mode, h->system_status);
  } else if (const auto* a = std::get_if<link::Attitude>(&message)) {
    put(a->time_boot_ms, a->roll, a->pitch, a->yaw, a->rollspeed, a->pitchspeed, a->yawspeed);
  } else if (const auto* p = std::get_if<link::LocalPositionNed>(&message)) {
    put(p->time_boot_ms, p->x, p->y, p->z, p->vx, p->vy, p->vz);
  } else if (const auto* o = std::get_if<link::Odometry>(&message)) {
    put(o->time_usec, o->x, o->y, o->z, o->q[0], o->q[1], o->q[2], o->q[3], o->vx, o->vy, o->vz,
        o->rollspeed, o->pitchspeed, o->yawspeed, o->frame_id, o->child_frame_id);
  } else if (const auto* g = std::get_if<link::GpsGlobalOrigin>(&message)) {
    put(g->latitude, g->longitude, g->altitude, g->time_usec);
  } else if (const auto* t = std::get_if<link::Timesync>(&message)) {
    put(t->tc1, t->ts1);
  } else if (const auto* c = std::get_if<link::CommandLong>(&message)) {
    put(c->command, c->target.system, c->target.component, c->confirmation);
    for (const float x : c->param) put(x);
  } else if (const auto* k = std::get_if<link::CommandAck>(&message)) {
    put(k->command, k->result, k->target.system, k->target.component);
  } else if (const auto* s = std::get_if<link::Statustext>(&message)) {
    put(s->severity);
    for (const char x : s->text) put(x);
  }
  return out;
}

inline Bytes frame_of(link::MavlinkEncoder& encoder, const link::Message& message) {
  Bytes out(300);
  out.resize(encoder.encode(message, out));
  return out;
}

/// All that a decoder finds in these bytes, given at once.
inline std::vector<link::Received> received_from(link::MavlinkDecoder& decoder,
                                                 std::span<const std::uint8_t> bytes,
                                                 link::Counters& counters) {
  std::vector<link::Received> out;
  while (!bytes.empty()) {
    bytes = bytes.subspan(decoder.fill(bytes));
    while (const auto received = decoder.next(counters)) out.push_back(*received);
  }
  return out;
}

}  // namespace flotilla::testing
