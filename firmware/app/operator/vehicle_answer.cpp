// SPDX-License-Identifier: MIT
// Vehicle: answers to commands, message requests, parameters and missions.
#include "app/operator/vehicle.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::Request;

/// Whether a request drives the boat or prepares it for driving. If such a request is addressed to
/// the whole system, it is for the autopilot and not for its companion; one that stops the boat is
/// for both.
bool arms_or_drives(Request request) { return core::RequestKind::kStops < core::kind_of(request); }

/// Whether a request lets the boat sail without a leader.
bool sails_alone(Request request) {
  return request == Request::kAuto || request == Request::kGuided || request == Request::kLoiter ||
         request == Request::kReturn;
}

/// Leaves nothing of a command but why it is refused.
[[gnu::noinline]] void reject(DecodedCommand& asked, std::uint8_t result, std::string_view why) {
  asked = {result};
  asked.why = why;
}

constexpr std::string_view kBadSpeed = "speed must be 0.05 m/s to LAW_U_MAX";
constexpr std::string_view kJustPaused = "boat was just paused: ask again in 5 s";

bool is_of_logs(const RequestMessage& message) {
  return std::holds_alternative<link::LogRequestList>(message) ||
         std::holds_alternative<link::LogRequestData>(message) ||
         std::holds_alternative<link::LogRequestEnd>(message);
}

std::uint8_t mission_result_of(std::uint8_t result) {
  if (result == mav::kAccepted) return mav::kMissionAccepted;
  return result == mav::kUnsupportedFrame ? mav::kMissionUnsupportedFrame : mav::kMissionDenied;
}

}  // namespace

void Vehicle::answer(const PendingRequest& pending, link::Counters& counters) {
  const std::size_t link = pending.link;
  const link::Address from = pending.from;
  if (const auto command = command_of(pending.message)) {
    execute(pending, *command, counters);
  } else if (std::holds_alternative<link::ParamRequestList>(pending.message)) {
    parameter_service_.list(link);
  } else if (const auto* read = std::get_if<link::ParamRequestRead>(&pending.message)) {
    parameter_service_.read(link, from, *read);
  } else if (const auto* set = std::get_if<link::ParamSet>(&pending.message)) {
    set_parameter(pending, *set, counters);
  } else if (const auto* file = std::get_if<link::FtpRequest>(&pending.message)) {
    ftp_.request(link, from, *file, now_us_);
  } else if (const auto* timesync = std::get_if<link::Timesync>(&pending.message)) {
    links_.send(link, TimeRequests::answer_to(*timesync, from, pending.read_us), counters);
  } else if (const auto* ping = std::get_if<link::Ping>(&pending.message)) {
    links_.send(link, link::Ping{ping->time_usec, ping->seq, from}, counters);
  } else if (identity_.is_for_autopilot(pending.target)) {
    return;
  } else if (is_of_logs(pending.message)) {
    answer_log(pending);
  } else if (std::holds_alternative<link::SetPositionTargetLocalNed>(pending.message) ||
             std::holds_alternative<link::SetPositionTargetGlobalInt>(pending.message)) {
    take_setpoint(pending);
  } else {
    answer_mission(pending, counters);
  }
}

/// Setpoints have no acknowledgement: a text reports a refusal, at most once in ten seconds.
void Vehicle::take_setpoint(const PendingRequest& pending) {
  if (!may_command(pending.from)) {
    ignored_ = "not from MAV_GCS_SYSID";
    return;
  }
  if (supervisor_.state() != core::State::kGuided) {
    ignored_ = "setpoints need GUIDED";
    return;
  }
  const auto* local = std::get_if<link::SetPositionTargetLocalNed>(&pending.message);
  const bool placed = report_.own && report_.own->located;
  Setpoint setpoint;
  if (local == nullptr) {
    setpoint = setpoint_of(std::get<link::SetPositionTargetGlobalInt>(pending.message));
  } else if (placed) {
    setpoint = setpoint_of(*local, report_.own->state);
  } else {
    setpoint.why = "own position unknown";
  }
  DecodedCommand asked{mav::kAccepted};
  asked.why = setpoint.why;
  asked.target = setpoint.target;
  if (asked.target) judge_target(asked);
  const auto& drive = setpoint.drive;
  if (drive && drive->u != 0 && !is_speed(drive->u, configuration_.plan)) {
    asked.why = kBadSpeed;
  }
  if (!asked.why.empty()) {
    ignored_ = asked.why;
    return;
  }
  orders_.set(asked.target, drive, now_us_);
  recent_.note_setpoint(pending, now_us_);
}

/// Reports a refusal as for setpoints.
void Vehicle::answer_log(const PendingRequest& pending) {
  if (const auto* list = std::get_if<link::LogRequestList>(&pending.message)) {
    logs_.list(pending.link, *list);
  } else if (const auto* read = std::get_if<link::LogRequestData>(&pending.message)) {
    if (const auto why = logs_.read(pending.link, *read); !why.empty()) ignored_ = why;
  } else {
    logs_.end(pending.link);
  }
}

void Vehicle::answer_mission(const PendingRequest& pending, link::Counters& counters) {
  const core::State state = supervisor_.state();
  const MissionService::Asker asker{pending.from, pending.link, may_command(pending.from),
                                    state == core::State::kAuto, core::law_drives(state)};
  const auto answer =
      missions_.answer(pending.message, asker, configuration_.plan, pending.read_us);
  if (answer) links_.send(pending.link, *answer, counters);
  tell_mission_news(counters);
}

void Vehicle::tell_mission_news(link::Counters& counters) {
  using Kind = MissionService::News::Kind;
  const auto news = missions_.take_news();
  if (!news) return;
  constexpr std::array<std::string_view, kStoredKinds> kNames{"Plan", "Fence", "Rally"};
  const std::string_view name = kNames[static_cast<std::size_t>(news->what)];
  Sentence told;
  if (news->kind != Kind::kStored) {
    const bool refused = news->kind == Kind::kRefused;
    if (refused && !texts_.take_if_due(TextKind::kRefused, now_us_)) return;
    const std::string_view how = refused ? " refused at item " : " invalid at item ";
    told << name << how << static_cast<float>(news->item) << ": " << news->why;
    texts_.send(mav::kSeverityWarning, {told.text()}, counters);
    return;
  }
  told << name << " of " << static_cast<float>(missions_.stored(news->what).size())
       << " items stored";
  texts_.send(mav::kSeverityInfo, {told.text()}, counters);
  sender_.streams().make_due(link::MissionCurrent::kId);
  sender_.streams().make_due(link::FenceStatus::kId);
}

/// Switches the fence on or off. A repeated command may be a late copy: it switches nothing off.
std::uint8_t Vehicle::answer_of_fence(DecodedCommand& asked, bool repeated) {
  if (FLOTILLA_KEEPS_FLEET != 0 && repeated && !*asked.fence && missions_.fence().is_on()) {
    asked.why = "fence stays on: ask again";
    return mav::kTemporarilyRejected;
  }
  if (!missions_.enable_fence(*asked.fence)) {
    asked.why = "no fence is stored";
    return mav::kDenied;
  }
  sender_.streams().make_due(link::FenceStatus::kId);
  return mav::kAccepted;
}

/// Judges a target before the mode changes. A boat already in GUIDED accepts a new target.
void Vehicle::judge_target(DecodedCommand& asked) const {
  const bool guided = supervisor_.state() == core::State::kGuided;
  if (asked.target->speed_mps != 0 && !is_speed(asked.target->speed_mps, configuration_.plan)) {
    reject(asked, mav::kDenied, kBadSpeed);
  } else if (asked.request == Request::kNone && !guided) {
    reject(asked, mav::kDenied, "target needs GUIDED");
  } else if (const auto here = place(); !here) {
    reject(asked, mav::kTemporarilyRejected, "own position unknown");
  } else if (!convert::way_to<double>(*here, asked.target->place, kErrandReach_m).near) {
    reject(asked, mav::kDenied, "target is over 2.9 km away");
  } else if (missions_.fence().is_on()) {
    const auto why =
        missions_.fence().refusal_of(*here, asked.target->place, configuration_.plan.margin_m);
    if (!why.empty()) reject(asked, mav::kDenied, why);
  }
}

/// Goes to an item if it is near enough and the way there respects the fence.
std::uint8_t Vehicle::answer_of_item(DecodedCommand& asked) {
  if (supervisor_.state() == core::State::kAuto) {
    const auto here = place();
    if (!here) return mav::kTemporarilyRejected;
    asked.why = missions_.refusal_of_way(*here, *asked.item, configuration_.plan, asked.anew);
    if (!asked.why.empty()) return mav::kDenied;
  }
  if (!missions_.set_current(*asked.item, asked.anew)) return mav::kDenied;
  if (supervisor_.state() == core::State::kAuto) orders_.pause(false, now_us_);
  return mav::kAccepted;
}

/// Goes to an item, or pauses the plan or the errand. A repeated command may be a late copy of one
/// that came before the pause; the microcontroller's image has no room to judge this.
std::uint8_t Vehicle::answer_of_plan(DecodedCommand& asked, bool repeated) {
  const bool pauses = asked.paused && *asked.paused;
  if (FLOTILLA_KEEPS_FLEET != 0 && repeated && !pauses && orders_.was_just_paused(now_us_)) {
    asked.why = kJustPaused;
    return mav::kTemporarilyRejected;
  }
  if (asked.item) return answer_of_item(asked);
  if (!core::sails_alone(supervisor_.state())) return mav::kTemporarilyRejected;
  orders_.pause(pauses, now_us_);
  return mav::kAccepted;
}

/// Refuses a command whose sender may not command, or that others overtook, and an unfit target.
void Vehicle::screen(const PendingRequest& pending, const Command& command, DecodedCommand& asked) {
  if (!may_command(pending.from) && !asked.reads_only() && !is_stop(command)) {
    reject(asked, mav::kDenied, {});
  }
  if (asked.request == Request::kFormation && setpoints_.come_from(pending.from, now_us_)) {
    reject(asked, mav::kDenied, "mode 6 after setpoints is OFFBOARD");
  }
  std::string_view overtaken;
  if (asked.request != Request::kNone) {
    overtaken = recent_.judge(pending, asked.request, command.repeated, now_us_);
  } else if (asked.orders()) {
    overtaken = recent_.judge_order(pending, command.repeated, now_us_);
  }
  if (!overtaken.empty()) reject(asked, mav::kTemporarilyRejected, overtaken);
  if (asked.target) judge_target(asked);
}

void Vehicle::execute(const PendingRequest& pending, const Command& command,
                      link::Counters& counters) {
  const std::size_t link = pending.link;
  DecodedCommand asked = meaning_of(command);
  const bool unknown = asked.result == mav::kUnsupported;
  const bool at_rest = asked.request == Request::kHold && !core::armed(supervisor_.state());
  const bool of_plan = asked.item || asked.paused || asked.target || asked.fence;
  const bool leave = arms_or_drives(asked.request) || of_plan || unknown || at_rest;
  if (identity_.is_for_autopilot(command.target) && leave) return;
  screen(pending, command, asked);
  if (asked.failure) asked.result = failures_.answer(*asked.failure);
  Supervisor::Decision decision{true, false, 0};
  if (asked.request == Request::kArm) warn_of_signing(counters);
  if (asked.request != Request::kNone) decision = ask(asked);
  if (asked.rate && !sender_.streams().set(link, asked.rate->id, asked.rate->interval_us,
                                           links_.bucket(link).limit())) {
    asked.result = asked.rate->id == link::Heartbeat::kId ? mav::kDenied : mav::kUnsupported;
  }
  // AUTO again at the plan's end begins the plan anew.
  const bool stays = decision.granted && !decision.changed;  // a new state has no pause
  const bool anew = stays && !command.repeated;
  if (asked.request == Request::kAuto && anew && missions_.is_complete()) asked.item = 0;
  const bool judged = FLOTILLA_KEEPS_FLEET != 0 || !command.repeated;  // see answer_of_plan()
  const bool resumes = sails_alone(asked.request) && !asked.target && stays && judged;
  if (asked.item || asked.paused || resumes) {  // not set if denied
    asked.result = answer_of_plan(asked, command.repeated);
  }
  if (asked.target && decision.granted && !orders_.go_to(*asked.target, now_us_)) {
    reject(asked, mav::kTemporarilyRejected, kJustPaused);
  }
  if (asked.fence) asked.result = answer_of_fence(asked, command.repeated);
  if (asked.message) {
    refresh();
    asked.result = answer_of(link, *asked.message);
    if (asked.result != mav::kAccepted) asked.message.reset();
  }
  if ((asked.orders() || asked.paused) && asked.result == mav::kAccepted) {
    recent_.note_order(pending, now_us_);
  }
  acknowledge(pending, command, asked.result, counters);
  if (asked.message) send_requested(link, *asked.message, counters);
  if (asked.save_parameters) save_ = SaveRequest::kConfirmed;
  tell_decision(asked, decision, counters);
}

void Vehicle::acknowledge(const PendingRequest& pending, const Command& command,
                          std::uint8_t result, link::Counters& counters) {
  if (command.wants_ack) {
    links_.send(pending.link, link::CommandAck{command.id, result, pending.from}, counters);
  } else if (is_go_here(pending.message)) {
    links_.send(pending.link, link::MissionAck{pending.from, mission_result_of(result), 0, 0},
                counters);
  }
}

/// Tells operators of a new state, or why a request is refused.
void Vehicle::tell_decision(const DecodedCommand& asked, const Supervisor::Decision& decision,
                            link::Counters& counters) {
  if (decision.changed) announce_state(0, counters);
  if (!decision.granted) {
    refuse(asked.request, decision.missing, counters);
  } else {
    texts_.send_complaints("armed, no FORMATION: ", decision.missing, counters);
  }
  if (!asked.why.empty() && texts_.take_if_due(TextKind::kRefused, now_us_)) {
    texts_.send(mav::kSeverityWarning, {"Refused: ", asked.why}, counters);
  }
}

std::optional<link::Message> Vehicle::requested(std::size_t link, const MessageRequest& request,
                                                std::uint32_t turn) const {
  const bool first = turn == 0;
  if (request.id == link::Heartbeat::kId) {
    return first ? std::optional<link::Message>(heartbeat()) : std::nullopt;
  }
  if (request.id == link::MessageInterval::kId) {
    const auto id = static_cast<std::uint16_t>(request.index);
    const link::MessageInterval interval{sender_.streams().interval_us(link, id), id};
    return first ? std::optional<link::Message>(interval) : std::nullopt;
  }
  if (identity_.companion() && !is_sent_by_companion(request.id)) return std::nullopt;
  if (request.id != link::AvailableModes::kId || request.index == 0) {
    return compose(request.id, turn, report_);
  }
  return first ? compose(request.id, request.index - 1, report_) : std::nullopt;
}

std::uint8_t Vehicle::answer_of(std::size_t link, const MessageRequest& request) const {
  if (requested(link, request, 0)) return mav::kAccepted;
  const bool companion = identity_.companion() && !is_sent_by_companion(request.id);
  const bool no_such_mode = request.id == link::AvailableModes::kId;
  const bool later = can_compose(request.id) && !companion && !no_such_mode;
  return later ? mav::kTemporarilyRejected : mav::kUnsupported;
}

void Vehicle::send_requested(std::size_t link, const MessageRequest& request,
                             link::Counters& counters) {
  for (std::uint32_t turn = 0; const auto message = requested(link, request, turn); ++turn) {
    links_.send(link, *message, counters);
  }
}

void Vehicle::set_parameter(const PendingRequest& pending, const link::ParamSet& asked,
                            link::Counters& counters) {
  const std::size_t link = pending.link;
  if (identity_.is_for_autopilot(pending.target) && !ParameterService::knows(asked)) return;
  const SetResult result = parameter_service_.set(
      link, pending.from, asked, parameters_, {core::armed(supervisor_.state()), self().system});
  switch (result.outcome) {
    case SetResult::Outcome::kSet: {
      changed_ = true;
      const std::int64_t slow_us = configuration_.operators.slow_us;
      configuration_ = configuration_of(parameters_);
      sender_.streams().configure(configuration_.operators);
      if (configuration_.operators.slow_us != slow_us) timesync_.make_due();
      if (save_ == SaveRequest::kNone) save_ = SaveRequest::kChanged;
      break;
    }
    case SetResult::Outcome::kUnchanged:
      break;
    case SetResult::Outcome::kRefused:
      if (texts_.take_if_due(TextKind::kParameterRefused, now_us_)) {
        texts_.send(mav::kSeverityWarning, {result.sentence.text()}, counters);
      }
      break;
  }
}

}  // namespace flotilla::app
