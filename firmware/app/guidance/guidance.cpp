// SPDX-License-Identifier: MIT
#include "app/guidance/guidance.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "app/guidance/moving_slot.hpp"

namespace flotilla::app {
namespace {

constexpr bool kMoves = FLOTILLA_KEEPS_FLEET != 0;  // slots may move, members differ in length

template <class S>
std::optional<double> age_s(const VesselTrack<S>& track, std::int64_t now_us) {
  const auto age_us = track.age_us(now_us);
  if (!age_us || !track.timed()) return std::nullopt;
  return convert::seconds<double>(*age_us);
}

}  // namespace

template <class S>
Guidance<S>::Guidance(const Configuration& c, const convert::Law<S>& law)
    : law_(law),
      own_(c.start.system, c.start.component, c.navigation.component),
      leader_({c.formation.leader, 0}) {
  configure(c, law, c.start.system);
}

template <class S>
void Guidance<S>::configure(const Configuration& c, const convert::Law<S>& law,
                            std::uint8_t own_system) {
  law_ = law;
  limits_ = c.navigation;
  own_.configure(law, c.navigation, own_system);
  leader_.follow(c.formation.leader);
  leader_.set_lag(c.formation.leader_lag_us);
  neighbours_.configure(own_system, leader_.system(), c.formation.separation_m);
  reference_.configure(c.formation, law.foresight, own_system);
  reports_.configure(own_system, leader_.system(), c.formation.wait_us);
  const auto slot = convert::wire_offset_of(c.formation.north_m, c.formation.east_m);
  claims_.configure(own_system, leader_.system(), slot, c.formation.beam_m);
  const float slot_m = convert::length_m(slot);
  reach_ = std::min(c.formation.reach_m.value_or(convert::kNear_m) + slot_m, convert::kNear_m);
}

template <class S>
void Guidance<S>::take(const link::Received& received, std::size_t link, std::int64_t now_us,
                       link::Counters& counters, const Sender& sender) {
  if (const auto* answer = std::get_if<link::Timesync>(&received.message)) {
    take_time(received.from, *answer, link, now_us);
    return;
  }
  own_.take(received, link, now_us, counters);
  const convert::Position* place = located() ? &own_.track().position() : nullptr;
  if (std::holds_alternative<link::FormationReference>(received.message) ||
      std::holds_alternative<link::FormationFuture>(received.message)) {
    reference_.take(received, place, now_us, counters);
  } else if (received.from.system == leader_.system()) {
    leader_.take(received, now_us, counters);
  }
  if (!link::tells_motion(received.message)) {
    reports_.hear(received, now_us);
    claims_.hear(received, sender.may_claim, reference_.place(), now_us);
  }
  if (!neighbours_.watches()) return;
  if (place != nullptr) {
    neighbours_.take<S>(received, *place, now_us, kMoves ? sender.reach_m : std::nullopt);
  } else if (const auto* ship = std::get_if<link::AisVessel>(&received.message)) {
    // A resting ship reports every three minutes: too seldom to wait for our own position.
    const link::GpsGlobalOrigin there{ship->lat, ship->lon, 0, 0}, frame = neighbours_.frame();
    neighbours_.take<S>(received, {{}, {}, convert::is_valid(frame) ? frame : there}, now_us);
  }
}

template <class S>
void Guidance<S>::take_time(link::Address from, const link::Timesync& answer, std::size_t link,
                            std::int64_t now_us) {
  const auto sent_us = time_.sent_us(answer);
  if (!sent_us) return;
  const std::int64_t read_us = answer.tc1 / 1000;
  if (own_.may_be_own(link, now_us)) own_.track().answered(from, *sent_us, read_us, now_us);
  leader_.answered(from, *sent_us, read_us, now_us);
  reference_.answered(from, *sent_us, read_us, now_us);
}

template <class S>
core::Conditions Guidance<S>::heard(std::int64_t now_us) const {
  core::Conditions met = 0;
  const VesselTrack<S>& own = own_.track();
  const bool placed = leader_.has_origin() && own.has_origin();
  const bool near = placed && convert::near(own.position(), leader_.position(), reach_);
  if (near || !placed) met |= core::kLeaderNear;
  if (leader_.system() != own.system() && leader_.fresh(now_us, limits_.leader_limit_us) &&
      (near || (placed && convert::near(own.position(), leader_.position())))) {
    met |= core::kLeaderFresh;
  }
  if (neighbours_.clear(own_.anchor(), own_.motion().moved_n, now_us)) met |= core::kClear;
  if (!reference_.place().is_cycle(now_us)) met |= core::kLeadersEnd;
  if (leader_.timed()) met |= core::kLeaderTimed;
  if (leader_.live()) met |= core::kLeaderLive;
  if (leader_.steady(now_us) && !leader_.doubled(now_us)) met |= core::kLeaderSteady;
  return met;
}

template <class S>
void Guidance<S>::observe(std::int64_t now_us, S since, const core::Tau<S>& given, bool armed) {
  reference_.make(leader_, now_us);
  leader_.stand_by(std::exchange(leaders_reference_, false));
  own_.observe(law_, given, since, armed, now_us);
}

template <class S>
std::optional<double> Guidance<S>::latency_s() const {
  const auto found_s = own_.latency().found_s();
  return found_s ? std::optional<double>(*found_s) : std::nullopt;
}

/// The formation's root if its reference can be followed, else the leader.
template <class S>
Lead<S> Guidance<S>::lead(std::int64_t now_us) const {
  if (const auto aim = reference_.aim(now_us)) return lead_of(*aim);
  return {leader_.system(),       {}, leader_.position(),
          leader_.motion(now_us), {}, law_.controller.slot};
}

template <class S>
Lead<S> Guidance<S>::lead_of(const typename Reference<S>::Aim& aim) const {
  Lead<S> lead{leader_.system(),
               aim.branch,
               aim.position,
               aim.motion,
               convert::offset_of<S>(aim.offset.n),
               law_.controller.slot,
               aim.motion.psi};
  core::SlotParams<S>& slot = lead.slot;
  slot.d = convert::offset_of<S>(aim.offset.b);
  slot.turns = slot.turns || aim.offset.b != convert::WireOffset{};
  slot.steers = slot.steers || slot.turns;
  if (kMoves && slot_moves_) lead = on_own_course(lead, slot_v_, slot_a_, slot_soon_v_);
  return lead;
}

/// The leader's offset from its own slot; zero unless the boat follows a root above its leader.
template <class S>
core::Vec2<S> Guidance<S>::leaders_error(std::int64_t now_us) const {
  const Lead<S>& lead = follower_.lead();
  if (lead.branch.root == 0 || lead.branch.root == lead.leader) return {};
  const RootOffset slot = reference_.place().leaders_offset(now_us);
  const auto seen = convert::controller_input_of<S>(leader_.position(), leader_.motion(now_us),
                                                    lead.position, lead.motion);
  const core::Vec2<S> n = convert::offset_of<S>(slot.n);
  const core::Vec2<S> b = core::to_north_east(lead.root_psi, convert::offset_of<S>(slot.b));
  return {seen.separation_n.x - n.x - b.x, seen.separation_n.y - n.y - b.y};
}

template <class S>
void Guidance<S>::start(std::int64_t now_us) {
  own_.begin();
  leader_.accept_place();
  reference_.accept_place();
  follower_.start();
  follower_.follow(law_, own_, lead(now_us), S(0));
}

template <class S>
Lead<S> Guidance<S>::lead_of_plan() const {
  const std::uint8_t self = own_.track().system();
  core::SlotParams<S> slot = law_.controller.slot;
  slot.steers = S(0) < law_.observer.omega_c;
  slot.d = {};
  slot.turns = false;
  return {self, {self, self}, plan_vessel_.from(), plan_vessel_.motion(), {}, slot};
}

template <class S>
void Guidance<S>::start_alone() {
  own_.begin();
  follower_.start();
}

template <class S>
void Guidance<S>::start_plan(const PlanOrder& order, const PlanDefaults& defaults) {
  reference_.lead(true);
  plan_vessel_.start(order, defaults, law_.route, own_.place(), own_.motion());
  follower_.restart();
  follower_.follow(law_, own_, lead_of_plan(), S(0));
}

template <class S>
void Guidance<S>::change_plan(const PlanOrder& order, const PlanDefaults& defaults) {
  plan_vessel_.change(order, defaults, law_.route);
}

template <class S>
Target Guidance<S>::stop_ahead(bool of_vessel) const {
  const core::Motion<S>& motion = of_vessel ? plan_vessel_.motion() : own_.motion();
  const convert::Position here = of_vessel ? plan_vessel_.place() : own_.place();
  const S u = core::max(motion.nu.u, S(0));
  const S way = u * u / (S(1.8) * law_.route.accel);  // braking distance, as in core/route.hpp
  const core::Vec2<S> on = core::to_north_east(motion.psi, core::Vec2<S>{way, S(0)});
  return {convert::global_of({here.north_m + on.x, here.east_m + on.y, here.origin}),
          static_cast<float>(convert::number(u))};
}

/// Within 1.5 look-aheads of a vessel at rest, a boat does not approach it (core/approach.hpp). So
/// the vessel must not wait for a boat that near, or both would stand still.
template <class S>
BoatBehind<S> Guidance<S>::behind() const {
  return {follower_.off(), core::max(S(3), S(2) * law_.controller.sight.Delta),
          law_.controller.outer.u_max};
}

template <class S>
core::ControllerOutput<S> Guidance<S>::sail(Plan plan, bool paused, std::int64_t now_us, S dt) {
  plan_vessel_.forward(plan, behind(), paused, dt);
  return follow_plan_vessel(now_us, dt);
}

template <class S>
core::ControllerOutput<S> Guidance<S>::drive(const core::Drive<S>& desired, bool paused,
                                             std::int64_t now_us, S dt) {
  if (S(0) < dt) plan_vessel_.drive(desired, behind(), paused, dt);
  return follow_plan_vessel(now_us, dt);
}

template <class S>
core::ControllerOutput<S> Guidance<S>::follow_plan_vessel(std::int64_t now_us, S dt) {
  const core::Motion<S>& motion = plan_vessel_.motion();
  reference_.tell({plan_vessel_.place(), {motion.psi, motion.nu, motion.nu_dot, S(0)}}, now_us);
  if (const auto foreseen = plan_vessel_.take_future()) {
    const double since_s = convert::number(foreseen->since);
    reference_.tell(foreseen->future, now_us - static_cast<std::int64_t>(1e6 * since_s));
  }
  follower_.follow(law_, own_, lead_of_plan(), dt);
  const auto out = step_law(now_us, dt);
  follower_.judge(law_, out, out.error, yaw_rate(), dt);
  return out;
}

template <class S>
core::ControllerOutput<S> Guidance<S>::step_law(std::int64_t now_us, S dt) {
  if (!neighbours_.any(now_us)) return step_law(nullptr, dt);
  auto traffic = neighbours_.traffic(own_.anchor(), own_.motion().moved_n, now_us);
  traffic.closed = closed_courses_;
  return step_law(&traffic, dt);
}

template <class S>
core::ControllerOutput<S> Guidance<S>::step_law(const core::Traffic<S>* traffic, S dt) {
  core::ControllerParams<S>& law = law_.controller;
  const core::SlotParams<S> own_slot = std::exchange(law.slot, follower_.lead().slot);
  const core::VirtualVelocityParams<S> usual = law.outer;
  const core::LineOfSightParams<S> usual_sight = law.sight;
  const bool hastens = kMoves && law.slot.moves;
  if (hastens) hasten(law.outer, law.sight);
  const auto out = follower_.step(law_, own_, traffic, dt);
  law.slot = own_slot;
  if (hastens) {
    law.outer = usual;
    law.sight = usual_sight;
  }
  own_.desire(out.desired.nu_star);
  return out;
}

template <class S>
core::ControllerOutput<S> Guidance<S>::step(std::int64_t now_us, S dt) {
  follower_.follow(law_, own_, lead(now_us), dt);
  const Branch& branch = follower_.lead().branch;
  leaders_reference_ = branch.root != 0 && branch.maker != own_.track().system();
  if (follower_.advance_shift_timer(dt)) follower_.shift(leaders_error(now_us));
  const auto out = step_law(now_us, dt);
  follower_.judge(law_, out, out.error, yaw_rate(), dt);
  return out;
}

template <class S>
core::ControllerOutput<S> Guidance<S>::coast(std::int64_t now_us, S dt) {
  follower_.coast(law_.coast_s, dt);
  const auto out = step_law(now_us, dt);
  // A boat that coasts because it left its slot may return to it; no other is judged in COAST.
  if (station_loss() != core::StationLoss::kNo) {
    follower_.judge(law_, out, look(now_us).error, yaw_rate(), dt);
  }
  return out;
}

template <class S>
bool Guidance<S>::can_coast() const {
  return located() && convert::near(own_.track().position(), follower_.lead().position);
}

template <class S>
core::ControllerOutput<S> Guidance<S>::look(std::int64_t now_us) const {
  const Lead<S> lead = this->lead(now_us);
  const core::ControllerInput<S> in = controller_input(lead, own_, law_.controller.vessel);
  core::SlotState<S> state = core::slot_start(in);
  core::ControllerOutput<S> out;
  out.slot = core::slot_forward(lead.slot, law_.controller.vessel, state, in, S(0));
  out.error = core::formation_error(in, out.slot);
  out.astern = core::goes_astern(lead.slot, in, out.slot);
  return out;
}

template <class S>
Estimates Guidance<S>::estimates() const {
  return {convert::in_double(core::unknown_wrench(law_.controller.vessel, own_.observer())),
          {convert::number(own_.observer().c_n.x), convert::number(own_.observer().c_n.y)}};
}

template <class S>
convert::OwnState Guidance<S>::own_state(std::int64_t now_us) const {
  const S since_stamp = convert::seconds<S>(now_us - convert::us_of_ms(now_us));
  const core::Motion<S> then = core::moment_before(own_.motion(), since_stamp);
  return convert::own_state_of(own_.anchor(), then);
}

template <class S>
std::optional<double> Guidance<S>::depth() const {
  return neighbours_.watches() ? std::optional<double>(neighbours_.depth()) : std::nullopt;
}

template <class S>
std::optional<double> Guidance<S>::own_age_s(std::int64_t now_us) const {
  return age_s(own_.track(), now_us);
}

template <class S>
std::optional<double> Guidance<S>::reference_age_s(std::int64_t now_us) const {
  const auto age_us = reference_.age_us(now_us);
  return age_us ? std::optional(convert::seconds<double>(*age_us)) : std::nullopt;
}

template <class S>
std::optional<double> Guidance<S>::leader_age_s(std::int64_t now_us) const {
  return age_s(leader_, now_us);
}

template class Guidance<float>;
template class Guidance<double>;
template class Guidance<core::Q16>;

}  // namespace flotilla::app
