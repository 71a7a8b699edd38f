// SPDX-License-Identifier: MIT
#include "app/operator/telemetry/telemetry_sender.hpp"

#include <utility>

#include "app/convert/convert.hpp"
#include "app/operator/telemetry/text.hpp"

namespace flotilla::app {
namespace {

constexpr std::size_t kLargestFrame = 280 + link::kSignatureBlockBytes;
// The turns of send_rest() after those of the streams.
constexpr std::uint8_t kParameters = kStreams.size(), kFiles = kParameters + 1, kLogs = kFiles + 1,
                       kTurns = kLogs + 1;
// On a link too slow for both state and reference, the reference gets every third turn: a leader's
// state is valid for a second, a reference for longer.
constexpr std::uint8_t kStatesPerReference = 2;
// Per tick and link, beside the tick's other traffic: files and logs transfer at about 70 kB/s.
constexpr int kParametersPerTick = 4, kFtpPacketsPerTick = 3, kLogPacketsPerTick = 8;

}  // namespace

TelemetrySender::TelemetrySender(const Configuration& configuration, MavlinkLinks& links,
                                 std::span<Streams::Link> streams, const Sources& sources)
    : links_(links),
      from_(sources),
      streams_(configuration, streams),
      separation_due_(1'000'000, configuration.start.tick_us / 2) {}

void TelemetrySender::begin(std::int64_t now_us) {
  now_us_ = now_us;
  streams_.forget_silent_radios(now_us);
}

bool TelemetrySender::locate(const link::GpsGlobalOrigin& origin) {
  const std::array<std::int32_t, 2> here{origin.latitude, origin.longitude};
  if (origin_ == here) return false;
  origin_ = here;
  origin_moved_ = true;
  streams_.make_due(link::GpsGlobalOrigin::kId);
  return true;
}

bool TelemetrySender::needs_report() {
  if (origin_moved_ || separation_due_.is_due(now_us_) || state_is_due()) return true;
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (links_.may_send_rest(link) && streams_.any_rest_due(link, now_us_)) return true;
  }
  return false;
}

bool TelemetrySender::state_is_due() {
  for (const std::size_t stream : kStateStreams) {
    for (std::size_t link = 0; link < links_.count(); ++link) {
      if (streams_.schedule(stream, link).is_due(now_us_)) return true;
    }
  }
  return false;
}

void TelemetrySender::send_separation(link::Counters& counters) {
  if (!separation_due_.take_if_due(now_us_) || !from_.report.depth) return;
  const auto tell = [&](std::string_view name, double value) {
    const std::uint32_t boot_ms = convert::boot_ms(now_us_);
    links_.broadcast(value_of(name, static_cast<float>(value), boot_ms), counters);
  };
  tell("DEPTH", *from_.report.depth);
  if (from_.report.separation_m) tell("SEP_M", *from_.report.separation_m);
}

void TelemetrySender::send(link::Counters& counters) {
  if (std::exchange(origin_moved_, false)) {  // before any position relative to it
    for (std::size_t link = 0; link < links_.count(); ++link) {
      send_stream(kOriginStream, link, counters);
    }
  }
  if (state_is_due()) send_state(counters);
  for (std::size_t link = 0; link < links_.count(); ++link) send_rest(link, counters);
}

void TelemetrySender::send_state(link::Counters& counters) {
  StateMessages state;
  for (std::size_t link = 0; link < links_.count(); ++link) send_state(link, state, counters);
}

/// Checks the link's budget once for attitude and position, so that a slow link does not separate
/// them. Leaves this turn to a reference that waits for the budget.
void TelemetrySender::send_state(std::size_t link, StateMessages& state, link::Counters& counters) {
  if (!links_.bucket(link).for_state()) return;
  StateTurns& turns = turns_[link].states;
  if (std::exchange(turns.reference_next, false)) return;
  bool any_sent = false;
  for (std::size_t i = 0; i < kStateStreams.size(); ++i) {
    const StreamInfo& info = kStreams[kStateStreams[i]];
    Schedule& schedule = streams_.schedule(kStateStreams[i], link);
    if (!schedule.is_due(now_us_) || links_.room(link) < std::size_t{2} * info.bytes) continue;
    if (!state[i]) state[i] = compose(info.id, 0, from_.report);
    if (!state[i]) continue;
    links_.send_state(link, *state[i], counters);
    schedule.take_if_due(now_us_);
    any_sent = true;
  }
  if (any_sent && turns.states < kStatesPerReference) ++turns.states;
}

bool TelemetrySender::waits_for_reference(std::uint32_t news) const {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (reference_is_due(link, news)) return true;
  }
  return false;
}

bool TelemetrySender::reference_is_due(std::size_t link, std::uint32_t news) const {
  const Schedule& schedule = streams_.schedule(kReferenceStream, link);
  return turns_[link].told_news == news ? schedule.is_due(now_us_) : schedule.is_due_early(now_us_);
}

void TelemetrySender::send_reference(std::uint32_t news, const link::FormationReference& reference,
                                     link::Counters& counters) {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (!reference_is_due(link, news) || links_.room(link) < kStreams[kReferenceStream].bytes) {
      continue;
    }
    StateTurns& turns = turns_[link].states;
    turns.reference_next = !links_.bucket(link).for_state() && turns.states == kStatesPerReference;
    if (!links_.bucket(link).for_state()) continue;
    turns.states = 0;
    links_.send_state(link, reference, counters);
    streams_.schedule(kReferenceStream, link).take(now_us_);
    turns_[link].told_news = news;
  }
}

bool TelemetrySender::future_is_due(std::size_t link, std::uint32_t news) const {
  const Schedule& schedule = streams_.schedule(kFutureStream, link);
  const ToldFuture& told = turns_[link].future;
  return told.news == news ? told.again && schedule.is_due(now_us_)
                           : schedule.is_due_early(now_us_);
}

bool TelemetrySender::waits_for_future(std::uint32_t news) const {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (future_is_due(link, news)) return true;
  }
  return false;
}

void TelemetrySender::send_future(std::uint32_t news,
                                  const std::optional<link::FormationFuture>& future,
                                  link::Counters& counters) {
  for (std::size_t link = 0; link < links_.count(); ++link) {
    ToldFuture& told = turns_[link].future;
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
void TelemetrySender::send_rest(std::size_t link, link::Counters& counters) {
  const bool asked =
      from_.parameter_service.owes(link) || !from_.files.is_idle() || !from_.logs.is_idle();
  if (!streams_.any_rest_due(link, now_us_) && !asked) return;
  const std::size_t first = turns_[link].next;
  for (std::size_t n = 0; n < kTurns && has_room(link); ++n) {
    const auto turn = static_cast<std::uint8_t>((first + n) % kTurns);
    bool any_sent = false;
    if (turn == kParameters) {
      any_sent = send_parameters(link, counters);
    } else if (turn == kFiles) {
      any_sent = send_from(from_.files, kFtpPacketsPerTick, link, counters);
    } else if (turn == kLogs) {
      any_sent = send_from(from_.logs, kLogPacketsPerTick, link, counters);
    } else if (is_rest(kStreams[turn].pace)) {
      any_sent = send_stream(turn, link, counters);
    }
    const Begun& begun = turns_[link].begun;
    const auto after = static_cast<std::uint8_t>((turn + 1) % kTurns);
    if (any_sent) turns_[link].next = begun.sent > 0 ? begun.stream : after;
  }
}

bool TelemetrySender::has_room(std::size_t link) const {
  return links_.may_send_rest(link) && links_.room(link) >= kLargestFrame;
}

/// A stream with nothing to send yet stays due, except those that many boats never use. If a slow
/// link cannot carry all its messages at once, it continues in a later tick, before all others
/// except requested parameters.
bool TelemetrySender::send_stream(std::uint8_t stream, std::size_t link, link::Counters& counters) {
  Schedule& schedule = streams_.schedule(stream, link);
  if (!schedule.is_due(now_us_)) return false;
  Begun& begun = turns_[link].begun;
  const std::uint32_t first = begun.stream == stream ? begun.sent : 0;
  std::uint32_t sent = first;
  for (; const auto message = compose(kStreams[stream].id, sent, from_.report); ++sent) {
    if (sent > first && !has_room(link)) {
      begun = {stream, sent};
      turns_[link].next = from_.parameter_service.owes(link) ? kParameters : stream;
      return false;
    }
    links_.send(link, *message, counters);
  }
  begun = {};
  const bool rare = stream == kPlanStream || stream == kFenceStream || stream == kGpsStream;
  if (sent > 0 || rare) schedule.take_if_due(now_us_);
  return sent > 0;
}

bool TelemetrySender::send_parameters(std::size_t link, link::Counters& counters) {
  bool any_sent = false;
  for (int n = 0; n < kParametersPerTick && links_.room(link) >= kLargestFrame; ++n) {
    const auto message = from_.parameter_service.next(link, from_.parameters);
    if (!message) break;
    links_.send(link, *message, counters);
    any_sent = true;
  }
  return any_sent;
}

template <class Service>
bool TelemetrySender::send_from(Service& service, int most, std::size_t link,
                                link::Counters& counters) {
  bool any_sent = false;
  for (int n = 0; n < most && has_room(link); ++n) {
    const auto message = service.next(link);
    if (!message) break;
    links_.send(link, *message, counters);
    any_sent = true;
  }
  return any_sent;
}

}  // namespace flotilla::app
