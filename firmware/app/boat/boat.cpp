// SPDX-License-Identifier: MIT
#include "app/boat/boat.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "app/boat/outlook.hpp"
#include "core/manual.hpp"

namespace flotilla::app {

template <class S>
Boat<S>::Boat(const Parameters& p, std::size_t links, const Storage& storage)
    : can_output_(storage.can),
      links_(Identity(configuration_of(p).start).self(), storage.links.first(links),
             storage.mavlink, storage.signing),
      guidance_(configuration_of(p), convert::law_of<S>(p)),
      vehicle_(p, supervisor_, links_, guidance_.time_requests(), storage),
      thrusters_(configuration().propulsion, convert::law_of<S>(p)),
      can_({configuration().start.can_node, configuration().start.system},
           configuration().start.tick_us / 2),
      ticks_(p.CTL_RATE),
      fleet_(vehicle_, links_, counters_),
      learner_(guidance_, can_),
      warnings_(vehicle_, guidance_, learner_.monitor(), counters_),
      alone_(vehicle_, guidance_, limits_, warnings_, counters_),
      parts_{vehicle_, supervisor_, guidance_,   learner_.monitor(), limits_, fence_watch_,
             can_,     host_,       conditions_, law_output_,        thrust_, counters_} {
  range_.clear();
  configure();
}

template <class S>
void Boat<S>::on_mavlink(std::span<const std::uint8_t> data, std::int64_t now, std::size_t link) {
  const std::int64_t now_us = clock_.take(now, counters_);
  range_.clear();
  while (!data.empty()) {
    data = data.subspan(links_.fill(link, data));
    take_all(link, now_us);
  }
  range_.collect();
}

template <class S>
void Boat<S>::end_of_datagram(std::int64_t now, std::size_t link) {
  range_.clear();
  give_up(link, clock_.take(now, counters_));
  range_.collect();
}

template <class S>
void Boat<S>::take_all(std::size_t link, std::int64_t now_us) {
  while (links_.next(link, received_, now_us, counters_)) {
    fleet_.hear(received_, now_us);
    if (is_namesakes_rc(link)) continue;
    if (vehicle_.take(link, received_, now_us, counters_)) continue;
    if (const auto* time = std::get_if<link::SystemTime>(&received_.message)) {
      learn_time(link, *time, now_us);
    } else {
      guidance_.take(received_, link, now_us, counters_, fleet_.sender(received_));
    }
  }
}

/// Whether sticks or a receiver's status on this link are those of another vessel with our system
/// id: our own receiver is on the link of our own unit.
template <class S>
bool Boat<S>::is_namesakes_rc(std::size_t link) const {
  const bool rc = received_.id == link::RcChannels::kId || received_.id == link::SysStatus::kId;
  return rc && received_.from.system == vehicle_.self().system && guidance_.own_is_elsewhere(link);
}

/// Accepts the time only from the boat's own system, on its navigation unit's link, and only signed
/// unless that link is without signing (the unit's cable). Three times in a row must agree: the
/// time of signatures never goes back, so one wrong time would outlast the right ones.
template <class S>
void Boat<S>::learn_time(std::size_t link, const link::SystemTime& time, std::int64_t now_us) {
  if (received_.from.system != vehicle_.self().system || guidance_.own_is_elsewhere(link)) return;
  const std::uint8_t unit = configuration().navigation.component;  // 0: any
  if (unit != 0 && received_.from.component != unit) return;
  if (!received_.is_signed && links_.policy(link) != SigningPolicy::kOff) return;
  const auto unix_us = static_cast<std::int64_t>(
      std::min<std::uint64_t>(time.time_unix_usec, MonotonicClock::kLatest_us));
  if (link::signing_time(unix_us) == 0) return;
  learnt_time_.hear(unix_us - now_us, now_us);
  set_clock();
}

template <class S>
void Boat<S>::set_clock() {
  const bool set = host_.clock_is_set && host_.unix_us > 0;
  const auto zero_us = learnt_time_.zero_us();
  if (!set && zero_us) host_.unix_us = *zero_us + now_us();
  if (host_.unix_us == 0) return;
  links_.signing().set_clock(link::signing_time(host_.unix_us), set || zero_us);
}

/// Call when the rest of an incomplete message will not arrive; the bytes after its start may hold
/// another message.
template <class S>
void Boat<S>::give_up(std::size_t link, std::int64_t now_us) {
  while (links_.give_up(link, counters_)) take_all(link, now_us);
}

template <class S>
void Boat<S>::on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now) {
  can_.on_frame(can_id, data, clock_.take(now, counters_), counters_);
}

template <class S>
typename Boat<S>::Output Boat<S>::tick(std::int64_t now) {
  const std::int64_t now_us = clock_.take(now, counters_);
  range_.clear();
  vehicle_.begin(now_us, ticks_.since_us(now_us));
  can_output_.count = 0;
  ticks_.begin(now_us);
  for (std::size_t link = 0; link < links_.count(); ++link) {
    if (links_.timed_out(link, now_us)) give_up(link, now_us);
  }
  range_.collect();
  range_.judge();
  if (vehicle_.is_asked()) report_last_tick();
  supervise(now_us);
  steer(now_us);
  look_at_limits(now_us);
  can_.send(thrust_.raw, core::armed(state()), now_us, counters_, can_output_);
  warnings_.send(
      {now_us, state(), conditions_, parts_.keeps_slot(), host_, law_output_, fence_watch_});
  tell(now_us);
  range_.collect();
  ticks_.end(now_us);
  return {&links_, std::span(can_output_.frames).first(can_output_.count)};
}

template <class S>
void Boat<S>::supervise(std::int64_t now_us) {
  if (vehicle_.take_change()) configure();
  apply_conditions(now_us);
  consult_fleet(now_us);
  if (host_.stop_pressed || can_.stop_pressed(now_us)) vehicle_.stop(counters_);
  bool more = true;
  while (more) {
    more = vehicle_.answer(counters_);
    note_state(now_us);
    if (!vehicle_.take_change()) continue;
    // A change applies before the next request is judged: for example, a new leader has not been
    // heard yet.
    configure();
    apply_conditions(now_us);
  }
  vehicle_.apply_rc(counters_);
  const bool follows = state() == core::State::kFormation || state() == core::State::kCoast;
  if (follows && configuration().formation.returns_alone &&
      guidance_.reports().leader_returns(now_us)) {
    vehicle_.request(core::Request::kReturn, counters_);
  }
  note_state(now_us);
}

/// Called before the operators' requests of this tick are answered, so that they override the
/// fleet's rule.
template <class S>
void Boat<S>::consult_fleet(std::int64_t now_us) {
  if (!Membership::kKeepsFleet) return;
  if (fleet_.asks_outlook(now_us)) {
    fleet_.give_places(
        outlook_of(guidance_, state() == core::State::kAuto, configuration().plan.fastest_mps),
        now_us);
  }
  const bool stopped = supervisor_.is_stopped_by_request();
  const FleetOrder order = fleet_.order(state(), stopped, conditions_, now_us);
  if (order == FleetOrder::kLead) report_last_tick();
  if (fleet_.take_change()) {
    configure();
    const SlotMotion slot = fleet_.slot_motion();
    guidance_.move_slot(slot.moves, slot.mps, slot.mps2, slot.soon_mps);
    apply_conditions(now_us);
  }
  if (fleet_.obey(order)) note_state(now_us);
}

/// Called after each answered request, so that leaving FORMATION and returning within one tick
/// restarts the guidance.
template <class S>
void Boat<S>::note_state(std::int64_t now_us) {
  const core::State was = std::exchange(last_state_, state());
  if (was == core::State::kDisarmed && core::armed(state()) && !guidance_.own_quality().told() &&
      (conditions_ & core::kOwnFresh) != 0) {
    vehicle_.texts().send(link::mav::kSeverityInfo,
                          {"navigation quality not reported: not checked"}, counters_);
  }
  // Discard a target that precedes another request.
  if (state() != core::State::kGuided) vehicle_.orders().take_target();
  if (was == state()) return;
  // The errand may begin in the tick in which the boat is armed: home is here.
  if (was == core::State::kDisarmed) look_at_limits(now_us);
  if (core::sails_alone(was)) guidance_.end_plan();
  if (core::sails_alone(state())) alone_.start({state(), conditions_, now_us});
  if (state() != core::State::kFormation) return;
  if (was == core::State::kCoast) {
    guidance_.close_anew();
  } else {
    guidance_.start(now_us);
  }
}

template <class S>
void Boat<S>::configure() {
  range_.collect();
  ticks_.limit_idle(parameters().FS_NAV_S);
  supervisor_.choose(configuration().failsafes.choices);
  const Parameters applied = fleet_.applied(parameters());
  ModelMonitor& learnt = learner_.monitor();
  const auto law = convert::law_of<S>(learnt.applied(applied));
  learnt.configure(applied, convert::in_float(law.controller.outer.r_max));
  guidance_.configure(configuration_of(applied), law, vehicle_.self().system);
  if (!core::armed(state())) thrusters_ = {configuration().propulsion, law};
  thrusters_.set_curves(law);
  range_.judge_parameters();
}

template <class S>
void Boat<S>::apply_conditions(std::int64_t now_us) {
  heard_ = heard_of(parts_, now_us);
  conditions_ = conditions(now_us);
  vehicle_.apply_conditions(conditions_, counters_);
}

template <class S>
core::Conditions Boat<S>::conditions(std::int64_t now_us) const {
  // While the clock stands still, data never become stale, so nothing can be trusted.
  if (ticks_.clock_stands()) return 0;
  return conditions_of(parts_,
                       {heard_, range_.is_kept(), slot_astern_.value(), alone_.voyage_is_lost(),
                        alone_.rally_is_near()},
                       now_us);
}

/// Called once this tick's position is known; the result enters the next tick's conditions.
template <class S>
void Boat<S>::look_at_limits(std::int64_t now_us) {
  const auto& [failsafes, propulsion] =
      std::tie(configuration().failsafes, configuration().propulsion);
  const bool armed = core::armed(state());
  const bool fenced = vehicle_.missions().fence().is_on();
  const bool placed = (fenced || limits_.asks_place(failsafes, armed, now_us)) &&
                      guidance_.located() && (conditions_ & core::kOwnFresh) != 0;
  const auto place = placed ? std::optional(guidance_.place()) : std::nullopt;
  constexpr core::Conditions kSure = core::kOwnFresh | core::kOwnGood | core::kOwnSteady;
  limits_.look(failsafes, {now_us,
                           armed,
                           place,
                           (conditions_ & kSure) == kSure,
                           {can_.esc_status(propulsion.port_esc, now_us),
                            can_.esc_status(propulsion.stbd_esc, now_us)}});
  if (limits_.take_late_home()) {
    vehicle_.texts().send(link::mav::kSeverityWarning,
                          {"home set here: no good position at arming"}, counters_);
  }
  if (place) alone_.look_for_rally(*place, now_us);
  look_at_fence(place, now_us);
}

template <class S>
void Boat<S>::look_at_fence(const std::optional<convert::Position>& place, std::int64_t now_us) {
  MissionService& missions = vehicle_.missions();
  FenceWatch::Seen seen{now_us, place, {}};
  if (place && missions.fence().is_on()) {
    const core::Motion<S>& motion = guidance_.motion();
    const core::Vec2<S> v =
        core::to_north_east(motion.psi, core::Vec2<S>{motion.nu.u, motion.nu.v});
    seen.velocity_n = {convert::q16(v.x), convert::q16(v.y)};
  }
  if (place && !core::law_drives(state())) alone_.check_way(*place, now_us);
  const bool yields = place && law_output_.separation.yielding;
  guidance_.close_courses(yields ? FenceWatch::closed_courses(missions.fence(), *place,
                                                              configuration().stopping,
                                                              convert::q16(guidance_.fastest()))
                                 : std::uint16_t{0});
  if (core::law_drives(state())) missions.forget_way();
  fence_watch_.look(missions.fence(), configuration().stopping, seen);
}

template <class S>
core::Thrust<S> Boat<S>::desired_thrust(std::int64_t now_us, S dt) {
  switch (state()) {
    case core::State::kManual:
    case core::State::kTest:
      drive_by_hand();
      break;
    case core::State::kCoast:
      law_output_ = guidance_.coast(now_us, dt);
      break;
    case core::State::kFormation:
      law_output_ = guidance_.step(now_us, dt);
      break;
    case core::State::kAuto:
    case core::State::kGuided:
    case core::State::kLoiter:
    case core::State::kReturn:
      law_output_ = alone_.sail({state(), conditions_, now_us, fleet_.shape_moves(now_us)}, dt);
      break;
    case core::State::kDisarmed:
    case core::State::kHold:
    case core::State::kFault:
      return {};
  }
  return law_output_.allocation.thrust;
}

/// Drives by the sticks, or runs a motor test.
template <class S>
void Boat<S>::drive_by_hand() {
  const core::AllocationParams<S>& propellers = guidance_.law().propellers;
  if (state() == core::State::kManual) {
    const Sticks& sticks = supervisor_.sticks();
    law_output_.tau = core::stick_wrench(propellers, convert::scalar<S>(sticks.surge),
                                         convert::scalar<S>(sticks.yaw));
    law_output_.allocation = core::allocate(propellers, law_output_.tau);
    return;
  }
  const MotorTest& test = *supervisor_.motor_test();
  law_output_.allocation.thrust =
      core::test_thrust(propellers, test.stbd ? core::Propeller::kStbd : core::Propeller::kPort,
                        convert::scalar<S>(test.share));
}

template <class S>
void Boat<S>::steer(std::int64_t now_us) {
  const S dt = convert::seconds<S>(ticks_.since_us(now_us));
  guidance_.observe(now_us, dt, thrust_.given, core::armed(state()));
  learn(now_us, dt);
  const bool drive = supervisor_.may_drive(conditions_, now_us);
  if (!drive || !core::law_drives(state())) law_output_ = {};
  const core::Thrust<S> desired = drive ? desired_thrust(now_us, dt) : core::Thrust<S>{};
  // In COAST the law follows a dead-reckoned leader; telemetry reports the error from the leader's
  // last received state.
  const bool by_law = drive && parts_.keeps_slot();
  if (!by_law && parts_.seen()) {
    const auto slot = guidance_.look(now_us);
    law_output_.error = slot.error;
    law_output_.astern = slot.astern;
  }
  slot_astern_.update(law_output_.astern && !guidance_.slot_moves() && parts_.seen() &&
                          configuration().formation.judges_station,
                      now_us);
  // Checked again after allocation, with newly evaluated conditions.
  const bool still = drive && core::may_drive(state(), conditions(now_us));
  thrust_ = thrusters_.step(still, desired, dt, state() != core::State::kCoast);
  range_.collect();
  range_.collect(law_output_.tau.X);
  range_.collect(law_output_.tau.N);
  // After an overflow the thrust may be wrong. The next tick's conditions lead to FAULT.
  if (range_.has_overflowed()) thrust_ = thrusters_.step(false, desired, dt);
}

/// Learns the model's errors from the thrust given since the last tick and the present motion.
template <class S>
void Boat<S>::learn(std::int64_t now_us, S dt) {
  if (!core::law_drives(state()) || (conditions_ & core::kOwnFresh) == 0) {
    learner_.interrupt();
  } else if (learner_.step(thrust_.thrust, configuration().propulsion, dt, now_us)) {
    configure();
  }
}

template <class S>
void Boat<S>::report_last_tick() {
  if (const auto last_us = ticks_.last_us()) vehicle_.report(report_of(parts_, *last_us));
}

template <class S>
void Boat<S>::tell(std::int64_t now_us) {
  if ((conditions_ & core::kOwnFresh) != 0 && guidance_.located())
    vehicle_.locate(guidance_.origin());
  if (vehicle_.tells_report()) vehicle_.report(report_of(parts_, now_us));
  vehicle_.tell(counters_);
  if (vehicle_.sender().waits_for_future(guidance_.future_news())) {
    vehicle_.sender().send_future(guidance_.future_news(), guidance_.future(now_us), counters_);
  }
  fleet_.tell(now_us);
  const std::uint32_t news = guidance_.reference_news();
  if (!vehicle_.sender().waits_for_reference(news)) return;
  if (const auto reference = reference_of(parts_, now_us)) {
    vehicle_.sender().send_reference(news, *reference, counters_);
  }
}

template <class S>
Snapshot Boat<S>::snapshot() const {
  return snapshot_of(parts_, ticks_.last_us().value_or(0));
}

template class Boat<float>;
template class Boat<double>;
template class Boat<core::Q16>;

}  // namespace flotilla::app
