// SPDX-License-Identifier: MIT
#include "app/guidance/pilot.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

namespace flotilla::app {
namespace {

// Another own source must take over before FS_NAV_S stops the boat.
constexpr std::int64_t kOwnPatience_us = 300'000;
// A boat that is pushed must report motion before then, too.
constexpr std::int64_t kOwnFrozen_us = 300'000;
// Assumed latency of a unit while none has been estimated.
constexpr float kUnknown_s = 0.3F;
// Greatest latency that is compensated: with hulls half off their model, predicting over 0.3 s
// costs 0.2 m behind the S-curve (tests/loop/test_late_unit.py).
constexpr float kMaxLate_s = 0.35F;
constexpr std::int64_t kAsked_us = 1'200'000;  // TIMESYNC's period of 1 s, and time for the answer
constexpr float kSlewOfLag = 0.2F;             // s per s
constexpr float kSeldom_s = 0.045F;            // fixes closer together add no information

std::uint8_t byte_of(float parameter) { return static_cast<std::uint8_t>(parameter); }

template <class S>
std::optional<double> age_s(const VesselTrack<S>& track, std::int64_t now_us) {
  const auto age_us = track.age_us(now_us);
  if (!age_us || !track.timed()) return std::nullopt;
  return convert::seconds<double>(*age_us);
}

}  // namespace

template <class S>
Pilot<S>::Pilot(const Parameters& p)
    : law_(convert::controller_params<S>(p)),
      keeping_(convert::station_params<S>(p)),
      coast_s_(convert::scalar<S>(p.FS_COAST_S)),
      observer_(convert::observer_params<S>(p)),
      own_({byte_of(p.MAV_SYSID), byte_of(p.MAV_COMPID), kOwnPatience_us, kOwnFrozen_us, true,
            byte_of(p.NAV_COMPID)},
           {convert::scalar<S>(p.NAV_OFS_X), convert::scalar<S>(p.NAV_OFS_Y)}),
      leader_({byte_of(p.FORM_LEADER), 0}) {
  set_limits(p);
  set_latency(p);
  set_link(p);
  neighbours_.configure(own_.system(), leader_.system(), p.FS_SEP_M);
  reference_.configure(p, own_.system());
  claims_.configure(own_.system(), leader_.system(), 2 * p.THR_ARM);
}

template <class S>
void Pilot<S>::set_latency(const Parameters& p) {
  latency_params_.d = p.VES_D33 / p.VES_M33;
  inertia_ = p.VES_M33;
  const float named_s = std::max(p.NAV_LAG_S, 0.0F);
  if (known_lag_s_ != named_s) forget_latency();
  known_lag_s_ = named_s;
  lag_named_ = 0 <= p.NAV_LAG_S;
  set_lag();
  leader_.set_lag(convert::known_us(p.FORM_LAG_S));
}

template <class S>
void Pilot<S>::forget_latency() {
  latency_ = {};
  found_.reset();
  lag_s_ = 0;
}

template <class S>
void Pilot<S>::set_lag() {
  const bool known = lag_named_ || found_;
  own_.set_lag(known ? std::optional(convert::microseconds(known_lag_s_ + lag_s_)) : std::nullopt);
}

template <class S>
void Pilot<S>::set_limits(const Parameters& p) {
  afloat_ = convert::plausibility_limits<S>(p, false);
  carried_ = convert::plausibility_limits<S>(p, true);
  own_.set_limits(armed_ ? afloat_ : carried_);
}

template <class S>
void Pilot<S>::configure(const Parameters& p, std::uint8_t own_system) {
  law_ = convert::controller_params<S>(p);
  keeping_ = convert::station_params<S>(p);
  coast_s_ = convert::scalar<S>(p.FS_COAST_S);
  observer_ = convert::observer_params<S>(p);
  set_limits(p);
  set_latency(p);
  own_.set_antenna({convert::scalar<S>(p.NAV_OFS_X), convert::scalar<S>(p.NAV_OFS_Y)});
  set_link(p);
  if (own_system != own_.system()) own_link_.reset();
  own_.follow(own_system, byte_of(p.NAV_COMPID));
  leader_.follow(byte_of(p.FORM_LEADER));
  neighbours_.configure(own_system, leader_.system(), p.FS_SEP_M);
  reference_.configure(p, own_system);
  claims_.configure(own_system, leader_.system(), 2 * p.THR_ARM);
}

template <class S>
void Pilot<S>::set_link(const Parameters& p) {
  named_link_.reset();
  if (p.NAV_LINK >= 0) named_link_ = static_cast<std::size_t>(p.NAV_LINK);
}

/// Not by a radio that anybody may speak on: by the first link that a good state came by while the
/// boat was disarmed.
template <class S>
bool Pilot<S>::may_be_own(std::size_t link, std::int64_t now_us) const {
  const auto& pinned = named_link_ ? named_link_ : own_link_;
  return !pinned || *pinned == link || (!named_link_ && !armed_ && own_.silent(now_us));
}

template <class S>
void Pilot<S>::take(const link::Received& received, std::size_t link, std::int64_t now_us,
                    link::Counters& counters) {
  if (const auto* answer = std::get_if<link::Timesync>(&received.message)) {
    take_time(received.from, *answer, now_us);
    return;
  }
  if (received.from.system == own_.system() && may_be_own(link, now_us)) {
    own_.take(received, now_us, counters);
    if (own_.accepted(now_us)) own_link_ = link;
  }
  leader_.take(received, now_us, counters);
  const convert::Position place = own_.position();
  reference_.take(received, own_.has_origin() ? &place : nullptr, now_us, counters);
  claims_.hear(received, reference_.place(), now_us);
  if (neighbours_.watches() && own_.has_origin()) {
    neighbours_.take<S>(received, own_.position(), now_us);
  }
}

template <class S>
void Pilot<S>::take_time(link::Address from, const link::Timesync& answer, std::int64_t now_us) {
  const auto sent_us = time_.sent_us(answer);
  if (!sent_us) return;
  const std::int64_t read_us = answer.tc1 / 1000;
  own_.answered(from, *sent_us, read_us, now_us);
  leader_.answered(from, *sent_us, read_us, now_us);
  reference_.answered(from, *sent_us, read_us, now_us);
}

template <class S>
core::Conditions Pilot<S>::conditions(std::int64_t now_us, const Parameters& p, bool sails) const {
  core::Conditions met = 0;
  if (own_.fresh(now_us, convert::microseconds(p.FS_NAV_S))) met |= core::kOwnFresh;
  if (leader_.system() != own_.system() &&
      leader_.fresh(now_us, convert::microseconds(p.FS_LEADER_S)) && leader_.has_origin() &&
      own_.has_origin() && convert::near(own_.position(), leader_.position())) {
    met |= core::kLeaderFresh;
  }
  if (neighbours_.clear(anchor_, motion_.motion.moved_n, now_us)) met |= core::kClear;
  if (answers_ || !own_.has_moved()) met |= core::kBoatAnswers;
  if (!reference_.place().is_cycle(now_us)) met |= core::kLeadersEnd;
  if (!claims_.leaders(reference_.place()) && !claims_.rival(now_us, sails))
    met |= core::kSlotSound;
  if (known_lag_s_ + found_.value_or(0) <= kMaxLate_s || own_.bounded()) met |= core::kOwnPrompt;
  if (own_.timed()) met |= core::kOwnTimed;
  if (leader_.timed()) met |= core::kLeaderTimed;
  if (own_.live()) met |= core::kOwnLive;
  if (own_.steady(now_us)) met |= core::kOwnSteady;
  if (leader_.live()) met |= core::kLeaderLive;
  if (leader_.steady(now_us)) met |= core::kLeaderSteady;
  return met;
}

template <class S>
void Pilot<S>::observe(std::int64_t now_us, S since, const core::Tau<S>& given, bool armed) {
  reference_.make(leader_, now_us);
  look_at_clock(now_us);
  if (armed != armed_) {
    own_.set_limits(armed ? afloat_ : carried_);
    own_.hold(armed);
    own_.set_smoothing(!armed);  // the observer extrapolates from each message
  }
  armed_ = armed;
  if (!armed) {
    motion_ = {};
    motion_.motion = own_.motion(now_us);
    anchor_ = own_.position();
    answer_ = {};
    answers_ = true;
    latency_ = {};
    if (const auto fix = own_.take_fix()) told_ = fix->nu;
    return;
  }
  if (finds_latency_) {
    core::latency_forward(latency_, static_cast<float>(convert::number(given.N)) / inertia_,
                          static_cast<float>(convert::number(since)));
  }
  weigh(given, since);
  own_.push(since *
            core::max(core::abs(given.X) / law_.vessel.m11, core::abs(given.N) / law_.vessel.m33));
  core::observer_forward(law_.vessel, motion_, given, since);
  const convert::Position before = std::exchange(anchor_, own_.position());
  const auto fix = own_.take_fix();
  if (!fix) return;
  told_ = fix->nu;
  if (finds_latency_) find_latency(*fix, now_us);
  const S age = convert::seconds<S>(own_.age_us(now_us).value_or(0));
  const auto [way, near] = convert::separation<S>(before, anchor_);
  const core::Vec2<S>& moved = motion_.motion.moved_n;
  const core::ObserverParams<S> observer = careful_observer();
  core::observer_correct(
      observer, law_.vessel, motion_,
      {{way.x + moved.x, way.y + moved.y}, fix->psi, fix->nu, age, near ? fix->dt : S(0)});
}

/// Estimates the latency only of units that do not answer TIMESYNC, and only with an observer:
/// without one the law takes each fix as it is, as in the paper.
template <class S>
void Pilot<S>::look_at_clock(std::int64_t now_us) {
  if (own_.bounded() || !own_.age_us(now_us) || unanswered_us_ == 0) unanswered_us_ = now_us;
  finds_latency_ = S(0) < observer_.omega && now_us - unanswered_us_ > kAsked_us;
  if (finds_latency_ || (!found_ && lag_s_ == 0)) return;
  forget_latency();
  set_lag();
}

template <class S>
void Pilot<S>::find_latency(const core::TrackMessage<S>& fix, std::int64_t now_us) {
  const float since = static_cast<float>(convert::number(fix.dt));
  if (!(0 < since && since < 0.5F)) {
    latency_ = {};
    fix_s_ = 0;
    return;
  }
  fix_s_ += since;
  if (fix_s_ < kSeldom_s) return;
  const float dt = std::exchange(fix_s_, 0.0F);
  const float age =
      std::max(convert::seconds<float>(own_.age_us(now_us).value_or(0)) - lag_s_, 0.0F);
  core::latency_correct(latency_params_, latency_, static_cast<float>(convert::number(fix.nu.r)),
                        age, dt);
  const auto late = core::latency_of(latency_params_, latency_);
  if (late.known) found_ = late.tau;
  if (!found_) return;
  const float most = kSlewOfLag * dt;
  lag_s_ += std::clamp(std::min(*found_, kMaxLate_s) - lag_s_, -most, most);
  set_lag();
}

/// Averages fixes with uncompensated latency over a longer time: a boat that follows each fix at
/// once would keep correcting its own past turn.
template <class S>
core::ObserverParams<S> Pilot<S>::careful_observer() const {
  core::ObserverParams<S> out = observer_;
  if (!finds_latency_) return out;
  const float unknown_s = found_ ? std::abs(*found_ - lag_s_) : kUnknown_s;
  out.T = out.T + convert::scalar<S>(1.5F * unknown_s);
  out.omega = core::min(out.omega, S(1) / out.T);
  return out;
}

template <class S>
std::optional<double> Pilot<S>::latency_s() const {
  return found_ ? std::optional<double>(*found_) : std::nullopt;
}

/// Averages over 50 ms: the thrust response takes half a second.
template <class S>
void Pilot<S>::weigh(const core::Tau<S>& given, S since) {
  pushed_ = {pushed_.X + since * given.X, pushed_.N + since * given.N};
  pushed_s_ = pushed_s_ + since;
  if (pushed_s_ < S(0.05)) return;
  const core::ThrustResponseParams<S> params{.vessel = law_.vessel, .propellers = law_.propellers};
  core::thrust_response_forward(params, answer_, told_, std::exchange(desired_, told_),
                                {pushed_.X / pushed_s_, pushed_.N / pushed_s_},
                                core::min(pushed_s_, S(1)));
  answers_ = core::answers(params, answer_);
  pushed_ = {};
  pushed_s_ = S(0);
}

/// The formation's root if its reference can be followed, else the leader.
template <class S>
typename Pilot<S>::Lead Pilot<S>::lead(std::int64_t now_us) const {
  const auto aim = reference_.aim(now_us);
  if (!aim) {
    return {leader_.system(), {}, leader_.position(), leader_.motion(now_us), {}, law_.slot};
  }
  core::SlotParams<S> slot = law_.slot;
  slot.d = convert::offset_of<S>(aim->offset.b);
  slot.turns = slot.turns || aim->offset.b != convert::WireOffset{};
  slot.steers = slot.steers || slot.turns;
  return {leader_.system(),
          aim->branch,
          aim->position,
          aim->motion,
          convert::offset_of<S>(aim->offset.n),
          slot};
}

template <class S>
core::ControllerInput<S> Pilot<S>::controller_input(const Lead& lead) const {
  auto in = convert::controller_input_of<S>(anchor_, motion_.motion, lead.position, lead.motion);
  in.separation_n = {in.separation_n.x - lead.offset_n.x, in.separation_n.y - lead.offset_n.y};
  in.current_n = motion_.c_n;
  in.unknown = core::unknown_wrench(law_.vessel, motion_);
  return in;
}

/// A change of lead makes no step for a boat in its slot: the step fades out. A boat that still
/// closes up heads for the new slot at once. A new slot of the same lead restarts the approach.
template <class S>
void Pilot<S>::follow(const Lead& next, S dt) {
  if (lead_.leader != next.leader) starting_ = true;
  if (starting_ || (lead_.branch == next.branch && !same_slot(lead_, next))) station_ = {};
  if (starting_) {
    shift_n_ = {};
    blend_ = {};
  } else if (lead_.branch != next.branch && S(1) < core::hypot(error_.e.x, error_.e.y)) {
    blend_ = {};
  } else if (lead_.branch != next.branch) {
    const auto in = controller_input(next);
    const core::Vec2<S> d_n =
        next.slot.turns ? core::to_north_east(in.psi_L, next.slot.d) : next.slot.d;
    const core::Vec2<S> was = core::to_north_east(error_.R, core::Vec2<S>{error_.e.x, error_.e.y});
    blend_ = core::blend_start(core::Vec2<S>{in.separation_n.x - d_n.x - shift_n_.x - was.x,
                                             in.separation_n.y - d_n.y - shift_n_.y - was.y});
  }
  lead_ = next;
  coast_ = core::coast_start(next.motion);
  core::blend_forward(blend_, dt);
}

/// Shifts the slot slowly towards the leader's actual position, if it was computed from the root.
template <class S>
void Pilot<S>::shift_slot(std::int64_t now_us, S dt) {
  shift_s_ = shift_s_ + dt;
  if (shift_s_ < S(0.2)) return;
  core::Vec2<S> e_L{};
  if (lead_.branch.root != 0 && lead_.branch.root != lead_.leader) {
    const RootOffset slot = reference_.place().leaders_offset(now_us);
    const auto seen = convert::controller_input_of<S>(leader_.position(), leader_.motion(now_us),
                                                      lead_.position, lead_.motion);
    const core::Vec2<S> n = convert::offset_of<S>(slot.n);
    const core::Vec2<S> b = core::to_north_east(seen.psi_L, convert::offset_of<S>(slot.b));
    e_L = {seen.separation_n.x - n.x - b.x, seen.separation_n.y - n.y - b.y};
  }
  shift_n_ = core::shift_forward(core::ShiftParams<S>{}, shift_n_, e_L,
                                 core::min(std::exchange(shift_s_, S(0)), S(1)));
}

template <class S>
core::ControllerOutput<S> Pilot<S>::step_among_others(const core::ControllerInput<S>& in,
                                                      std::int64_t now_us, S dt) {
  const auto traffic = neighbours_.traffic(anchor_, motion_.motion.moved_n, now_us);
  return core::controller_step(law_, state_, in, dt, &traffic);
}

template <class S>
bool Pilot<S>::same_slot(const Lead& a, const Lead& b) {
  const auto same = [](const core::Vec2<S>& p, const core::Vec2<S>& q) {
    return p.x == q.x && p.y == q.y;
  };
  return a.slot.turns == b.slot.turns && same(a.slot.d, b.slot.d) && same(a.offset_n, b.offset_n);
}

/// error: relative to the slot behind the leader as received.
template <class S>
void Pilot<S>::keep_station(const core::ControllerOutput<S>& out,
                            const core::FormationError<S>& error, S dt) {
  const auto& [desired, allocation] = std::tie(out.desired, out.allocation);
  const bool limited =
      desired.u_limited || desired.r_limited || allocation.surge_limited || allocation.yaw_limited;
  const bool at_rest = core::abs(out.slot.pace) < S(1.5) * law_.sight.epsilon;
  core::station_forward(keeping_, station_,
                        {core::hypot(error.e.x, error.e.y), motion_.motion.nu.r, limited,
                         out.separation.yielding, at_rest},
                        dt);
}

template <class S>
core::ControllerOutput<S> Pilot<S>::step_behind(const Lead& lead, std::int64_t now_us, S dt) {
  core::ControllerInput<S> in = controller_input(lead);
  const core::Vec2<S> rest = core::rest_of(blend_);
  in.separation_n = {in.separation_n.x - rest.x - shift_n_.x,
                     in.separation_n.y - rest.y - shift_n_.y};
  if (starting_) state_ = core::controller_start(in);
  const S since = std::exchange(starting_, false) ? S(0) : dt;
  const core::SlotParams<S> own_slot = std::exchange(law_.slot, lead.slot);
  const auto out = neighbours_.watches() ? step_among_others(in, now_us, since)
                                         : core::controller_step(law_, state_, in, since);
  law_.slot = own_slot;
  error_ = out.error;
  desired_ = out.desired.nu_star;
  return out;
}

template <class S>
void Pilot<S>::start(std::int64_t now_us) {
  starting_ = true;
  answer_ = {};
  answers_ = true;
  follow(lead(now_us), S(0));
}

template <class S>
core::ControllerOutput<S> Pilot<S>::step(std::int64_t now_us, S dt) {
  follow(lead(now_us), dt);
  shift_slot(now_us, dt);
  const auto out = step_behind(lead_, now_us, dt);
  keep_station(out, out.error, dt);
  return out;
}

template <class S>
core::ControllerOutput<S> Pilot<S>::coast(std::int64_t now_us, S dt) {
  core::coast_forward(coast_s_, coast_, dt);
  lead_.motion = coast_.leader;
  const auto out = step_behind(lead_, now_us, dt);
  // A boat that coasts because it left its slot may return to it; no other is judged in COAST.
  if (station_.astray != core::Astray::kNo) keep_station(out, look(now_us).error, dt);
  return out;
}

template <class S>
bool Pilot<S>::can_coast() const {
  return own_.has_origin() && convert::near(own_.position(), lead_.position);
}

template <class S>
core::ControllerOutput<S> Pilot<S>::look(std::int64_t now_us) const {
  const Lead lead = this->lead(now_us);
  const core::ControllerInput<S> in = controller_input(lead);
  core::SlotState<S> state = core::slot_start(in);
  core::ControllerOutput<S> out;
  out.slot = core::slot_forward(lead.slot, law_.vessel, state, in, S(0));
  out.error = core::formation_error(in, out.slot);
  out.astern = core::goes_astern(lead.slot, in, out.slot);
  return out;
}

template <class S>
Estimates Pilot<S>::estimates() const {
  return {convert::in_double(core::unknown_wrench(law_.vessel, motion_)),
          {convert::number(motion_.c_n.x), convert::number(motion_.c_n.y)}};
}

template <class S>
convert::OwnState Pilot<S>::own_state(std::int64_t now_us) const {
  const S since_stamp = convert::seconds<S>(now_us - convert::us_of_ms(now_us));
  const core::Motion<S> then = core::moment_before(motion_.motion, since_stamp);
  return convert::own_state_of(anchor_, then);
}

template <class S>
convert::Position Pilot<S>::place() const {
  const core::Vec2<S>& moved = motion_.motion.moved_n;
  return {anchor_.north_m + moved.x, anchor_.east_m + moved.y, anchor_.origin};
}

template <class S>
std::optional<double> Pilot<S>::depth() const {
  return neighbours_.watches() ? std::optional<double>(neighbours_.depth()) : std::nullopt;
}

template <class S>
std::optional<double> Pilot<S>::own_age_s(std::int64_t now_us) const {
  return age_s(own_, now_us);
}

template <class S>
std::optional<double> Pilot<S>::reference_age_s(std::int64_t now_us) const {
  const auto age_us = reference_.age_us(now_us);
  return age_us ? std::optional(convert::seconds<double>(*age_us)) : std::nullopt;
}

template <class S>
std::optional<double> Pilot<S>::leader_age_s(std::int64_t now_us) const {
  return age_s(leader_, now_us);
}

template class Pilot<float>;
template class Pilot<double>;
template class Pilot<core::Q16>;

}  // namespace flotilla::app
