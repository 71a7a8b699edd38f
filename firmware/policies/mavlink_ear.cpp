// SPDX-License-Identifier: MIT
#include "policies/mavlink_ear.hpp"

#include <algorithm>
#include <cstring>
#include <string_view>

#include "app/text.hpp"

namespace flotilla::policies {
namespace {

namespace mav = link::mav;
using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kVersion1 = 0xFE, kVersion2 = 0xFD, kSigned = 1;
// Of messages that link::mav has no name for.
constexpr std::uint32_t kSetMode = 11, kParamValue = 22, kParamSet = 23, kManualControl = 69,
                        kCommandInt = 75, kCommandLong = 76, kCommandAck = 77, kTimesync = 111,
                        kStatustext = 253;

template <class T>
T field(Bytes payload, std::size_t at) {
  T value{};
  if (at < payload.size()) {
    std::memcpy(&value, payload.data() + at, std::min(sizeof value, payload.size() - at));
  }
  return value;
}

/// Where floating-point numbers stand one behind the other, and a time since boot in ms.
struct Numbers {
  std::uint8_t first = 0, count = 0;
  bool has_time = false;
};

/// What an ESC does not know is NaN by its protocol, and told as such: its currents are no number
/// of ours.
constexpr Numbers numbers_of(std::uint32_t id) {
  switch (id) {
    case mav::kAttitudeId:
    case mav::kLocalPositionNedId:
      return {4, 6, true};
    case kParamValue:
      return {0, 1};
    case mav::kGlobalPositionIntId:
      return {0, 0, true};
    case mav::kNavControllerOutputId:
      return {0, 5};
    case mav::kPositionTargetLocalNedId:
      return {4, 11, true};
    case mav::kFollowTargetId:
      return {24, 14};
    case mav::kHomePositionId:
      return {12, 10};
    case mav::kNamedValueFloatId:
      return {4, 1, true};
    case mav::kOdometryId:
      return {8, 13};
    default:
      return {};
  }
}

bool finite(Bytes payload, const Numbers& numbers) {
  constexpr std::uint32_t kExponent = 0x7F800000;
  const auto count = std::size_t{numbers.count};
  bool good = true;
  for (std::size_t i = 0; i < count; ++i) {
    good = good && (field<std::uint32_t>(payload, numbers.first + 4 * i) & kExponent) != kExponent;
  }
  return good;
}

}  // namespace

std::optional<Frame> frame_at(Bytes b) {
  if (b.size() >= 12 && b[0] == kVersion2 && (b[2] & ~kSigned) == 0 && b[1] > 0) {
    const std::size_t size = 12U + b[1] + (b[2] != 0 ? 13U : 0U);
    if (size > b.size()) return std::nullopt;
    const std::uint32_t id = b[7] | std::uint32_t{b[8]} << 8U | std::uint32_t{b[9]} << 16U;
    return Frame{size, {b[5], b[6]}, b[4], id, b.subspan(10, b[1])};
  }
  if (b.size() >= 8 && b[0] == kVersion1 && b.size() >= 8U + b[1]) {
    return Frame{8U + b[1], {b[3], b[4]}, b[2], b[5], b.subspan(6, b[1])};
  }
  return std::nullopt;
}

MavlinkEar::MavlinkEar(const app::Parameters& p)
    : self_{static_cast<std::uint8_t>(p.MAV_SYSID), static_cast<std::uint8_t>(p.MAV_COMPID)},
      companion_(p.MAV_IDENTITY == 1.0F) {}

bool MavlinkEar::hear(Bytes bytes, const app::Parameters& p, Moment& n) {
  while (!bytes.empty()) {
    const auto frame = frame_at(bytes);
    if (!frame) return false;
    bytes = bytes.subspan(frame->size);
    const std::uint8_t system = frame->from.system;
    heard_.set(system);
    n.heard.own = n.heard.own || companion_ || system == self_.system;
    n.heard.leader = n.heard.leader || static_cast<float>(system) == p.FORM_LEADER;
    if (frame->from != self_) hear_request(*frame, p, n);
  }
  return true;
}

void MavlinkEar::hear_request(const Frame& frame, const app::Parameters& p, Moment& n) const {
  const Bytes m = frame.payload;
  switch (frame.id) {
    case kManualControl:
      n.heard.sticks = true;
      break;
    case kSetMode:
      hear_mode(field<std::uint32_t>(m, 0), n);
      break;
    case kParamSet:
      if (std::memcmp(field<std::array<char, 5>>(m, 6).data(), "MODE", 5) == 0) {
        hear_mode(double{field<float>(m, 0)}, n);
      }
      break;
    case kCommandLong:
    case kCommandInt: {
      const auto command = field<std::uint16_t>(m, 28);
      const link::Address target{field<std::uint8_t>(m, 30), field<std::uint8_t>(m, 31)};
      ++n.asked[Ask::kAck];
      if (command == mav::kCmdDoSetMode) hear_mode(double{field<float>(m, 4)}, n);
      hear_command(command, field<float>(m, 0), target, frame, p, n);
      break;
    }
    default:
      break;
  }
}

void MavlinkEar::hear_mode(double mode, Moment& n) const {
  if (mode == app::mode::kManual) ++n.asked[Ask::kManual];
  if (mode == app::mode::kFormation) ++n.asked[Ask::kFormation];
}

void MavlinkEar::hear_command(std::uint16_t command, float first, link::Address target,
                              const Frame& frame, const app::Parameters& p, Moment& n) const {
  const bool mine = !companion_ && (target.system == 0 || target.system == self_.system) &&
                    (target.component == 0 || target.component == self_.component);
  if (command == mav::kCmdComponentArmDisarm && first == 0) {
    n.heard.disarm = true;
    n.heard.stop = n.heard.stop || mine;
  } else if (command == mav::kCmdComponentArmDisarm) {
    const auto system = static_cast<float>(frame.from.system);
    ++n.asked[Ask::kArm];
    if (p.MAV_GCS_SYSID == 0 || p.MAV_GCS_SYSID == system) ++n.asked[Ask::kArmAllowed];
    n.heard.stop = false;
  } else if (command == mav::kCmdDoMotorTest) {
    ++n.asked[Ask::kTest];
  } else if (command == mav::kCmdDoFlightTermination) {
    ++n.asked[Ask::kTerminate];
    n.heard.stop = false;
  }
}

void MavlinkEar::read(Bytes bytes, std::size_t number, Moment& n) {
  Link& link = links_[number];
  link.beats = false;
  n.links.longest = std::max(n.links.longest, static_cast<std::uint16_t>(bytes.size()));
  bool own = false;
  while (!bytes.empty()) {
    const auto frame = frame_at(bytes);
    if (!frame) {
      n.links.whole = false;
      return;
    }
    bytes = bytes.subspan(frame->size);
    if (frame->from == self_ || (companion_ && frame->from.component == self_.component)) {
      own = true;
      n.links.counted = n.links.counted && (!link.counts || link.sequence == frame->sequence);
      link.counts = true;
      link.sequence = static_cast<std::uint8_t>(frame->sequence + 1U);
      read_own(*frame, link, n);
    } else {
      n.links.ours = n.links.ours && heard_.test(frame->from.system);
      n.links.others_first = n.links.others_first && !own;
    }
  }
}

void MavlinkEar::read_own(const Frame& frame, Link& link, Moment& n) {
  const Bytes m = frame.payload;
  const Numbers numbers = numbers_of(frame.id);
  if (numbers.has_time) {
    // What was requested is made of the report of the tick before.
    const auto now_ms = static_cast<std::uint32_t>(n.now_us / 1000),
               before_ms = static_cast<std::uint32_t>((n.now_us - n.dt_us) / 1000);
    const auto told_ms = field<std::uint32_t>(m, 0);
    n.links.punctual = n.links.punctual && (told_ms == now_ms || told_ms == before_ms);
  }
  n.links.finite = n.links.finite && finite(m, numbers);
  switch (frame.id) {
    case mav::kHeartbeatId:
      n.links.mode = field<std::uint8_t>(m, 0);
      n.links.flags = field<std::uint8_t>(m, 6);
      n.links.status = field<std::uint8_t>(m, 7);
      link.beats = true;
      link.beat_us = n.now_us;
      break;
    case mav::kAttitudeId:
    case mav::kLocalPositionNedId:
    case mav::kGlobalPositionIntId:
    case mav::kOdometryId:
    case mav::kFollowTargetId:
      n.links.places = true;
      break;
    case kTimesync:
      if (field<std::int64_t>(m, 0) == 0) link.timesync_us = n.now_us;
      break;
    case kCommandAck:
      ++n.done[Ask::kAck];
      break;
    case kStatustext: {
      const auto text = field<link::Text<50>>(m, 1);
      n.links.gravest = std::min(n.links.gravest, field<std::uint8_t>(m, 0));
      n.links.states_word =
          n.links.states_word ||
          std::string_view(text.data(), text.size()).starts_with(app::name_of(n.state));
      break;
    }
    default:
      break;
  }
}

void MavlinkEar::note_times(std::size_t links, Moment& n) const {
  n.beat_us = n.timesync_us = n.now_us;
  n.links.beats = links > 0;
  for (std::size_t i = 0; i < links; ++i) {
    n.beat_us = std::min(n.beat_us, links_[i].beat_us);
    n.timesync_us = std::min(n.timesync_us, links_[i].timesync_us);
    n.links.beats = n.links.beats && links_[i].beats;
  }
}

}  // namespace flotilla::policies
