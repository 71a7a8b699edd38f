// SPDX-License-Identifier: MIT
#include "policies/mavlink_ear.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "app/convert/convert.hpp"
#include "app/operator/telemetry/text.hpp"

namespace flotilla::policies {
namespace {

namespace mav = link::mav;
using Bytes = std::span<const std::uint8_t>;

constexpr std::uint8_t kVersion1 = 0xFE, kVersion2 = 0xFD, kSigned = 1;
// Messages without a name in link::mav.
constexpr std::uint32_t kFleetTableId = 53103;
constexpr std::uint32_t kSetModeId = 11, kParamValueId = 22, kRcChannelsId = 65,
                        kManualControlId = 69, kRcOverrideId = 70, kCommandIntId = 75,
                        kCommandLongId = 76, kCommandAckId = 77, kTimesyncId = 111,
                        kStatustextId = 253;

template <class T>
T field(Bytes payload, std::size_t at) {
  T value{};
  if (at + sizeof value <= payload.size()) {
    std::memcpy(&value, payload.data() + at, sizeof value);
  } else if (at < payload.size()) {
    std::memcpy(&value, payload.data() + at, payload.size() - at);
  }
  return value;
}

/// The frame at the beginning of these bytes, if complete.
inline Frame frame_at(Bytes b) {
  if (b.size() < 8) return {};
  const std::uint8_t length = b[1];
  if (b[0] == kVersion2 && b.size() >= 12 && (b[2] & ~kSigned) == 0 && length > 0) {
    const std::size_t size = 12U + length + (b[2] != 0 ? 13U : 0U);
    if (size > b.size()) return {};
    const std::uint32_t id = field<std::uint32_t>(b, 6) >> 8U;
    return {size, {b[5], b[6]}, b[4], id, b.subspan(10, length)};
  }
  if (b[0] != kVersion1 || b.size() < 8U + length) return {};
  return {8U + length, {b[3], b[4]}, b[2], b[5], b.subspan(6, length)};
}

/// Time of the position in the message, by the sender's clock; nothing for other messages.
std::optional<std::int64_t> stamp_us(const Frame& frame) {
  constexpr std::int64_t kMs = 1000;
  constexpr std::uint64_t kLatest_us = 1ULL << 60U;
  const auto sane = [](std::uint64_t stamp, std::uint64_t unit_us) -> std::optional<std::int64_t> {
    if (stamp > kLatest_us / unit_us) return std::nullopt;
    return static_cast<std::int64_t>(stamp * unit_us);
  };
  switch (frame.id) {
    case link::LocalPositionNed::kId:
    case link::GlobalPositionInt::kId:
      return field<std::uint32_t>(frame.payload, 0) * kMs;
    case link::FollowTarget::kId:
      return sane(field<std::uint64_t>(frame.payload, 0), kMs);
    case link::Odometry::kId:
      return sane(field<std::uint64_t>(frame.payload, 0), 1);
    default:
      return std::nullopt;
  }
}

void note_truth(const std::optional<std::int64_t>& ahead_us, std::int64_t stamp_us,
                std::int64_t now_us, std::int64_t& newest_us) {
  if (!ahead_us) return;
  newest_us = std::max(newest_us, app::convert::unwrapped_us(stamp_us - *ahead_us, now_us));
}

/// Ids of requests.
constexpr std::array<bool, 128> kIsRequest = [] {
  std::array<bool, 128> are{};
  for (const auto id : {kSetModeId, kRcChannelsId, kManualControlId, kRcOverrideId, kCommandIntId,
                        kCommandLongId}) {
    are[id] = true;
  }
  return are;
}();

/// The parts of a message that rules check.
enum class Kind : std::uint8_t { kOther, kBeat, kPlace, kTimesync, kAck, kText };
struct Contents {
  Kind kind = Kind::kOther;
  bool has_time = false;  ///< begins with time since boot, ms
  std::uint8_t first =
      0;  ///< offset of the floating-point numbers on the wire: largest types first
  std::uint8_t count = 0;  ///< how many there are
};

/// ESC messages are left out: their unknown values are NaN, and are forwarded as such.
constexpr std::size_t kIds = 512;
constexpr std::array<Contents, kIds> kContents = [] {
  std::array<Contents, kIds> of{};
  of[link::Heartbeat::kId].kind = Kind::kBeat;
  of[kTimesyncId].kind = Kind::kTimesync;
  of[kCommandAckId].kind = Kind::kAck;
  of[kStatustextId].kind = Kind::kText;
  of[link::Attitude::kId] = of[link::LocalPositionNed::kId] = {Kind::kPlace, true, 4, 6};
  of[link::GlobalPositionInt::kId] = {Kind::kPlace, true};
  of[link::FollowTarget::kId] = {Kind::kPlace, false, 24, 14};
  of[link::Odometry::kId] = {Kind::kPlace, false, 8, 13};
  of[link::PositionTargetLocalNed::kId] = {Kind::kOther, true, 4, 11};
  of[link::NamedValueFloat::kId] = {Kind::kOther, true, 4, 1};
  of[link::NavControllerOutput::kId] = {Kind::kOther, false, 0, 5};
  of[link::VfrHud::kId] = {Kind::kOther, false, 0, 4};
  of[link::HomePosition::kId] = {Kind::kOther, false, 12, 10};
  of[kParamValueId] = {Kind::kOther, false, 0, 1};
  return of;
}();

/// A truncated number ends in zeros and is finite. Checks two at a time: an exponent of ones plus 1
/// carries into the sign's bit.
inline bool finite(Bytes payload, const Contents& contents) {
  constexpr std::uint64_t kExponents = 0x7F80'0000'7F80'0000, kOnes = 0x0080'0000'0080'0000,
                          kSigns = 0x8000'0000'8000'0000;
  if (contents.count == 0 || payload.size() < contents.first) return true;
  const std::size_t count =
      std::min<std::size_t>(contents.count, (payload.size() - contents.first) / 4);
  const std::uint8_t* at = payload.data() + contents.first;
  std::uint64_t wrong = 0;
  for (std::size_t pair = 0; pair < count / 2; ++pair, at += 8) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, at, 8);
    wrong |= (bits & kExponents) + kOnes;
  }
  if (count % 2 != 0) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, at, 4);
    wrong |= (bits & kExponents) + kOnes;
  }
  return (wrong & kSigns) == 0;
}

/// MANUAL_CONTROL's axes ahead and to starboard.
bool is_neutral(Bytes sticks) {
  constexpr int kTenth = 100;
  return std::abs(field<std::int16_t>(sticks, 0)) <= kTenth &&
         std::abs(field<std::int16_t>(sticks, 6)) <= kTenth;
}

/// Channels 1 and 3, µs; the channels begin at offset `at` of the payload.
bool is_centred(Bytes channels, std::size_t at) {
  constexpr int kTenth_us = 40;
  return std::abs(field<std::uint16_t>(channels, at) - 1500) <= kTenth_us &&
         std::abs(field<std::uint16_t>(channels, at + 4) - 1500) <= kTenth_us;
}

/// A mode in the form that ArduPilot Rover's clients send: 1, mode and zeros. From PX4 clients the
/// same number means another mode.
bool is_rovers(Bytes command) {
  if (field<float>(command, 0) != 1) return false;
  for (std::size_t at = 8; at < 28; at += 4) {
    if (field<float>(command, at) != 0) return false;
  }
  return true;
}

/// PX4's AUTO.MISSION: main mode 4, sub mode 4.
bool is_px4s(float sub_mode, Bytes command) {
  return field<float>(command, 4) == 4 && field<float>(command, 8) == sub_mode;
}

}  // namespace

MavlinkEar::MavlinkEar(const app::Parameters& p)
    : self_{static_cast<std::uint8_t>(p.MAV_SYSID), static_cast<std::uint8_t>(p.MAV_COMPID)},
      companion_(p.MAV_IDENTITY == 1.0F) {}

bool MavlinkEar::hear(Bytes bytes, const app::Parameters& p, Moment& n) {
  const std::uint8_t leader = n.leader;
  while (!bytes.empty()) {
    const Frame frame = frame_at(bytes);
    if (frame.size == 0) return false;
    bytes = bytes.subspan(frame.size);
    const std::uint8_t system = frame.from.system;
    heard_.set(system);
    n.heard.own |= companion_ || system == self_.system;
    n.heard.leader |= system == leader;
    n.in_fleet |= frame.id == kFleetTableId;
    if (const auto stamp = stamp_us(frame)) {
      if (system == self_.system) note_truth(n.clocks.own_us, *stamp, n.now_us, n.own_true_us);
      if (system == leader) note_truth(n.clocks.leader_us, *stamp, n.now_us, n.leader_true_us);
    }
    if (frame.id < kIsRequest.size() && kIsRequest[frame.id] && frame.from != self_) {
      hear_request(frame.id, frame.from, frame.payload, p, n);
    }
  }
  return true;
}

void MavlinkEar::hear_request(std::uint32_t id, link::Address from, Bytes m,
                              const app::Parameters& p, Moment& n) const {
  switch (id) {
    case kManualControlId:
      n.heard.sticks = true;
      n.heard.neutral |= is_neutral(m);
      break;
    case kRcChannelsId:
    case kRcOverrideId:
      if (p.RC_MODE_CH == 0) break;
      n.heard.sticks = true;
      ++n.asked[Ask::kManual];
      n.heard.neutral |= is_centred(m, id == kRcChannelsId ? 4 : 0);
      break;
    case kSetModeId:
      hear_mode(field<std::uint32_t>(m, 0), n);
      break;
    case kCommandLongId:
    case kCommandIntId: {
      const auto command = field<std::uint16_t>(m, 28);
      const link::Address target{field<std::uint8_t>(m, 30), field<std::uint8_t>(m, 31)};
      ++n.asked[Ask::kAck];
      const double mode{field<float>(m, 4)};
      if (command == mav::kCmdDoSetMode && (mode != app::mode::kFormation || is_rovers(m))) {
        hear_mode(is_px4s(4, m) ? app::mode::kAuto : is_px4s(5, m) ? app::mode::kReturn : mode, n);
      }
      if (command == mav::kCmdMissionStart ||
          (command == mav::kCmdDoSetStandardMode && field<float>(m, 0) == 6)) {
        ++n.asked[Ask::kAuto];
      }
      if (command == mav::kCmdNavReturnToLaunch ||
          (command == mav::kCmdDoSetStandardMode && field<float>(m, 0) == 5)) {
        ++n.asked[Ask::kReturn];
      }
      if (command == mav::kCmdDoReposition) ++n.asked[Ask::kGuided];
      hear_command({command, field<float>(m, 0)}, from, target, p, n);
      break;
    }
    default:
      break;
  }
}

void MavlinkEar::hear_mode(double mode, Moment& n) const {
  if (mode == app::mode::kManual) ++n.asked[Ask::kManual];
  if (mode == app::mode::kFormation) ++n.asked[Ask::kFormation];
  if (mode == app::mode::kAuto) ++n.asked[Ask::kAuto];
  if (mode == app::mode::kGuided) ++n.asked[Ask::kGuided];
  if (mode == app::mode::kLoiter) ++n.asked[Ask::kLoiter];
  if (mode == app::mode::kReturn) ++n.asked[Ask::kReturn];
}

void MavlinkEar::hear_command(Order order, link::Address from, link::Address target,
                              const app::Parameters& p, Moment& n) const {
  const auto [command, first] = order;
  const bool mine = !companion_ && (target.system == 0 || target.system == self_.system) &&
                    (target.component == 0 || target.component == self_.component);
  if (command == mav::kCmdComponentArmDisarm && first == 0) {
    n.heard.disarm = true;
    n.heard.stop = n.heard.stop || mine;
  } else if (command == mav::kCmdComponentArmDisarm) {
    const auto system = static_cast<float>(from.system);
    ++n.asked[Ask::kArm];
    if (p.MAV_GCS_SYSID == 0 || p.MAV_GCS_SYSID == system) ++n.asked[Ask::kArmAllowed];
  } else if (command == mav::kCmdDoMotorTest) {
    ++n.asked[Ask::kTest];
  } else if (command == mav::kCmdDoFlightTermination) {
    ++n.asked[Ask::kTerminate];
    n.heard.stop = false;
  }
}

void MavlinkEar::read_own(const Frame& frame, Link& link, Moment& n) {
  const Bytes m = frame.payload;
  if (frame.id >= kIds) return;
  const Contents& contents = kContents[frame.id];
  // Answers to requests use the report of the previous tick.
  if (contents.has_time) {
    const auto told_ms = field<std::uint32_t>(m, 0);
    n.links.punctual &= told_ms == n.now_ms || told_ms == n.before_ms;
  }
  n.links.finite &= finite(m, contents);
  switch (contents.kind) {
    case Kind::kBeat:
      n.links.mode = field<std::uint8_t>(m, 0);
      n.links.flags = field<std::uint8_t>(m, 6);
      n.links.status = field<std::uint8_t>(m, 7);
      link.beats = true;
      link.beat_us = n.now_us;
      break;
    case Kind::kPlace:
      n.links.places = true;
      break;
    case Kind::kTimesync:
      if (field<std::int64_t>(m, 0) == 0) link.timesync_us = n.now_us;
      break;
    case Kind::kAck:
      ++n.done[Ask::kAck];
      break;
    case Kind::kText: {
      const auto text = field<link::Text<50>>(m, 1);
      n.links.gravest = std::min(n.links.gravest, field<std::uint8_t>(m, 0));
      n.links.states_word |=
          std::string_view(text.data(), text.size()).starts_with(app::name_of(n.state));
      break;
    }
    case Kind::kOther:
      break;
  }
}

void MavlinkEar::read(Bytes bytes, std::size_t number, Moment& n) {
  Link& link = links_[number];
  link.beats = false;
  n.links.longest = std::max(n.links.longest, static_cast<std::uint16_t>(bytes.size()));
  bool own = false;
  while (!bytes.empty()) {
    const Frame frame = frame_at(bytes);
    if (frame.size == 0) {
      n.links.whole = false;
      return;
    }
    bytes = bytes.subspan(frame.size);
    if (frame.from == self_ || (companion_ && frame.from.component == self_.component)) {
      own = true;
      n.links.counted &= !link.counts || link.sequence == frame.sequence;
      link.counts = true;
      link.sequence = static_cast<std::uint8_t>(frame.sequence + 1U);
      read_own(frame, link, n);
    } else {
      n.links.ours &= heard_.test(frame.from.system);
      n.links.others_first &= !own;
    }
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
