// SPDX-License-Identifier: MIT
#include "app/operator/requests/commands.hpp"

#include <algorithm>
#include <cmath>

#include "app/convert/portable.hpp"
#include "app/parameters.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::Request;

constexpr double kForce = 21196;
constexpr double kMaxTestPercent = 20, kLongestTest_s = 5;
constexpr double kThrottlePercent = 0;  // MOTOR_TEST_THROTTLE_PERCENT
constexpr std::string_view kAllModes = "use mode 0, 4, 5, 6, 10, 11 or 15";
constexpr double kLongestInterval_us = 2147483647;  // MESSAGE_INTERVAL's maximum

DecodedCommand denied(std::string_view why = {}) {
  DecodedCommand asked{mav::kDenied};
  asked.why = why;
  return asked;
}

/// Unused parameters are 0 or NaN.
bool unused(double param) { return std::isnan(param) || param == 0; }

/// An integer from 0 to `most`, or nothing.
std::optional<std::uint32_t> whole(double param, double most) {
  if (!(param >= 0 && param <= most)) return std::nullopt;
  const auto number = static_cast<std::uint32_t>(param);
  return number == param ? std::optional(number) : std::nullopt;
}

/// The parameter "force" is allowed, but overrides no check.
DecodedCommand arm_or_disarm(const Command& c) {
  if (c.param[0] == 0) return {mav::kAccepted, Request::kDisarm};
  const bool force_is_legal = unused(c.param[1]) || c.param[1] == kForce;
  if (c.param[0] == 1 && force_is_legal) return {mav::kAccepted, Request::kArm};
  return denied("force cannot skip checks");
}

std::optional<Request> request_of(double number) {
  if (number == mode::kManual) return Request::kManual;
  if (number == mode::kHold) return Request::kHold;
  if (number == mode::kLoiter) return Request::kLoiter;
  if (number == mode::kFormation) return Request::kFormation;
  if (number == mode::kAuto) return Request::kAuto;
  if (number == mode::kReturn) return Request::kReturn;
  if (number == mode::kGuided) return Request::kGuided;
  return std::nullopt;
}

/// In SET_MODE a number identifies an ArduPilot Rover mode: PX4's are multiples of 65536 there. In
/// MAV_CMD_DO_SET_MODE it is ambiguous: (6, 0) is Rover's FOLLOW or PX4's OFFBOARD. It counts as
/// FOLLOW only in the form that Rover's clients send: 1, 6 and zeros. MAVSDK, which treats a
/// GENERIC autopilot as a PX4, leaves the unused parameters NaN.
DecodedCommand set_mode(const Command& c) {
  // PX4's AUTO.LOITER means HOLD, which stops the boat; AUTO.MISSION means AUTO, AUTO.RTL RTL.
  constexpr double kLoiter = 3, kMission = 4, kReturn = 5;
  constexpr std::uint32_t kTold = mav::kModeFlagCustom | mav::kModeFlagArmed;
  const auto base = whole(c.param[0], 255);
  const double number = c.param[1], sub_mode = c.param[2];
  if (!base || (*base & mav::kModeFlagCustom) == 0) return denied(kAllModes);
  if (number == mode::kHold && (unused(sub_mode) || sub_mode == kLoiter)) {
    return {mav::kAccepted, Request::kHold};
  }
  if (number == mode::kHold && sub_mode == kMission) return {mav::kAccepted, Request::kAuto};
  if (number == mode::kHold && sub_mode == kReturn) return {mav::kAccepted, Request::kReturn};
  const auto request = request_of(number);
  const bool plain = !c.wants_ack || (*base & ~kTold) == 0;  // SET_MODE echoes the heartbeat's
  if (!unused(sub_mode) || !request) return denied(kAllModes);
  if (number != mode::kFormation) {
    return plain ? DecodedCommand{mav::kAccepted, *request} : denied(kAllModes);
  }
  const bool rovers =
      *base == mav::kModeFlagCustom &&
      std::ranges::all_of(c.param.begin() + 2, c.param.end(), [](double x) { return x == 0; });
  if (c.wants_ack && !rovers) return denied("mode 6 of a PX4 client is OFFBOARD");
  return {mav::kAccepted, Request::kFormation};
}

/// One propeller, 1 port or 2 starboard, in percent of its greatest thrust, for a limited time.
DecodedCommand motor_test(const Command& c) {
  const auto propeller = whole(c.param[0], 2);
  const double percent = c.param[2], time_s = c.param[3];
  const bool one_only = unused(c.param[4]) || c.param[4] == 1;
  if (!propeller || *propeller == 0 || c.param[1] != kThrottlePercent || !one_only ||
      !(std::abs(percent) <= kMaxTestPercent) || !(time_s > 0 && time_s <= kLongestTest_s)) {
    return denied();
  }
  DecodedCommand asked{mav::kAccepted, Request::kTest};
  asked.repeated = c.repeated;
  asked.motor_test =
      MotorTest{*propeller == 2, percent / 100, static_cast<std::int64_t>(time_s * 1e6)};
  return asked;
}

DecodedCommand set_standard_mode(const Command& c) {
  if (c.param[0] == mav::kStandardModeMission) return {mav::kAccepted, Request::kAuto};
  if (c.param[0] == mav::kStandardModeSafeRecovery) return {mav::kAccepted, Request::kReturn};
  return {mav::kFailed};
}

/// Heading and radius do not apply to boats and are ignored. COMMAND_LONG is refused: its degrees
/// are floats, with errors of metres.
DecodedCommand reposition(const Command& c) {
  constexpr double kChangesMode = 1;
  if (!c.frame) return {mav::kCommandIntOnly};
  if (!is_global(*c.frame)) return {mav::kUnsupportedFrame};
  const bool changes = c.param[1] == kChangesMode;
  if (!changes && !unused(c.param[1])) return denied();
  DecodedCommand asked{mav::kAccepted, changes ? Request::kGuided : Request::kNone};
  const bool fast = !std::isnan(c.param[0]) && c.param[0] != -1 && c.param[0] != 0;
  const convert::GlobalPoint place{static_cast<std::int32_t>(c.param[4]),
                                   static_cast<std::int32_t>(c.param[5])};
  const bool valid = convert::is_valid({place.latitude, place.longitude, 0, 0});
  if (!valid) return denied("invalid position");
  asked.target = Target{place, fast ? static_cast<float>(c.param[0]) : 0.0F};
  return asked;
}

DecodedCommand start_plan(const Command& c) {
  const bool whole_plan = unused(c.param[0]) && unused(c.param[1]);
  if (!whole_plan) return denied("first and last item must be 0");
  return {mav::kAccepted, Request::kAuto};
}

DecodedCommand pause(const Command& c) {
  if (c.param[0] != 0 && c.param[0] != 1) return denied();
  DecodedCommand asked{mav::kAccepted};
  asked.paused = c.param[0] == 0;
  return asked;
}

/// Switches the fence of polygons and circles on or off; FS_FENCE_M is a parameter.
DecodedCommand enable_fence(const Command& c) {
  const auto types = unused(c.param[1]) ? mav::kFencePolygon : whole(c.param[1], 65535);
  if (c.param[0] != 0 && c.param[0] != 1) return denied("fence: 1 is on, 0 is off");
  if (!types || (*types & mav::kFencePolygon) == 0) return denied("fence type is not polygon");
  DecodedCommand asked{mav::kAccepted};
  asked.fence = c.param[0] == 1;
  return asked;
}

DecodedCommand set_item(const Command& c) {
  const auto item = whole(c.param[0], 65535);
  const bool anew = c.param[1] == 1;
  if (!item || !(anew || unused(c.param[1]))) return denied();
  DecodedCommand asked{mav::kAccepted};
  asked.item = *item;
  asked.anew = anew;
  return asked;
}

DecodedCommand terminate(const Command& c) {
  if (c.param[0] != 1) return denied();  // 0 ("do not terminate") does not leave FAULT either
  return {mav::kAccepted, Request::kTerminate};
}

DecodedCommand storage(const Command& c) {
  if (c.param[0] != 1) return denied();
  DecodedCommand asked{mav::kAccepted};
  asked.save_parameters = true;
  return asked;
}

DecodedCommand message(double id_param, double index_param) {
  const auto id = whole(id_param, 65535);
  const auto index = std::isnan(index_param) ? 0 : whole(index_param, 65535);
  if (!id || !index) return denied();
  DecodedCommand asked{mav::kAccepted};
  asked.message = MessageRequest{static_cast<std::uint16_t>(*id), *index};
  return asked;
}

DecodedCommand message_rate(const Command& c) {
  const auto id = whole(c.param[0], 65535);
  const double interval = c.param[1];
  if (!id || !(interval >= -1 && interval <= kLongestInterval_us)) return denied();
  DecodedCommand asked{mav::kAccepted};
  asked.rate =
      MessageRate{static_cast<std::uint16_t>(*id), interval < 0 ? -1 : portable::ceil(interval)};
  return asked;
}

DecodedCommand failure(const Command& c) {
  const auto unit = whole(c.param[0], 255), type = whole(c.param[1], 255);
  const auto instance = std::isnan(c.param[2]) ? 0 : whole(c.param[2], 255);
  DecodedCommand asked;
  if (!unit || !type || !instance) return asked;
  asked.failure = Failure{static_cast<std::uint8_t>(*unit), static_cast<std::uint8_t>(*type),
                          static_cast<std::uint8_t>(*instance)};
  return asked;
}

}  // namespace

std::optional<Command> command_of(const RequestMessage& message) {
  if (const auto* c = std::get_if<link::CommandLong>(&message)) {
    Command out{c->command, {}, c->target, c->confirmation > 0};
    for (std::size_t i = 0; i < out.param.size(); ++i) out.param[i] = double{c->param[i]};
    return out;
  }
  if (const auto* c = std::get_if<link::CommandInt>(&message)) {
    return Command{c->command,
                   {double{c->param[0]}, double{c->param[1]}, double{c->param[2]},
                    double{c->param[3]}, double(c->x), double(c->y), double{c->z}},
                   c->target,
                   false,
                   true,
                   c->frame};
  }
  if (const auto* m = std::get_if<link::SetMode>(&message)) {
    return Command{mav::kCmdDoSetMode,
                   {double(m->base_mode), double(m->custom_mode)},
                   {m->target_system, 0},
                   false,
                   false};
  }
  if (is_go_here(message)) {
    const auto& m = std::get<link::MissionItemInt>(message);
    constexpr double kSameSpeed = -1;
    return Command{mav::kCmdDoReposition,
                   {kSameSpeed, 0, 0, 0, double(m.x), double(m.y), double{m.z}},
                   m.target,
                   false,
                   false,
                   m.frame};
  }
  if (const auto* m = std::get_if<link::MissionSetCurrent>(&message)) {
    return Command{mav::kCmdDoSetMissionCurrent, {double(m->seq)}, m->target, false, false};
  }
  return std::nullopt;
}

bool is_go_here(const RequestMessage& message) {
  constexpr std::uint8_t kGoHere = 2;
  const auto* m = std::get_if<link::MissionItemInt>(&message);
  return m != nullptr && m->current == kGoHere && m->command == mav::kNavWaypoint &&
         m->mission_type == mav::kMissionTypePlan;
}

bool is_disarm(const Command& c) { return c.id == mav::kCmdComponentArmDisarm && c.param[0] == 0; }

bool is_stop(const Command& c) {
  return is_disarm(c) || (c.id == mav::kCmdDoFlightTermination && c.param[0] == 1);
}

bool stops_boat(const Command& c) {
  return core::kind_of(meaning_of(c).request) == core::RequestKind::kStops;
}

bool stops_boat(const link::Message& message) {
  RequestMessage asked;
  if (const auto* c = std::get_if<link::CommandLong>(&message)) asked = *c;
  if (const auto* c = std::get_if<link::CommandInt>(&message)) asked = *c;
  if (const auto* m = std::get_if<link::SetMode>(&message)) asked = *m;
  const auto command = command_of(asked);
  return command && stops_boat(*command);
}

/// Items of an upload overwrite nothing, because they are numbered.
[[gnu::noinline]] Effects effects_of(const RequestMessage& request, bool may_command) {
  Effects out;
  const auto command = command_of(request);
  if (!command) {
    out.overwrites = std::holds_alternative<link::ParamSet>(request) ||
                     std::holds_alternative<link::MissionCount>(request) ||
                     std::holds_alternative<link::MissionClearAll>(request);
    return out;
  }
  const DecodedCommand asked = meaning_of(*command);
  const bool stops = core::kind_of(asked.request) == core::RequestKind::kStops;
  out.ends = is_stop(*command);
  out.stops = may_command ? stops : out.ends;
  out.asks_state = asked.request != Request::kNone;
  out.reads = asked.reads_only();
  out.overwrites = !out.reads && !stops;
  return out;
}

DecodedCommand meaning_of(const Command& c) {
  switch (c.id) {
    case mav::kCmdComponentArmDisarm:
      return arm_or_disarm(c);
    case mav::kCmdDoSetMode:
      return set_mode(c);
    case mav::kCmdDoMotorTest:
      return motor_test(c);
    case mav::kCmdMissionStart:
      return start_plan(c);
    case mav::kCmdDoReposition:
      return reposition(c);
    case mav::kCmdNavReturnToLaunch:
      return {mav::kAccepted, Request::kReturn};
    case mav::kCmdDoPauseContinue:
      return pause(c);
    case mav::kCmdDoSetMissionCurrent:
      return set_item(c);
    case mav::kCmdDoFenceEnable:
      return enable_fence(c);
    case mav::kCmdDoFlightTermination:
      return terminate(c);
    case mav::kCmdPreflightStorage:
      return storage(c);
    case mav::kCmdRequestMessage:
      return message(c.param[0], c.param[1]);
    case mav::kCmdGetMessageInterval:
      return whole(c.param[0], 65535) ? message(link::MessageInterval::kId, c.param[0]) : denied();
    case mav::kCmdGetHomePosition:
      return message(link::HomePosition::kId, 0);
    case mav::kCmdRequestAutopilotCapabilities:
      return message(link::AutopilotVersion::kId, 0);
    case mav::kCmdRequestProtocolVersion:
      return message(link::ProtocolVersion::kId, 0);
    case mav::kCmdSetMessageInterval:
      return message_rate(c);
    case mav::kCmdInjectFailure:
      return failure(c);
    case mav::kCmdDoSetStandardMode:
      return set_standard_mode(c);
    default:
      return {mav::kUnsupported};
  }
}

}  // namespace flotilla::app
