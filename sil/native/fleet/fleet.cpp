// SPDX-License-Identifier: MIT
#include "fleet/fleet.hpp"

#include <array>
#include <stdexcept>
#include <utility>

#include "fleet/injection.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::fleet {
namespace {

constexpr std::uint8_t kComponentGps = 220;
constexpr MessageType kHeartbeat{0, 50}, kCommandLong{76, 152};

std::array<std::uint8_t, 2> esc_indices(const app::Parameters& p) {
  const auto propulsion = app::configuration_of(p).propulsion;
  return {propulsion.port_esc, propulsion.stbd_esc};
}

}  // namespace

template <class S>
typename Fleet<S>::Station Fleet<S>::station(std::int64_t run, link::Address self,
                                             const UnitSettings& unit, const Clock& clock,
                                             bool is_boat) {
  Run& mine = runs_[run];
  if (records_ && mine.agents == Records::kMaxAgents) {
    throw std::invalid_argument("record: a recording has room for 256 agents");
  }
  Station out{clock, NavigationUnit(self, unit), &mine, agents_.size(), mine.agents++, self.system};
  tells_degrees_ = tells_degrees_ || out.unit.tells_degrees();
  agents_.push_back({is_boat, static_cast<std::uint32_t>(is_boat ? boats() : leaders_.size())});
  return out;
}

template <class S>
Fleet<S>::Vessel::Vessel(Station place, const app::Parameters& p, Outbox& outbox)
    : station(std::move(place)),
      escs(esc_indices(p)),
      firmware(p, kLinks, {room, outbox}),
      monitor(p) {}

template <class S>
std::size_t Fleet<S>::add_leader(std::int64_t run, std::uint8_t system, const UnitSettings& unit,
                                 const Clock& clock) {
  const link::Address self{system, link::mav::kComponentAutopilot};
  leaders_.push_back(station(run, self, unit, clock, false));
  return agents() - 1;
}

template <class S>
std::size_t Fleet<S>::add_boat(std::int64_t run, const app::Parameters& p, const UnitSettings& unit,
                               const Clock& clock) {
  const link::Address self{app::configuration_of(p).start.system, kComponentGps};
  boats_.emplace_back(station(run, self, unit, clock, true), p, outbox_);
  if (injects_) boats_[boats() - 1].firmware.let_failures_be_injected(&judge);
  return agents() - 1;
}

template <class S>
std::size_t Fleet<S>::connect(std::size_t sender, std::size_t receiver, const LinkQuality& quality,
                              std::uint64_t seed) {
  const auto number = static_cast<std::uint32_t>(links_.size());
  links_.emplace_back(seed).set(quality);
  station_of(sender).outbox.push_back(number);
  station_of(receiver).inbox.push_back(number);
  return number;
}

template <class S>
void Fleet<S>::tick(std::int64_t t_us, const TickArrays& arrays) {
  try {
    profiles_ ? tick_all<true>(t_us, arrays) : tick_all<false>(t_us, arrays);
  } catch (...) {
    // After an exception the memory that held the tick's output is gone.
    for (RadioLink& link : links_) link.forget();
    throw;
  }
}

template <class S>
template <bool kProfiled>
void Fleet<S>::tick_all(std::int64_t t_us, const TickArrays& arrays) {
  Stopwatch<kProfiled> watch(profile_);
  for (Station& leader : leaders_) tick_leader(leader, t_us, arrays);
  watch.lap(Stage::kUnits);
  for (std::size_t i = 0; i < boats(); ++i) tick_boat(i, t_us, arrays, watch);
  // Output without delay is received at the same instant.
  for (Station& leader : leaders_) listen(leader, t_us);
  for (std::size_t i = 0; i < boats(); ++i) listen(boats_[i], t_us);
  watch.lap(Stage::kDecode);
  if (!injects_) return;
  for (std::size_t i = 0; i < boats(); ++i) inject(boats_[i], t_us);
}

template <class S>
Sensed Fleet<S>::sensed(const TickArrays& a, std::size_t agent) {
  std::array<std::int32_t, 2> degE7{};
  if (a.degE7 != nullptr) degE7 = {a.degE7[2 * agent], a.degE7[2 * agent + 1]};
  return {a.eta + 3 * agent, a.nu + 3 * agent, degE7};
}

/// The navigation unit's output, with its faults.
template <class S>
void Fleet<S>::measure(Station& s, const TickArrays& arrays, std::vector<std::uint8_t>& out) {
  const Sensed truth = sensed(arrays, s.agent);
  if (!s.faults) return s.unit.tick(s.now_us, truth, out);
  const Sensed told = s.faults->measured(truth);
  s.faults->send_beside(s.now_us, out);
  if (s.faults->has(FaultKind::kOwnSilent)) return;
  s.unit.tick(s.now_us + s.faults->unit_ahead_us(), told, out);
}

template <class S>
void Fleet<S>::tick_leader(Station& s, std::int64_t t_us, const TickArrays& arrays) {
  s.now_us = s.clock.at(t_us);
  s.sent.clear();
  measure(s, arrays, s.sent);
  if (records_ && !s.sent.empty()) {
    s.run->records.chunk(t_us, s.number, Wire::kMavlinkOut, kRadio, s.sent);
  }
  broadcast(s, t_us);
}

template <class S>
template <bool kProfiled>
void Fleet<S>::tick_boat(std::size_t index, std::int64_t t_us, const TickArrays& arrays,
                         Stopwatch<kProfiled>& watch) {
  Vessel& v = boats_[index];
  Station& s = v.station;
  s.now_us = s.clock.at(t_us);
  chunk_.clear();
  tell_clocks(v, t_us);
  measure(s, arrays, chunk_);
  watch.lap(Stage::kUnits);
  if (!chunk_.empty()) hear(v, chunk_, t_us, kNavigation);
  if (s.faults) {
    const auto others = s.faults->sent_to(s.system, s.now_us);
    if (!others.empty()) hear(v, others, t_us, kRadio);
  }
  watch.lap(Stage::kDecode);
  put_on_bus(v, t_us, arrays.rpm + 2 * index);
  watch.lap(Stage::kCan);
  listen(v, t_us);
  watch.lap(Stage::kDecode);
  s.sent.clear();
  if (!s.has(FaultKind::kRestart)) {
    const auto out = v.firmware.tick(s.now_us);
    if (const auto broken = v.monitor.ticked(v.firmware, out, s.now_us)) {
      violations_.push_back({s.agent, t_us, broken->name});
    }
    watch.lap(Stage::kTick);
    for (const link::CanFrame& frame : out.can) {
      if (records_) s.run->records.frame(t_us, s.number, Wire::kCanOut, frame.id, frame.bytes());
      if (s.faults && !s.faults->passes_bus()) continue;
      v.escs.on_can(frame.id, frame.bytes(), s.now_us - s.jumped_us);
    }
    pass_on(v, out, t_us);
  }
  for (std::size_t esc = 0; esc < EscNodes::kEscs; ++esc) {
    arrays.command[EscNodes::kEscs * index + esc] = v.escs.command(esc, s.now_us - s.jumped_us);
  }
  watch.lap(Stage::kCan);
  broadcast(s, t_us);
  watch.lap(Stage::kLinks);
}

/// Gives the monitor the differences between the clocks, which no boat can know.
template <class S>
void Fleet<S>::tell_clocks(Vessel& v, std::int64_t t_us) {
  const Station& s = v.station;
  const std::uint8_t leader = v.firmware.guidance().leader();
  if (std::exchange(v.leader, leader) != leader) {
    v.leader_agent.reset();
    for (std::size_t agent = 0; agent < agents(); ++agent) {
      const Station& other = station_of(agent);
      if (other.run == s.run && other.system == leader) v.leader_agent = agent;
    }
  }
  policies::Clocks clocks;
  if (!s.was_set) {
    clocks.own_us = 0;
    const Station* other = v.leader_agent ? &station_of(*v.leader_agent) : nullptr;
    if (other != nullptr && !other->was_set) clocks.leader_us = other->clock.at(t_us) - s.now_us;
  }
  v.monitor.know(clocks);
}

template <class S>
void Fleet<S>::put_on_bus(Vessel& v, std::int64_t t_us, const double* rpm) {
  const Station& s = v.station;
  frames_.clear();
  v.escs.tick(s.now_us - s.jumped_us, rpm, frames_);
  if (s.faults) s.faults->put_on_bus(s.now_us, frames_);
  for (const link::CanFrame& frame : frames_) {
    if (s.faults && (s.has(FaultKind::kRestart) || !s.faults->passes_bus())) continue;
    if (records_) s.run->records.frame(t_us, s.number, Wire::kCanIn, frame.id, frame.bytes());
    v.firmware.on_can(frame.id, frame.bytes(), s.now_us);
    v.monitor.on_can(frame.id, frame.bytes());
  }
}

template <class S>
void Fleet<S>::pass_on(Vessel& v, const typename app::Boat<S>::Output& out, std::int64_t t_us) {
  Station& s = v.station;
  for (std::size_t link = 0; link < kLinks; ++link) {
    const auto data = out.links->bytes(link);
    if (records_ && !data.empty()) {
      s.run->records.chunk(t_us, s.number, Wire::kMavlinkOut, link, data);
    }
  }
  if (!s.faults) {
    s.unit.on_mavlink(out.links->bytes(kNavigation), s.now_us);
  } else if (!s.faults->has(FaultKind::kOwnSilent)) {
    s.unit.on_mavlink(out.links->bytes(kNavigation), s.now_us + s.faults->unit_ahead_us());
  }
  // The boat may reuse its output buffer in the next tick, but the others read this until then.
  const auto radio = out.links->bytes(kRadio);
  s.sent.assign(radio.begin(), radio.end());
}

template <class S>
void Fleet<S>::broadcast(Station& s, std::int64_t t_us) {
  const auto aired = s.faults ? s.faults->aired(s.sent, t_us, s.now_us) : std::span(s.sent);
  if (aired.empty()) return;
  for (const std::uint32_t link : s.outbox) links_[link].send(aired, t_us);
}

template <class S>
void Fleet<S>::listen(Vessel& v, std::int64_t t_us) {
  for (const std::uint32_t link : v.station.inbox) {
    links_[link].receive(t_us, [&](std::span<const std::uint8_t> data) {
      if (v.station.faults) data = v.station.faults->heard(data);
      if (!data.empty()) hear(v, data, t_us, kRadio);
    });
  }
}

template <class S>
void Fleet<S>::listen(Station& s, std::int64_t t_us) {
  for (const std::uint32_t link : s.inbox) {
    links_[link].receive(t_us, [&](std::span<const std::uint8_t> data) {
      if (!s.faults) return s.unit.on_mavlink(data, s.now_us);
      if (s.faults->has(FaultKind::kOwnSilent)) return;
      s.unit.on_mavlink(s.faults->heard(data), s.now_us + s.faults->unit_ahead_us());
    });
  }
}

template <class S>
void Fleet<S>::hear(Vessel& v, std::span<const std::uint8_t> data, std::int64_t t_us,
                    std::size_t link) {
  const Station& s = v.station;
  if (s.has(FaultKind::kRestart)) return;
  if (records_) s.run->records.chunk(t_us, s.number, Wire::kMavlinkIn, link, data);
  v.firmware.on_mavlink(data, s.clock.at(t_us), link);
  v.monitor.heard(data);
}

template <class S>
void Fleet<S>::hear(std::size_t boat, std::span<const std::uint8_t> data, std::int64_t t_us,
                    std::size_t link) {
  hear(boats_[boat], data, t_us, link);
}

template <class S>
void Fleet<S>::on_can(std::size_t boat, std::uint32_t can_id, std::span<const std::uint8_t> data,
                      std::int64_t t_us) {
  Vessel& v = boats_[boat];
  const Station& s = v.station;
  const std::int64_t now_us = s.clock.at(t_us);
  if (!s.has(FaultKind::kRestart)) {
    if (records_) s.run->records.frame(t_us, s.number, Wire::kCanIn, can_id, data);
    v.firmware.on_can(can_id, data, now_us);
    v.monitor.on_can(can_id, data);
  }
  v.escs.on_can(can_id, data, now_us - s.jumped_us);
}

template <class S>
void Fleet<S>::command(std::size_t boat, const Order& order, std::int64_t t_us) {
  Vessel& v = boats_[boat];
  std::vector<std::uint8_t> frame;
  v.station.run->ground_station.write(frame, kCommandLong, order.params, order.command,
                                      v.station.system, link::mav::kComponentAutopilot,
                                      std::uint8_t{0});
  hear_operator(v, frame, t_us);
}

template <class S>
void Fleet<S>::heartbeat(std::size_t boat, std::int64_t t_us) {
  Vessel& v = boats_[boat];
  std::vector<std::uint8_t> frame;
  constexpr std::uint8_t kMavlinkVersion = 3;
  v.station.run->ground_station.write(frame, kHeartbeat, std::uint32_t{0}, link::mav::kTypeGcs,
                                      link::mav::kAutopilotInvalid, std::uint8_t{0},
                                      link::mav::kStateActive, kMavlinkVersion);
  hear_operator(v, frame, t_us);
}

template <class S>
void Fleet<S>::hear_operator(Vessel& v, std::span<const std::uint8_t> frame, std::int64_t t_us) {
  if (!v.station.has(FaultKind::kRadioSilent)) hear(v, frame, t_us, kRadio);
}

template <class S>
std::optional<std::size_t> Fleet<S>::boat_of(std::size_t agent) const {
  const auto [is_boat, index] = agents_[agent];
  return is_boat ? std::optional<std::size_t>(index) : std::nullopt;
}

template <class S>
Run* Fleet<S>::run(std::int64_t run) {
  const auto found = runs_.find(run);
  return found == runs_.end() ? nullptr : &found->second;
}

template <class S>
std::span<const std::uint8_t> Fleet<S>::sent(std::size_t agent) const {
  const auto [is_boat, index] = agents_[agent];
  return is_boat ? boats_[index].station.sent : leaders_[index].sent;
}

template class Fleet<float>;
template class Fleet<double>;
template class Fleet<core::Q16>;

}  // namespace flotilla::fleet
