// SPDX-License-Identifier: MIT
// Vehicle: sends heartbeats, streams, pending answers and texts.
#include <algorithm>

#include "app/operator/telemetry/text.hpp"
#include "app/operator/vehicle.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::State;

constexpr std::size_t kLargestFrame = 280 + link::kSignatureBlockBytes;
// Turns after those of the streams.
constexpr std::size_t kParameters = kStreams.size(), kFiles = kParameters + 1, kLogs = kFiles + 1,
                      kTurns = kLogs + 1;
// On a link too slow for both, the reference gets every third turn: a leader's state is good for a
// second, a reference for longer.
constexpr std::uint8_t kStatesPerReference = 2;
// Per tick and link, beside the tick's other traffic: files and logs transfer at about 70 kB/s.
constexpr int kParametersPerTick = 4, kFtpPacketsPerTick = 3, kLogPacketsPerTick = 8;

std::uint8_t base_mode_of(State state) {
  unsigned flags = mav::kModeFlagCustom;
  if (core::armed(state)) flags |= mav::kModeFlagArmed;
  if (state == State::kManual) flags |= mav::kModeFlagManual;
  if (core::law_drives(state)) flags |= mav::kModeFlagAuto | mav::kModeFlagGuided;
  if (state == State::kTest) flags |= mav::kModeFlagTest;
  return static_cast<std::uint8_t>(flags);
}

std::uint8_t status_of(State state) {
  if (state == State::kFault) return mav::kStateEmergency;
  if (state == State::kCoast) return mav::kStateCritical;
  return core::armed(state) ? mav::kStateActive : mav::kStateStandby;
}

}  // namespace

link::Heartbeat Vehicle::heartbeat() const {
  const bool companion = identity_.companion();
  return {supervisor_.mode(), companion ? mav::kTypeOnboardController : mav::kTypeSurfaceBoat,
          identity_.autopilot(), base_mode_of(supervisor_.state()), status_of(supervisor_.state())};
}

std::optional<PlanReport> Vehicle::plan_report() const {
  if (missions_.plan().empty()) return std::nullopt;
  const bool sails = supervisor_.state() == State::kAuto;
  const std::uint8_t state = missions_.is_complete()         ? mav::kMissionComplete
                             : sails && !paused_             ? mav::kMissionActive
                             : missions_.is_begun() || sails ? mav::kMissionPaused
                                                             : mav::kMissionNotStarted;
  const std::size_t count = missions_.plan().size();
  const std::size_t item = missions_.is_complete() ? count - 1 : missions_.current();
  return PlanReport{static_cast<std::uint16_t>(item),
                    static_cast<std::uint16_t>(count),
                    state,
                    missions_.id(Stored::kPlan),
                    missions_.id(Stored::kFence),
                    missions_.id(Stored::kRally)};
}

void Vehicle::sailed(std::size_t item, std::optional<std::size_t> reached, bool complete,
                     link::Counters& counters) {
  missions_.sailed(item, complete);
  if (std::exchange(reached_, reached) == reached || !reached) return;
  links_.broadcast(link::MissionItemReached{static_cast<std::uint16_t>(*reached)}, counters);
  streams_.make_due(link::MissionCurrent::kId);
}

/// Announces a changed origin, which followers need to convert our positions.
void Vehicle::locate(const link::GpsGlobalOrigin& origin) {
  const std::array<std::int32_t, 2> here{origin.latitude, origin.longitude};
  if (told_origin_ == here) return;
  told_origin_ = here;
  origin_moved_ = true;
  missions_.locate(origin);
  streams_.make_due(link::GpsGlobalOrigin::kId);
}

bool Vehicle::tells_report() {
  if (origin_moved_ || separation_due_.is_due(now_us_) || state_is_due()) return true;
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (links_.bucket(link).for_rest() && streams_.any_due(link, now_us_)) return true;
  }
  return false;
}

void Vehicle::report(const Report& report) {
  report_ = report;
  if (report_.own) report_.own->adrift = !report_.own->located && told_origin_;
  refresh();
}

void Vehicle::tell(link::Counters& counters) {
  if (heartbeat_due_.take_if_due(now_us_) || announce_) links_.beat(heartbeat(), counters);
  announce_ = false;
  if (timesync_due_.take_if_due(now_us_)) ask_times(counters);
  if (core::follows(supervisor_.state()) && (report_.conditions & core::kLeaderTimed) == 0 &&
      leader_time_due_.take_if_due(now_us_)) {
    ask_leaders_time(counters);
  }
  if (const auto again = missions_.repeat(now_us_)) {
    links_.send(again->link, again->message, counters);
  }
  tell_mission_news(counters);
  if (separation_due_.take_if_due(now_us_) && report_.depth) tell_separation(counters);
  if (std::exchange(double_seen_, false) && double_due_.take_if_due(now_us_)) {
    send_statustext(mav::kSeverityCritical,
                    {"another sender uses this boat's system and component id"}, counters);
  }
  if (const auto why = std::exchange(ignored_, {});
      !why.empty() && ignored_due_.take_if_due(now_us_)) {
    send_statustext(mav::kSeverityWarning, {"Refused: ", why}, counters);
  }
  if (std::exchange(origin_moved_, false)) {  // before any position relative to it
    for (std::size_t link = 0; link < links_.count(); ++link) {
      tell_stream(kOriginStream, link, counters);
    }
  }
  if (state_is_due()) tell_state(counters);
  for (std::size_t link = 0; link < links_.count(); ++link) tell_rest(link, counters);
}

/// All vessels in range answer each other's requests, which is most of a slow radio's load; so
/// SR_SLOW below 1 Hz slows the requests. The own unit is still asked every second: if it does not
/// answer, it counts as late.
void Vehicle::ask_times(link::Counters& counters) {
  const link::Timesync request = time_.ask(now_us_, self().system);
  const std::int64_t before_us = streams_.slowed_us(kSecond_us) - kSecond_us;  // one turn less
  const bool everywhere = now_us_ - asked_everywhere_us_ > before_us + kSecond_us / 20;
  if (everywhere) asked_everywhere_us_ = now_us_;
  const unsigned own = router_.links_to({self().system, 0}, now_us_);
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (everywhere || (own >> link & 1U) != 0) links_.send(link, request, counters);
  }
}

/// Asks only a new leader, whose clock is not known yet. Until it is, the boat coasts.
void Vehicle::ask_leaders_time(link::Counters& counters) {
  link::Timesync request = time_.ask(now_us_, self().system);
  request.target = {report_.leader, 0};
  links_.broadcast(request, counters);
}

/// DEPTH decides the right of way among nearby boats; SEP_M shows operators why this one stops.
void Vehicle::tell_separation(link::Counters& counters) {
  const auto tell = [&](std::string_view name, double value) {
    const std::uint32_t boot_ms = convert::boot_ms(now_us_);
    links_.broadcast(value_of(name, static_cast<float>(value), boot_ms), counters);
  };
  tell("DEPTH", *report_.depth);
  if (report_.separation_m) tell("SEP_M", *report_.separation_m);
}

bool Vehicle::state_is_due() {
  for (const std::size_t stream : kStateStreams) {
    for (std::size_t link = 0; link < links_.count(); ++link) {
      if (streams_.schedule(stream, link).is_due(now_us_)) return true;
    }
  }
  return false;
}

void Vehicle::tell_state(link::Counters& counters) {
  StateMessages state;
  for (std::size_t link = 0; link < links_.count(); ++link) tell_state(link, state, counters);
}

/// Checks the link's budget once for both, so that a slow link does not separate attitude and
/// position. Leaves this turn to a reference that waits for the budget.
void Vehicle::tell_state(std::size_t link, StateMessages& state, link::Counters& counters) {
  if (!links_.bucket(link).for_state()) return;
  StateTurns& turns = state_turns_[link];
  if (std::exchange(turns.reference_next, false)) return;
  bool told = false;
  for (std::size_t i = 0; i < kStateStreams.size(); ++i) {
    const StreamInfo& info = kStreams[kStateStreams[i]];
    Schedule& schedule = streams_.schedule(kStateStreams[i], link);
    if (!schedule.is_due(now_us_) || links_.room(link) < std::size_t{2} * info.bytes) continue;
    if (!state[i]) state[i] = compose(info.id, 0, report_);
    if (!state[i]) continue;
    links_.send_state(link, *state[i], counters);
    schedule.take_if_due(now_us_);
    told = true;
  }
  if (told && turns.states < kStatesPerReference) ++turns.states;
}

bool Vehicle::waits_for_reference(std::uint32_t news) const {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (reference_is_due(link, news)) return true;
  }
  return false;
}

bool Vehicle::reference_is_due(std::size_t link, std::uint32_t news) const {
  const Schedule& schedule = streams_.schedule(kReferenceStream, link);
  return told_news_[link] == news ? schedule.is_due(now_us_) : schedule.is_due_early(now_us_);
}

void Vehicle::tell_reference(std::uint32_t news, const link::FormationReference& reference,
                             link::Counters& counters) {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (!reference_is_due(link, news) || links_.room(link) < kStreams[kReferenceStream].bytes) {
      continue;
    }
    StateTurns& turns = state_turns_[link];
    turns.reference_next = !links_.bucket(link).for_state() && turns.states == kStatesPerReference;
    if (!links_.bucket(link).for_state()) continue;
    turns.states = 0;
    links_.send_state(link, reference, counters);
    streams_.schedule(kReferenceStream, link).take(now_us_);
    told_news_[link] = news;
  }
}

bool Vehicle::future_is_due(std::size_t link, std::uint32_t news) const {
  const Schedule& schedule = streams_.schedule(kFutureStream, link);
  const ToldFuture& told = told_futures_[link];
  return told.news == news ? told.again && schedule.is_due(now_us_)
                           : schedule.is_due_early(now_us_);
}

bool Vehicle::waits_for_future(std::uint32_t news) const {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (future_is_due(link, news)) return true;
  }
  return false;
}

void Vehicle::tell_future(std::uint32_t news, const std::optional<link::FormationFuture>& future,
                          link::Counters& counters) {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    ToldFuture& told = told_futures_[link];
    if (!future) told = {news, false};
    if (!future_is_due(link, news) || !links_.bucket(link).for_state() ||
        links_.room(link) < kStreams[kFutureStream].bytes) {
      continue;
    }
    links_.send_state(link, *future, counters);
    streams_.schedule(kFutureStream, link).take(now_us_);
    told = {news, told.news != news};
  }
}

/// Sends everything else in turn. Messages that do not fit on a slow link come first in a later
/// tick.
void Vehicle::tell_rest(std::size_t link, link::Counters& counters) {
  const bool asked = parameter_service_.owes(link) || !ftp_.is_idle() || !logs_.is_idle();
  if (!streams_.any_due(link, now_us_) && !asked) return;
  const std::size_t first = turn_[link];
  for (std::size_t n = 0; n < kTurns && may_tell(link); ++n) {
    const std::size_t turn = (first + n) % kTurns;
    bool told = false;
    if (turn == kParameters) {
      told = tell_parameters(link, counters);
    } else if (turn == kFiles) {
      told = tell_files(link, counters);
    } else if (turn == kLogs) {
      told = tell_logs(link, counters);
    } else if (is_rest(kStreams[turn].pace)) {
      told = tell_stream(turn, link, counters);
    }
    const Begun& begun = begun_[link];
    if (told) turn_[link] = begun.told > 0 ? begun.stream : (turn + 1) % kTurns;
  }
}

bool Vehicle::may_tell(std::size_t link) const {
  return links_.bucket(link).for_rest() && links_.room(link) >= kLargestFrame;
}

/// A stream with nothing to send yet stays due, except those that many boats never use. If a slow
/// link cannot carry all its messages at once, it continues in a later tick, before all others
/// except requested parameters.
bool Vehicle::tell_stream(std::size_t stream, std::size_t link, link::Counters& counters) {
  Schedule& schedule = streams_.schedule(stream, link);
  if (!schedule.is_due(now_us_)) return false;
  Begun& begun = begun_[link];
  const std::uint32_t first = begun.stream == stream ? begun.told : 0;
  std::uint32_t told = first;
  for (; const auto message = compose(kStreams[stream].id, told, report_); ++told) {
    if (told > first && !may_tell(link)) {
      begun = {stream, told};
      turn_[link] = parameter_service_.owes(link) ? kParameters : stream;
      return false;
    }
    links_.send(link, *message, counters);
  }
  begun = {};
  const bool rare = stream == kPlanStream || stream == kFenceStream || stream == kGpsStream;
  if (told > 0 || rare) schedule.take_if_due(now_us_);
  return told > 0;
}

bool Vehicle::tell_parameters(std::size_t link, link::Counters& counters) {
  bool told = false;
  for (int n = 0; n < kParametersPerTick && links_.room(link) >= kLargestFrame; ++n) {
    const auto message = parameter_service_.next(link, parameters_);
    if (!message) break;
    links_.send(link, *message, counters);
    told = true;
  }
  return told;
}

bool Vehicle::tell_files(std::size_t link, link::Counters& counters) {
  bool told = false;
  for (int n = 0; n < kFtpPacketsPerTick && may_tell(link); ++n) {
    const auto packet = ftp_.next(link);
    if (!packet) break;
    links_.send(link, *packet, counters);
    told = true;
  }
  return told;
}

bool Vehicle::tell_logs(std::size_t link, link::Counters& counters) {
  bool told = false;
  for (int n = 0; n < kLogPacketsPerTick && may_tell(link); ++n) {
    const auto message = logs_.next(link);
    if (!message) break;
    links_.send(link, *message, counters);
    told = true;
  }
  return told;
}

void Vehicle::send_statustext(std::uint8_t severity, std::initializer_list<std::string_view> parts,
                              link::Counters& counters) {
  std::array<char, 200> text{};
  std::size_t length = 0;
  for (const std::string_view part : parts) {
    const std::size_t n = std::min(part.size(), text.size() - length);
    std::copy_n(part.begin(), n, text.begin() + static_cast<std::ptrdiff_t>(length));
    length += n;
  }
  link::Statustext chunk{severity, {}};
  // A NUL ends the last chunk, so a text that fills a chunk to the end needs one more.
  const bool one_chunk = length <= chunk.text.size();
  if (!one_chunk) chunk.id = ++text_id_ != 0 ? text_id_ : ++text_id_;
  for (std::size_t at = 0; at == 0 || (!one_chunk && at <= length); at += chunk.text.size()) {
    chunk.text = {};
    const std::size_t n = std::min(chunk.text.size(), length - at);
    std::copy_n(text.begin() + static_cast<std::ptrdiff_t>(at), n, chunk.text.begin());
    links_.broadcast(chunk, counters);
    ++chunk.chunk_seq;
  }
}

}  // namespace flotilla::app
