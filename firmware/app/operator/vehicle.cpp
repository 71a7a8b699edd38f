// SPDX-License-Identifier: MIT
#include "app/operator/vehicle.hpp"

#include <algorithm>
#include <type_traits>

#include "app/convert/convert.hpp"
#include "app/convert/portable.hpp"
#include "app/operator/services/metadata.hpp"
#include "app/operator/telemetry/text.hpp"
#include "app/parameters/derived.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::Request;
using core::State;

// Bytes of a tick's datagram to keep free for heartbeat, state and 24 answers.
constexpr std::size_t kKeptRoom = 1000;

/// The request in a message, for the next tick to answer; std::monostate if there is none.
struct RequestOf {
  const link::FtpServer& ftp;

  template <class Message>
  RequestMessage operator()(const Message& m) const {
    if constexpr (std::is_constructible_v<RequestMessage, const Message&>) return m;
    return {};
  }
  RequestMessage operator()(const link::FileTransferProtocol& m) const { return ftp.read(m); }
  RequestMessage operator()(const link::Timesync& m) const {
    return m.tc1 == 0 ? RequestMessage(m) : RequestMessage();
  }
  RequestMessage operator()(const link::Ping& m) const {
    return m.target == link::Address{} ? RequestMessage(m) : RequestMessage();
  }
};

}  // namespace

Vehicle::Vehicle(const Parameters& p, Supervisor& supervisor, MavlinkLinks& links,
                 TimeRequests& time, const Storage& storage)
    : supervisor_(supervisor),
      parameters_(p),
      configuration_(configuration_of(p)),
      identity_(configuration_.start),
      links_(links),
      router_(storage.routes.first(links.count())),
      parameter_service_(storage.parameters.first(links.count())),
      missions_(storage.missions, configuration_.start.ardupilot),
      logs_(storage.logs, configuration_.start.ardupilot),
      ftp_(metadata_files()),
      sender_(configuration_, links, storage.streams.first(links.count()),
              {report_, parameters_, parameter_service_, ftp_, logs_}),
      texts_(links),
      timesync_(time, links, router_, configuration_.start.tick_us),
      heartbeat_due_(kSecond_us, configuration_.start.tick_us / 2) {
  refresh();
}

void Vehicle::refresh() {
  report_.self = self();
  report_.mode = supervisor_.mode();
  report_.intended_mode = supervisor_.intended_mode();
  report_.plan = plan_report();
}

bool Vehicle::take(std::size_t link, const link::Received& received, std::int64_t now_us,
                   link::Counters& counters) {
  const auto* beat = std::get_if<link::Heartbeat>(&received.message);
  if (received.from == self()) {
    if (beat != nullptr && !links_.is_echo(received)) identity_.heard_twice(now_us);
    return true;
  }
  // RADIO_STATUS comes unsigned and under any system id: trusted for the send buffer only.
  if (const auto* radio = std::get_if<link::RadioStatus>(&received.message)) {
    if (!links_.is_from_radio(link, received)) return true;
    sender_.streams().radio_has_room(link, radio->txbuf, now_us);
    return true;
  }
  heard_ = std::max(heard_, received.is_signed ? Heard::kSigned : Heard::kMessage);
  router_.heard(received.from, link, now_us);
  if (link::tells_motion(received.message)) return false;
  if (beat != nullptr) take_beat(received.from, *beat, now_us);
  if (received.target.system != 0) forward(link, received, now_us, counters);
  if (!identity_.addressed(received.target)) return true;
  if (Setpoints::is_one(received.id)) setpoints_.heard(received.from, now_us);
  const bool ours = received.target.system != 0 && !identity_.is_for_autopilot(received.target);
  const bool obeyed = ours && may_command(received.from);
  const RcPilots::Rules rules{configuration_.operators.rc_switch, self().system, obeyed};
  if (rc_.take(link, received, rules, supervisor_, now_us)) return true;
  if (const auto why = refusal_of(received.id); ours && !why.empty()) ignored_ = why;
  if (const auto* sticks = std::get_if<link::ManualControl>(&received.message)) {
    if (obeyed) take_sticks(link, received.from, *sticks, now_us, counters);
    return true;
  }
  const RequestMessage request = std::visit(RequestOf{ftp_}, received.message);
  if (std::holds_alternative<std::monostate>(request)) return false;
  keep(link, received, request, now_us, counters);
  return true;
}

/// Keeps a request until the next tick answers it, unless it is a late copy.
void Vehicle::keep(std::size_t link, const link::Received& received, const RequestMessage& request,
                   std::int64_t now_us, link::Counters& counters) {
  PendingRequest pending{now_us,          request, received.from,
                         received.target, link,    may_command(received.from)};
  if (FLOTILLA_KEEPS_FLEET != 0) pending.sequence = received.sequence;
  bool copy = false;
  if (Setpoints::is_one(received.id)) {
    copy = pending.may_command && !setpoint_link_.accept(received.from, link, now_us);
  } else if (pending.effects.overwrites) {
    const auto verdict = copies_.judge(received, links_.frame(link), link, now_us);
    copy = verdict != Copies::Verdict::kNew;
    if (FLOTILLA_KEEPS_FLEET != 0 && verdict == Copies::Verdict::kPerhaps) {
      ignored_ = "too many requests: ask again in 5 s";
    } else if (FLOTILLA_KEEPS_FLEET != 0 && verdict == Copies::Verdict::kOvertaken) {
      ignored_ = "sent before a newer request: ask again";
    }
  } else if (FLOTILLA_KEEPS_FLEET != 0 && pending.effects.stops) {
    copies_.note_stop(now_us);
  }
  if (!copy) inbox_.push(pending, counters);
}

void Vehicle::take_beat(link::Address from, const link::Heartbeat& beat, std::int64_t now_us) {
  identity_.heard(from, beat, configuration_.formation.leader, now_us);
  // A ground station on board does not show that the operator's radio link works.
  const bool ashore = from.system != self().system;
  if (beat.type == mav::kTypeGcs && ashore && may_command(from)) gcs_us_ = now_us;
}

void Vehicle::forward(std::size_t link, const link::Received& received, std::int64_t now_us,
                      link::Counters& counters) {
  // SETUP_SIGNING carries the secret key: never forwarded.
  if (received.target == self() || received.id == mav::kSetupSigningId) return;
  const std::uint8_t beyond = router_.beyond(received.target, link, now_us);
  for (std::size_t other = 0; other < links_.count(); ++other) {
    if ((beyond >> other & 1U) != 0) {
      links_.forward(other, links_.frame(link), received.is_signed, counters);
    }
  }
}

/// Takes the sticks of an operator who may command, but not while a pilot has the controls.
void Vehicle::take_sticks(std::size_t link, link::Address from, const link::ManualControl& message,
                          std::int64_t now_us, link::Counters& counters) {
  const auto surge = convert::stick_of(message.x), yaw = convert::stick_of(message.r);
  if (!surge || !yaw) {
    ++counters.mavlink_bad_value;
    return;
  }
  if (!rc_.hold(now_us_) && stick_link_.accept(from, link, now_us)) {
    supervisor_.take_sticks({*surge, *yaw}, from, now_us);
  }
}

bool Vehicle::may_command(link::Address from) const {
  return configuration_.operators.commander.value_or(from.system) == from.system;
}

void Vehicle::begin(std::int64_t now_us, std::int64_t dt_us) {
  now_us_ = now_us;
  sender_.begin(now_us);
  missions_.check_plan(configuration_.plan);
  links_.begin(dt_us);
  if (identity_.latch(core::armed(supervisor_.state()), now_us)) {
    links_.rename(identity_.self());
    changed_ = true;
  }
}

core::Conditions Vehicle::conditions(std::int64_t now_us) const {
  const auto limit_us = configuration_.operators.gcs_limit_us;
  const bool heard = !limit_us || (gcs_us_ && now_us - *gcs_us_ < *limit_us);
  return (heard ? core::kGcsHeard : core::Conditions{0}) |
         (configuration_.gains_fit ? core::kGainsFit : core::Conditions{0});
}

void Vehicle::apply_conditions(core::Conditions conditions, link::Counters& counters) {
  const auto decision = supervisor_.apply_conditions(conditions, now_us_);
  if (decision.changed) announce_state(decision.missing, counters);
}

void Vehicle::stop(link::Counters& counters) {
  if (supervisor_.request(Request::kTerminate, now_us_).changed) announce_state(0, counters);
  if (!texts_.take_if_due(TextKind::kStopPressed, now_us_)) return;
  texts_.send(mav::kSeverityCritical, {"stop switch is pressed, or its wire is cut"}, counters);
}

void Vehicle::apply_rc(link::Counters& counters) {
  const auto asked = rc_.take_request(supervisor_.state(), now_us_);
  if (asked == Request::kHold) {
    recent_.note_pilots_stop(now_us_);
    drop_orders(counters);
  }
  if (asked) request(*asked, counters);
  if (asked == Request::kManual && supervisor_.state() == State::kManual) {
    recent_.note_pilots_order(now_us_);
  }
}

/// While a pilot has the controls, an operator may only arm and stop the boat.
bool Vehicle::is_barred(Request request) const {
  const bool steered = FLOTILLA_KEEPS_FLEET != 0 && supervisor_.state() == State::kManual &&
                       rc_.steer(now_us_) &&
                       (supervisor_.conditions(now_us_) & core::kSticksCentred) != 0;
  return core::kind_of(request) == core::RequestKind::kDrives && (rc_.hold(now_us_) || steered);
}

void Vehicle::request(Request request, link::Counters& counters) {
  const auto decision = supervisor_.request(request, now_us_);
  if (decision.changed) announce_state(0, counters);
  if (!decision.granted) refuse(request, decision.missing, counters);
}

bool Vehicle::obey(Request request, link::Counters& counters) {
  const auto decision = judge(request);
  if (decision.changed) announce_state(0, counters);
  return decision.granted;
}

/// Drops waiting requests that would undo a stop.
void Vehicle::drop_orders(link::Counters& counters) {
  counters.requests_dropped += inbox_.drop([](const PendingRequest& pending) {
    return pending.effects.asks_state && !pending.effects.stops;
  });
}

bool Vehicle::obey_stop(link::Counters& counters) {
  drop_orders(counters);
  const State state = supervisor_.state();
  const bool drives = core::law_drives(state) || state == State::kManual || state == State::kTest;
  return !drives || obey(Request::kHold, counters);
}

bool Vehicle::answer(link::Counters& counters) {
  using Taken = Inbox::Taken;
  const auto answer_one = [&](const PendingRequest& pending) {
    // Leave room for the heartbeat and the state. A stop is obeyed even without room to answer it.
    const std::size_t kept = pending.effects.reads ? kKeptRoom : kOwnRoom;
    if (links_.room(pending.link) < kept && !pending.effects.stops) return Taken::kKept;
    const State was = supervisor_.state();
    answer(pending, counters);
    if (pending.effects.stops) return Taken::kStop;
    return changed_ || supervisor_.state() != was ? Taken::kLast : Taken::kAnswered;
  };
  const auto is_void = [&](const PendingRequest& pending) {
    if (pending.effects.asks_state) ++counters.requests_dropped;
    return pending.effects.asks_state;
  };
  const bool more = inbox_.take_each(answer_one, is_void);
  if (!more && std::exchange(disarm_, false) &&
      supervisor_.request(Request::kDisarm, now_us_).changed) {
    announce_state(0, counters);
  }
  return more;
}

/// Refuses what a pilot bars. Judges AUTO by the way from the boat's present place to the
/// item that is chosen now.
Supervisor::Decision Vehicle::judge(Request request) {
  if (is_barred(request)) return {false, false, 0};
  if (request == Request::kAuto && supervisor_.state() != State::kAuto) {
    const auto here = place();
    if (here) missions_.check_way(*here, configuration_.plan);
    if (!here || !missions_.plan_is_sound(false)) supervisor_.withdraw(core::kPlanReady);
  }
  return supervisor_.request(request, now_us_);
}

/// The boat's place in the last report.
std::optional<convert::Position> Vehicle::place() const {
  if (!report_.own || !report_.own->located) return std::nullopt;
  const convert::OwnState& own = report_.own->state;
  return convert::Position{own.north_m, own.east_m, own.origin};
}

Supervisor::Decision Vehicle::ask(DecodedCommand& asked) {
  Supervisor::Decision decision{true, false, 0};
  if (!asked.motor_test) {
    decision = judge(asked.request);
  } else if (supervisor_.is_repeated(*asked.motor_test, asked.repeated, now_us_)) {
    return decision;
  } else if (convert::is_dead(asked.motor_test->share, configuration_.propulsion)) {
    asked.result = mav::kDenied;
    return {false, false, 0};
  } else if (is_barred(Request::kTest)) {
    decision = {false, false, 0};
  } else {
    decision = supervisor_.request_test(*asked.motor_test, now_us_);
  }
  if (!decision.granted) asked.result = mav::kTemporarilyRejected;
  return decision;
}

/// Warns that a key protects only links that require signatures, and only while the time is known.
void Vehicle::warn_of_signing(link::Counters& counters) {
  if (!links_.signing().has_key() || !texts_.take_if_due(TextKind::kSigning, now_us_)) return;
  Sentence open;
  open << "unsigned messages accepted on link";
  const std::size_t closed = open.text().size();
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (links_.policy(link) != SigningPolicy::kRequired) open << " " << static_cast<float>(link);
  }
  if (open.text().size() > closed) {
    texts_.send(mav::kSeverityWarning, {open.text()}, counters);
  }
  if (links_.signing().knows_clock()) return;
  texts_.send(mav::kSeverityWarning, {"clock unknown: signature age not checked"}, counters);
}

void Vehicle::refuse(Request request, core::Conditions missing, link::Counters& counters) {
  const TextKind kind = request == Request::kArm ? TextKind::kArmRefused : TextKind::kRefused;
  if (!texts_.take_if_due(kind, now_us_)) return;
  const auto what = request == Request::kArm ? "PreArm: " : "Refused: ";
  if (missing == 0) {
    const State state = supervisor_.state();
    const auto* const why = is_barred(request)          ? "a pilot has the controls, HOLD first"
                            : state == State::kFault    ? "FAULT, disarm first"
                            : state == State::kDisarmed ? "arm first"
                            : state == State::kHold     ? "test thrust is below THR_DEAD"
                                                        : "HOLD first";
    texts_.send(mav::kSeverityWarning, {what, why}, counters);
    return;
  }
  texts_.send_complaints(what, missing, counters);
  if ((missing & core::kGainsFit) != 0) tell_gain_fault(counters);
  if ((missing & core::kPlanReady) != 0 && !missions_.plan_trouble().empty()) {
    texts_.send(mav::kSeverityWarning, {"Plan: ", missions_.plan_trouble()}, counters);
  }
}

/// For example "LAW_KDR 10 gives a yaw loop of 1.2 s, LAW_KPSI allows 1 s or less."
void Vehicle::tell_gain_fault(link::Counters& counters) {
  const auto found = gain_fault(parameters_);
  if (!found) return;
  const auto rounded = [](float s) {
    return static_cast<float>(portable::nearest(100 * double{s})) / 100;
  };
  Sentence why;
  why << found->gain << " " << found->value << " gives a " << found->loop << " of "
      << rounded(found->time_s) << " s, " << found->other << " allows " << rounded(found->allowed_s)
      << (found->more ? " s or more" : " s or less");
  texts_.send(mav::kSeverityWarning, {why.text()}, counters);
}

void Vehicle::announce_state(core::Conditions missing, link::Counters& counters) {
  const State state = supervisor_.state();
  const bool terminated = state == State::kFault && missing == 0;
  const bool test_over = missing == core::kTestRunning;
  const std::string_view why = terminated  ? "terminated, disarm to leave"
                               : test_over ? "motor test is over"
                                           : complaint_of(missing);
  const std::uint8_t severity = terminated                   ? mav::kSeverityCritical
                                : missing != 0 && !test_over ? mav::kSeverityError
                                                             : mav::kSeverityInfo;
  texts_.send(severity, {name_of(state), why.empty() ? "" : ": ", why}, counters);
  const bool centred = (supervisor_.conditions(now_us_) & core::kSticksCentred) != 0;
  if (state == State::kManual && !centred) {
    texts_.send_complaints("MANUAL: ", core::kSticksCentred, counters);
  }
  announce_ = true;
  orders_.enter_state();
  reached_.reset();
  sender_.streams().make_due(link::CurrentMode::kId);
}

}  // namespace flotilla::app
