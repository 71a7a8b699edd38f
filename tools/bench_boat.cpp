// SPDX-License-Identifier: MIT
// Workloads for the stopwatch and the instruction counter of tools/bench.
//
//   flotilla_bench tick N          N ticks in FORMATION: own and leader's ATTITUDE and
//                                  LOCAL_POSITION_NED and the leader's FORMATION_REFERENCE decoded,
//                                  RawCommand encoded
//   flotilla_bench tick_odometry N the same from an ODOMETRY each
//   flotilla_bench odometry N      N ODOMETRY decoded by the link alone
//   flotilla_bench replay N FILE BOAT NAME=VALUE...   first N ticks of that boat in a recording.bin
//   flotilla_bench stream N        the input of `tick` for flotilla_player, to standard output
//
// Inputs are generated, and for a replay read, before the clock starts; prints ns for all N.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "app/boat/boat.hpp"

namespace {

using namespace flotilla;

constexpr std::int64_t kPeriod_us = 10'000;
constexpr std::uint8_t kOwn = 1, kLeader = 100;
// At least so many ticks are generated, so the difference of two N up to this is due to ticks alone.
constexpr std::size_t kLeast = 2'000;

/// Input of a boat at one instant; kTick ends it.
struct Event {
  std::int64_t t_us;
  enum class Kind : std::uint8_t { kMavlink, kCan, kTick } kind;
  std::size_t link = 0;
  std::uint32_t can_id = 0;
  std::vector<std::uint8_t> bytes;
};

void add_frame(std::vector<std::uint8_t>& bytes, link::MavlinkEncoder& encoder,
               const link::Message& message) {
  std::array<std::uint8_t, 300> frame{};
  const std::size_t size = encoder.encode(message, frame);
  bytes.insert(bytes.end(), frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(size));
}

link::Odometry odometry_at(std::int64_t t_us, float x) {
  return {static_cast<std::uint64_t>(t_us),
          x,
          x,
          0,
          {0.9F, 0, 0, 0.4F},
          0.6F,
          0,
          0,
          0,
          0,
          0,
          link::mav::kFrameLocalNed,
          link::mav::kFrameBodyFrd};
}

std::vector<std::uint8_t> state_of(link::MavlinkEncoder& encoder, std::int64_t t_us, float x,
                                   bool odometry) {
  std::vector<std::uint8_t> bytes;
  if (t_us % 1'000'000 == 0) add_frame(bytes, encoder, link::GpsGlobalOrigin{487, 22, 0, 0});
  const auto ms = static_cast<std::uint32_t>(t_us / 1000);
  if (odometry) {
    add_frame(bytes, encoder, odometry_at(t_us, x));
  } else {
    add_frame(bytes, encoder, link::Attitude{ms, 0, 0, 0.8F, 0, 0, 0});
    add_frame(bytes, encoder, link::LocalPositionNed{ms, x, x, 0, 0.4F, 0.4F, 0});
  }
  return bytes;
}

/// North and east: a slot of zero would be the leader's own place.
constexpr float kBehind_m = 2;

app::Parameters in_its_slot() {
  app::Parameters parameters;
  parameters.FORM_OFS_N = parameters.FORM_OFS_E = -kBehind_m;
  parameters.NAV_LAG_S = parameters.FORM_LAG_S = 0;  // nobody answers TIMESYNC
  return parameters;
}

/// The reference of a root at the leader's position.
link::FormationReference reference_at(std::int64_t t_us, float x) {
  link::FormationReference m{};
  m.time_boot_ms = static_cast<std::uint32_t>(t_us / 1000);
  m.sequence = static_cast<std::uint16_t>(t_us / kPeriod_us);
  m.root = 101;
  m.maker = kLeader;
  m.flags = link::mav::kReferenceFollowed;
  const auto place = static_cast<std::int32_t>(1024 * x);
  m.latitude = 487, m.longitude = 22;
  m.north = m.east = place;
  m.heading = 6554, m.nu = {579, 0, 0};
  m.path[0] = m.root;
  return m;
}

void add_esc_reports(std::vector<Event>& events, std::int64_t t_us, std::uint8_t transfer_id) {
  for (std::uint8_t side = 0; side < 2; ++side) {
    const auto node = static_cast<std::uint8_t>(21 + side);
    const auto add = [&](const link::DataType& type, const auto& message) {
      link::Payload payload;
      std::array<link::CanFrame, 4> frames;
      const std::size_t size = write_payload(message, payload);
      const std::size_t n = split_transfer({16, type.kind, type.id, node, 0}, type, transfer_id,
                                           std::span(payload).first(size), frames);
      for (std::size_t i = 0; i < n; ++i) {
        const auto data = frames[i].bytes();
        events.push_back({t_us, Event::Kind::kCan, 0, frames[i].id, {data.begin(), data.end()}});
      }
    };
    link::EscStatus status;
    status.esc_index = side;
    add(link::EscStatus::kType, status);
    add(link::NodeStatus::kType, link::NodeStatus{});
  }
}

std::vector<Event> made_events(std::size_t n, bool odometry) {
  std::vector<Event> events;
  link::MavlinkEncoder own({kOwn, 220}), leader({kLeader, 1}), operator_({255, 190});
  for (std::size_t k = 1; k <= std::max(n, kLeast); ++k) {
    const auto t_us = static_cast<std::int64_t>(k) * kPeriod_us;
    // Both sail north-east, the boat in its slot: it need not close up.
    const float x = 0.004F * static_cast<float>(k);
    if (k % 50 == 1) add_esc_reports(events, t_us, static_cast<std::uint8_t>(k / 50 % 32));
    events.push_back(
        {t_us, Event::Kind::kMavlink, 0, 0, state_of(own, t_us, x - kBehind_m, odometry)});
    std::vector<std::uint8_t> leaders = state_of(leader, t_us, x, odometry);
    add_frame(leaders, leader, reference_at(t_us, x));
    events.push_back({t_us, Event::Kind::kMavlink, 0, 0, leaders});
    if (k == 150 || k == 151) {
      link::CommandLong command{link::mav::kCmdComponentArmDisarm, {1}, kOwn, 1, 0};
      if (k == 151) command = {link::mav::kCmdDoSetMode, {1, 6}, kOwn, 1, 0};
      std::vector<std::uint8_t> bytes;
      add_frame(bytes, operator_, command);
      events.push_back({t_us, Event::Kind::kMavlink, 0, 0, bytes});
    }
    events.push_back({t_us, Event::Kind::kTick, 0, 0, {}});
  }
  return events;
}

/// The layout of sil/lockstep/recording.py.
std::vector<Event> recorded_events(const char* path, unsigned boat) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<std::uint8_t> content{std::istreambuf_iterator<char>(file), {}};
  const auto number = [&]<class T>(std::size_t at, T value) {
    std::memcpy(&value, content.data() + at, sizeof value);
    return value;
  };
  std::vector<Event> events;
  std::size_t at = 12 + number(8, std::uint32_t{0});
  while (at + 12 <= content.size()) {
    const auto t_us = static_cast<std::int64_t>(number(at, std::uint64_t{0}));
    const unsigned port = number(at + 8, std::uint16_t{0});
    const std::size_t length = number(at + 10, std::uint16_t{0});
    at += 12;
    if (port >> 8U == boat) {
      const unsigned channel = port & 0xFFU;
      const auto* data = content.data() + at;
      if (channel < 8) {
        events.push_back({t_us, Event::Kind::kMavlink, channel, 0, {data, data + length}});
      } else if (channel == 8) {
        events.push_back(
            {t_us, Event::Kind::kCan, 0, number(at, std::uint32_t{0}), {data + 4, data + length}});
      } else if (events.empty() || events.back().kind != Event::Kind::kTick) {
        events.push_back({t_us, Event::Kind::kTick, 0, 0, {}});
      }
    }
    at += length;
  }
  return events;
}

/// Plays events until n ticks are done; returns how many were.
std::size_t play(app::Boat<float>& boat, const std::vector<Event>& events, std::size_t n) {
  std::size_t ticks = 0;
  for (const Event& event : events) {
    if (ticks == n) break;
    switch (event.kind) {
      case Event::Kind::kMavlink:
        boat.on_mavlink(event.bytes, event.t_us, event.link);
        break;
      case Event::Kind::kCan:
        boat.on_can(event.can_id, event.bytes, event.t_us);
        break;
      case Event::Kind::kTick:
        boat.tick(event.t_us);
        ++ticks;
        break;
    }
  }
  return ticks;
}

std::size_t decode_odometry(std::size_t n) {
  link::MavlinkEncoder encoder({kOwn, 220});
  std::vector<std::uint8_t> bytes;
  for (std::size_t k = 0; k < 100; ++k) add_frame(bytes, encoder, odometry_at(1, 0));
  link::MavlinkDecoder decoder;
  link::Counters counters;
  while (counters.mavlink_received < n) {
    std::span<const std::uint8_t> left(bytes);
    while (!left.empty()) {
      left = left.subspan(decoder.fill(left));
      while (counters.mavlink_received < n && decoder.next(counters)) {
      }
      if (counters.mavlink_received == n) break;
    }
  }
  return n;
}

/// In the layout of firmware/cortex_m/player.hpp.
void write_stream(const std::vector<Event>& events, std::size_t n) {
  const auto put = [](const auto& value) { std::fwrite(&value, sizeof value, 1, stdout); };
  const auto record = [&](std::int64_t t_us, std::uint16_t port, std::size_t length) {
    put(t_us);
    put(port);
    put(static_cast<std::uint16_t>(length));
  };
  const app::Parameters parameters = in_its_slot();
  record(0, 34, 4 + 4 * app::kParameterList.size());
  put(std::uint32_t{1});
  for (const app::ParameterInfo& info : app::kParameterList) put(parameters.*(info.member));
  std::size_t ticks = 0;
  for (const Event& event : events) {
    if (ticks == n) break;
    switch (event.kind) {
      case Event::Kind::kMavlink:
        record(event.t_us, static_cast<std::uint16_t>(event.link), event.bytes.size());
        break;
      case Event::Kind::kCan:
        record(event.t_us, 8, 4 + event.bytes.size());
        put(event.can_id);
        break;
      case Event::Kind::kTick:
        record(event.t_us, 33, 0);
        ++ticks;
        break;
    }
    std::fwrite(event.bytes.data(), 1, event.bytes.size(), stdout);
  }
}

int fail(const char* why) {
  std::fprintf(stderr, "flotilla_bench: %s\n", why);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return fail("CASE N [FILE BOAT NAME=VALUE...]");
  const std::string_view what = argv[1];
  const auto n = static_cast<std::size_t>(std::atoll(argv[2]));
  const bool replay = what == "replay" && argc > 4;
  app::Parameters parameters = in_its_slot();
  for (int i = 5; i < argc; ++i) {
    const std::string_view text = argv[i];
    const app::ParameterInfo* info = app::find_parameter(text.substr(0, text.find('=')));
    if (info == nullptr) return fail("unknown parameter");
    parameters.*(info->member) = std::strtof(argv[i] + text.find('=') + 1, nullptr);
  }
  std::vector<Event> events;
  if (replay) {
    events = recorded_events(argv[3], static_cast<unsigned>(std::atoi(argv[4])));
  } else if (what != "odometry") {
    events = made_events(n, what == "tick_odometry");
  }
  if (what == "stream") {
    write_stream(events, n);
    return 0;
  }
  app::Boat<float> boat(parameters, replay ? 2 : 1);
  const auto began = std::chrono::steady_clock::now();
  const std::size_t done = what == "odometry" ? decode_odometry(n) : play(boat, events, n);
  const std::chrono::nanoseconds took = std::chrono::steady_clock::now() - began;
  if (done != n) return fail("fewer ticks than asked for");
  if (what != "odometry" && n > 200 && boat.snapshot().state != core::State::kFormation) {
    return fail("the boat is not in FORMATION");
  }
  std::printf("%lld\n", static_cast<long long>(took.count()));
  return 0;
}
