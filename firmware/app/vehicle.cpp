// SPDX-License-Identifier: MIT
#include "app/vehicle.hpp"

#include <algorithm>
#include <type_traits>

#include "app/convert.hpp"
#include "app/metadata.hpp"
#include "app/text.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::Request;
using core::State;

constexpr std::int64_t kSecond_us = 1'000'000;
constexpr std::int64_t kSticksSilent_us = 500'000, kRepeated_us = 2'000'000;
// Of a tick's 1400 bytes, for the heartbeat, the state and 24 answers.
constexpr std::size_t kKeptRoom = 1000;

std::uint8_t mode_of(State state) {
  switch (state) {
    case State::kManual:
      return mode::kManual;
    case State::kFormation:
      return mode::kFormation;
    default:
      return mode::kHold;
  }
}

/// Driving, and what leads there: in companion identity the autopilot's business, where it is asked
/// of the whole system.
bool drives(Request request) { return request != Request::kNone && request != Request::kDisarm; }

/// Whether it is for the tick to answer.
struct IsRequest {
  bool operator()(const link::Timesync& m) const { return m.tc1 == 0; }
  bool operator()(const link::Ping& m) const { return m.target == link::Address{}; }
  template <class Message>
  bool operator()(const Message&) const {
    return is_one_of<Message, link::CommandLong, link::CommandInt, link::SetMode,
                     link::ParamRequestList, link::ParamRequestRead, link::ParamSet,
                     link::FileTransferProtocol, link::MissionRequestList, link::MissionCount,
                     link::MissionClearAll>;
  }
  template <class Message, class... Requests>
  static constexpr bool is_one_of = (std::is_same_v<Message, Requests> || ...);
};

bool asks_for_message(const Letter& letter) {
  const auto command = command_of(letter.received.message);
  return command && meaning_of(*command).message;
}

}  // namespace

Vehicle::Vehicle(const Parameters& p, std::size_t links)
    : parameters_(p),
      identity_(p),
      links_(links, identity_.self()),
      ftp_(metadata_files()),
      streams_(p, identity_.companion(), convert::period_us(p.CTL_RATE)),
      heartbeat_due_(kSecond_us, convert::half_period_us(p.CTL_RATE)),
      timesync_due_(kSecond_us, convert::half_period_us(p.CTL_RATE)),
      refusal_due_(kSecond_us / 2),
      double_due_(10 * kSecond_us) {
  parameters_.MODE = mode::kHold;
  freshen();
}

void Vehicle::freshen() {
  report_.self = self();
  report_.mode = mode_of(state_);
  report_.intended_mode = intended_mode_;
}

std::optional<link::Received> Vehicle::next(std::size_t link, std::int64_t now_us,
                                            link::Counters& counters) {
  while (const auto received = links_.next(link, counters)) {
    const auto* beat = std::get_if<link::Heartbeat>(&received->message);
    if (received->from == self()) {
      double_seen_ = double_seen_ || (beat != nullptr && !links_.is_echo(*received));
      continue;
    }
    router_.heard(received->from, link);
    if (beat != nullptr) identity_.heard(received->from, *beat, parameters_.FORM_LEADER, now_us);
    hand_on(link, *received, counters);
    if (!identity_.addressed(received->target)) continue;
    if (const auto* sticks = std::get_if<link::ManualControl>(&received->message)) {
      take_sticks(*received, *sticks, now_us, counters);
    } else if (const auto* radio = std::get_if<link::RadioStatus>(&received->message)) {
      streams_.radio_has_room(link, radio->txbuf);
    } else if (std::visit(IsRequest{}, received->message)) {
      inbox_.push({link, *received, now_us}, counters);
    } else {
      return received;
    }
  }
  return std::nullopt;
}

void Vehicle::hand_on(std::size_t link, const link::Received& received, link::Counters& counters) {
  if (received.target == self() || received.id == mav::kSetupSigningId) return;  // nobody's secret
  const std::uint8_t beyond = router_.beyond(received.target, link);
  for (std::size_t other = 0; other < links_.count(); ++other) {
    if ((beyond >> other & 1U) != 0) {
      links_.forward(other, links_.decoder(link).frame(), counters);
    }
  }
}

void Vehicle::take_sticks(const link::Received& received, const link::ManualControl& message,
                          std::int64_t now_us, link::Counters& counters) {
  const auto surge = convert::stick_of(message.x), yaw = convert::stick_of(message.r);
  if (!surge || !yaw) {
    ++counters.mavlink_bad_value;
  } else if (may_command(received.from) && !identity_.is_autopilots(received.target)) {
    sticks_ = {*surge, *yaw};
    sticks_us_ = now_us;
  }
}

bool Vehicle::may_command(link::Address from) const {
  return parameters_.MAV_GCS_SYSID == 0.0F ||
         static_cast<float>(from.system) == parameters_.MAV_GCS_SYSID;
}

void Vehicle::begin(std::int64_t now_us, std::int64_t dt_us) {
  now_us_ = now_us;
  links_.begin(dt_us);
  if (identity_.latch(now_us)) {
    links_.rename(identity_.self());
    changed_ = true;
  }
}

core::Conditions Vehicle::conditions(std::int64_t now_us) const {
  core::Conditions met = 0;
  if (sticks_us_ && now_us - *sticks_us_ < kSticksSilent_us) met |= core::kSticksFresh;
  if (test_ && now_us < test_end_us_) met |= core::kTestRunning;
  return met;
}

void Vehicle::heed(core::Conditions conditions, link::Counters& counters) {
  conditions_ = conditions;
  const core::Verdict verdict = core::supervise(state_, Request::kNone, conditions_);
  if (verdict.granted) enter(verdict.state, verdict.missing, counters);
}

void Vehicle::answer(std::int64_t now_us, link::Counters& counters) {
  inbox_.take_each([&](const Letter& letter) {
    // What brings further messages waits until the heartbeat and the state have their room too.
    if (asks_for_message(letter) && links_.room(letter.link) < kKeptRoom) return false;
    answer(letter, now_us, counters);
    return true;
  });
  if (std::exchange(disarm_, false) && state_ != State::kDisarmed) {
    enter(State::kDisarmed, 0, counters);
  }
}

void Vehicle::answer(const Letter& letter, std::int64_t now_us, link::Counters& counters) {
  const auto& [link, received, read_us] = letter;
  const link::Address from = received.from;
  if (const auto command = command_of(received.message)) {
    execute(letter, *command, now_us, counters);
  } else if (std::holds_alternative<link::ParamRequestList>(received.message)) {
    parameter_service_.list(link);
  } else if (const auto* read = std::get_if<link::ParamRequestRead>(&received.message)) {
    parameter_service_.read(link, from, *read);
  } else if (const auto* set = std::get_if<link::ParamSet>(&received.message)) {
    set_parameter(letter, *set, counters);
  } else if (const auto* file = std::get_if<link::FileTransferProtocol>(&received.message)) {
    ftp_.request(link, from, *file, now_us);
  } else if (const auto* timesync = std::get_if<link::Timesync>(&received.message)) {
    links_.send(link, TimeRequests::answer_to(*timesync, from, read_us), counters);
  } else if (const auto* ping = std::get_if<link::Ping>(&received.message)) {
    links_.send(link, link::Ping{ping->time_usec, ping->seq, from}, counters);
  } else if (!identity_.is_autopilots(received.target)) {
    answer_mission(letter, counters);
  }
}

/// There is none, and none is taken.
void Vehicle::answer_mission(const Letter& letter, link::Counters& counters) {
  const link::Address from = letter.received.from;
  const link::Message& asked = letter.received.message;
  if (const auto* list = std::get_if<link::MissionRequestList>(&asked)) {
    links_.send(letter.link, link::MissionCount{0, from, list->mission_type}, counters);
  } else if (const auto* count = std::get_if<link::MissionCount>(&asked)) {
    const link::MissionAck no{from, mav::kMissionUnsupported, count->mission_type};
    links_.send(letter.link, no, counters);
  } else if (const auto* clear = std::get_if<link::MissionClearAll>(&asked)) {
    const link::MissionAck yes{from, mav::kMissionAccepted, clear->mission_type};
    links_.send(letter.link, yes, counters);
  }
}

void Vehicle::execute(const Letter& letter, const Command& command, std::int64_t now_us,
                      link::Counters& counters) {
  const auto& [link, received, read_us] = letter;
  Asked asked = meaning_of(command);
  if (identity_.is_autopilots(command.target) && drives(asked.request)) return;
  if (!may_command(received.from) && !asked.reads_only() && !is_disarm(command)) {
    asked = {mav::kDenied};
  }
  core::Verdict verdict{state_, true, 0};
  if (asked.request != Request::kNone) {
    verdict = ask(asked, now_us);
    if (!verdict.granted) asked.result = mav::kTemporarilyRejected;
  }
  if (asked.rate &&
      !streams_.set(link, asked.rate->id, asked.rate->interval_us, links_.limit(link))) {
    asked.result = asked.rate->id == mav::kHeartbeatId ? mav::kDenied : mav::kUnsupported;
  }
  if (asked.message) freshen();
  if (asked.message && !first_of(link, *asked.message)) {
    asked.result = mav::kUnsupported;
    asked.message.reset();
  }
  if (command.wants_ack) {
    links_.send(link, link::CommandAck{command.id, asked.result, received.from}, counters);
  }
  if (asked.message) send_requested(link, *asked.message, counters);
  if (asked.save_parameters) save_ = SaveRequest::kConfirmed;
  if (verdict.granted && verdict.state != state_) enter(verdict.state, 0, counters);
  if (!verdict.granted) refuse(asked.request, verdict.missing, counters);
}

core::Verdict Vehicle::ask(const Asked& asked, std::int64_t now_us) {
  if (asked.motor_test) {
    if (is_repeated(asked, now_us)) return {state_, true, 0};
    const core::Verdict verdict =
        core::supervise(state_, asked.request, conditions_ | core::kTestRunning);
    if (verdict.granted) {
      test_ = asked.motor_test;
      test_end_us_ = now_us + test_->duration_us;
      conditions_ |= core::kTestRunning;
    }
    return verdict;
  }
  const core::Verdict verdict = core::supervise(state_, asked.request, conditions_);
  if (verdict.granted && asked.request == Request::kManual) intended_mode_ = mode::kManual;
  if (verdict.granted && asked.request == Request::kHold) intended_mode_ = mode::kHold;
  if (verdict.granted && asked.request == Request::kFormation) intended_mode_ = mode::kFormation;
  return verdict;
}

/// A test's answer may have been lost: asked for once more it is neither longer nor a second one.
bool Vehicle::is_repeated(const Asked& asked, std::int64_t now_us) const {
  if (test_ != asked.motor_test) return false;
  return state_ == State::kTest || (asked.repeated && now_us - test_end_us_ < kRepeated_us);
}

std::optional<link::Message> Vehicle::first_of(std::size_t link,
                                               const MessageRequest& request) const {
  const auto index = request.index;
  if (request.id == mav::kHeartbeatId) return heartbeat();
  if (request.id == mav::kMessageIntervalId) {
    const auto id = static_cast<std::uint16_t>(index);
    return link::MessageInterval{streams_.interval_us(link, id), id};
  }
  if (identity_.companion() && !is_companions(request.id)) return std::nullopt;
  const bool one_mode = request.id == mav::kAvailableModesId && index > 0;
  return compose(request.id, one_mode ? index - 1 : 0, report_);
}

void Vehicle::send_requested(std::size_t link, const MessageRequest& request,
                             link::Counters& counters) {
  links_.send(link, *first_of(link, request), counters);
  const bool one_mode = request.id == mav::kAvailableModesId && request.index > 0;
  if (one_mode || request.id == mav::kMessageIntervalId) return;
  for (std::uint32_t turn = 1; const auto more = compose(request.id, turn, report_); ++turn) {
    links_.send(link, *more, counters);
  }
}

void Vehicle::set_parameter(const Letter& letter, const link::ParamSet& asked,
                            link::Counters& counters) {
  const auto& [link, received, read_us] = letter;
  const SetResult result =
      parameter_service_.set(link, received.from, asked, parameters_, core::armed(state_));
  switch (result.what) {
    case SetResult::What::kSet:
      changed_ = true;
      streams_.configure(parameters_);
      if (save_ == SaveRequest::kNone) save_ = SaveRequest::kChanged;
      break;
    case SetResult::What::kUnchanged:
      break;
    case SetResult::What::kAskMode:
      set_mode_parameter(letter, result, counters);
      break;
    case SetResult::What::kRefused:
      if (result.info != nullptr && refusal_due_.due(now_us_)) {
        say(mav::kSeverityWarning, {result.sentence.text()}, counters);
      }
      break;
  }
}

void Vehicle::set_mode_parameter(const Letter& letter, const SetResult& result,
                                 link::Counters& counters) {
  const auto& [link, received, read_us] = letter;
  if (identity_.is_autopilots(received.target)) return;
  const auto request = request_of_mode(result.mode);
  const Asked asked{mav::kAccepted, request.value_or(Request::kNone)};
  const core::Verdict verdict = ask(asked, now_us_);
  if (!verdict.granted) {
    parameter_service_.refuse(link, received.from, *result.info, mav::kParamPermissionDenied);
    refuse(asked.request, verdict.missing, counters);
    return;
  }
  if (verdict.state != state_) enter(verdict.state, 0, counters);
  parameter_service_.announce(*result.info);
}

void Vehicle::refuse(Request request, core::Conditions missing, link::Counters& counters) {
  if (!refusal_due_.due(now_us_)) return;
  const auto what = request == Request::kArm ? "PreArm: " : "Refused: ";
  if (missing == 0) {
    const auto* const why = state_ == State::kFault      ? "FAULT, disarm first"
                            : state_ == State::kDisarmed ? "arm first"
                                                         : "HOLD first";
    say(mav::kSeverityWarning, {what, why}, counters);
    return;
  }
  for_each_complaint(
      missing, [&](std::string_view why) { say(mav::kSeverityWarning, {what, why}, counters); });
}

void Vehicle::enter(State state, core::Conditions missing, link::Counters& counters) {
  if (state_ == State::kTest) test_end_us_ = std::min(test_end_us_, now_us_);
  state_ = state;
  if (state == State::kDisarmed) intended_mode_ = mode::kHold;
  const bool terminated = state == State::kFault && missing == 0;
  const bool test_over = missing == core::kTestRunning;
  const std::string_view why = terminated  ? "terminated, disarm to leave"
                               : test_over ? "motor test is over"
                                           : complaint_of(missing);
  const std::uint8_t severity = terminated                   ? mav::kSeverityCritical
                                : missing != 0 && !test_over ? mav::kSeverityError
                                                             : mav::kSeverityInfo;
  say(severity, {name_of(state), why.empty() ? "" : ": ", why}, counters);
  announce_ = true;
  streams_.hurry(mav::kCurrentModeId);
  if (parameters_.MODE == mode_of(state)) return;
  parameters_.MODE = mode_of(state);
  parameter_service_.announce(*find_parameter("MODE"));
}

}  // namespace flotilla::app
