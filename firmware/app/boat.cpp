// SPDX-License-Identifier: MIT
#include "app/boat.hpp"

#include <algorithm>

#include "app/text.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
using core::State;

constexpr std::int64_t kSecond_us = 1'000'000;
// ESCs want to see zeros after they were armed, before they are driven.
constexpr std::int64_t kArmedZeros_us = 200'000;
// Another own source must take over before FS_NAV_S stops the boat.
constexpr std::int64_t kOwnPatience_us = 300'000;
// 285 years: in ns it still fits 64 bits, and no clock says so in earnest.
constexpr std::int64_t kLatest_us = 9'000'000'000'000'000;

std::uint8_t byte_of(float parameter) { return static_cast<std::uint8_t>(parameter); }

}  // namespace

template <class S>
Boat<S>::Boat(const Parameters& p, std::size_t links)
    : parameters_(p),
      law_(convert::controller_params<S>(p)),
      own_({byte_of(p.MAV_SYSID), byte_of(p.MAV_COMPID), kOwnPatience_us},
           {p.NAV_OFS_X, p.NAV_OFS_Y}),
      leader_({byte_of(p.FORM_LEADER), 0}),
      thrusters_(p),
      can_({byte_of(p.CAN_NODE), byte_of(p.MAV_SYSID)}, convert::half_period_us(p.CTL_RATE)),
      links_(links, {byte_of(p.MAV_SYSID), byte_of(p.MAV_COMPID)}),
      heartbeat_due_(kSecond_us, convert::half_period_us(p.CTL_RATE)),
      state_due_(convert::period_us(p.SR_STATE), convert::half_period_us(p.CTL_RATE)),
      slow_due_(convert::period_us(p.SR_SLOW), convert::half_period_us(p.CTL_RATE)),
      origin_due_(kSecond_us, convert::half_period_us(p.CTL_RATE)),
      timesync_due_(kSecond_us, convert::half_period_us(p.CTL_RATE)),
      complaint_due_(10 * kSecond_us),
      refusal_due_(kSecond_us / 2) {}

template <class S>
std::int64_t Boat<S>::monotonic(std::int64_t now) {
  const std::int64_t now_us = std::clamp<std::int64_t>(now, 0, kLatest_us) + clock_shift_us_;
  if (now_us >= now_us_) {
    behind_since_us_.reset();
    now_us_ = std::min(now_us, kLatest_us);
    return now_us_;
  }
  ++counters_.clock_went_back;
  if (!behind_since_us_) behind_since_us_ = now_us;
  // A clock that was set back and goes on from there is followed again.
  if (now_us - *behind_since_us_ > kSecond_us) clock_shift_us_ += now_us_ - now_us;
  return now_us_;
}

template <class S>
void Boat<S>::on_mavlink(std::span<const std::uint8_t> data, std::int64_t now, std::size_t link) {
  const std::int64_t now_us = monotonic(now);
  link::MavlinkDecoder& decoder = links_.decoder(link);
  while (!data.empty()) {
    data = data.subspan(decoder.fill(data));
    while (const auto received = decoder.next(counters_)) {
      if (const auto* timesync = std::get_if<link::Timesync>(&received->message)) {
        if (timesync->tc1 == 0) {
          time_.asked(link, *timesync, now_us);
        } else if (const auto sent_us = time_.sent_us(*timesync)) {
          own_.answered(received->from, *sent_us, timesync->tc1 / 1000, now_us);
          leader_.answered(received->from, *sent_us, timesync->tc1 / 1000, now_us);
        }
      } else if (const auto* command = std::get_if<link::CommandLong>(&received->message)) {
        if (addressed_to(*command, parameters_)) {
          commands_.push({link, received->from, *command}, counters_);
        }
      } else {
        own_.take(*received, now_us, counters_);
        leader_.take(*received, now_us, counters_);
      }
    }
  }
}

template <class S>
void Boat<S>::on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now) {
  can_.on_frame(can_id, data, monotonic(now), counters_);
}

template <class S>
typename Boat<S>::Output Boat<S>::tick(std::int64_t now) {
  const std::int64_t now_us = monotonic(now);
  links_.begin(last_tick_us_ ? now_us - *last_tick_us_ : 0);
  can_output_.count = 0;
  idle_ticks_ = last_tick_us_ == now_us ? idle_ticks_ + 1 : 0;
  conditions_ = conditions(now_us);
  supervise(now_us);
  steer(now_us);
  can_.send(thrust_.raw, core::armed(state_), now_us, counters_, can_output_);
  report(now_us);
  last_tick_us_ = now_us;
  return {&links_, std::span(can_output_.frames).first(can_output_.count)};
}

template <class S>
core::Conditions Boat<S>::conditions(std::int64_t now_us) const {
  const Parameters& p = parameters_;
  const std::int64_t esc_limit_us = convert::microseconds(p.FS_ESC_S);
  core::Conditions met = 0;
  // Where time stands still nothing grows old, and nothing can be trusted.
  if (static_cast<float>(idle_ticks_) > p.FS_NAV_S * p.CTL_RATE) return met;
  if (own_.fresh(now_us, convert::microseconds(p.FS_NAV_S))) met |= core::kOwnFresh;
  if (leader_.fresh(now_us, convert::microseconds(p.FS_LEADER_S)) && leader_.has_origin() &&
      own_.has_origin() && convert::near(own_.position(), leader_.position())) {
    met |= core::kLeaderFresh;
  }
  if (can_.esc_online(byte_of(p.ESC_PORT), now_us, esc_limit_us) &&
      can_.esc_online(byte_of(p.ESC_STBD), now_us, esc_limit_us)) {
    met |= core::kEscsOnline;
  }
  if (host_.bus_up) met |= core::kBusUp;
  if (!can_.foreign_controller(now_us)) met |= core::kSoleController;
  if (host_.parameters_saved) met |= core::kParametersSaved;
  return met;
}

template <class S>
void Boat<S>::supervise(std::int64_t now_us) {
  const core::Verdict verdict = core::supervise(state_, core::Request::kNone, conditions_);
  if (verdict.granted) {
    enter(verdict.state, verdict.missing, now_us);
  }
  for (const PendingCommand& pending : commands_.pending()) answer(pending, now_us);
  commands_.clear();
}

template <class S>
void Boat<S>::answer(const PendingCommand& pending, std::int64_t now_us) {
  const Asked asked = meaning_of(pending, parameters_);
  save_requested_ = save_requested_ || asked.save_parameters;
  core::Verdict verdict{state_, true, 0};
  std::uint8_t result = asked.result;
  if (asked.request != core::Request::kNone) {
    verdict = core::supervise(state_, asked.request, conditions_);
    if (!verdict.granted) result = mav::kTemporarilyRejected;
  }
  links_.send(pending.link, link::CommandAck{pending.command.command, result, pending.from},
              counters_);
  if (verdict.state != state_) enter(verdict.state, 0, now_us);
  if (!verdict.granted) refuse(asked.request, verdict.missing, now_us);
}

template <class S>
void Boat<S>::refuse(core::Request request, core::Conditions missing, std::int64_t now_us) {
  if (!refusal_due_.due(now_us)) return;
  const auto what = request == core::Request::kArm ? "PreArm: " : "Refused: ";
  const auto state = state_ == State::kFault ? "FAULT, disarm first" : "arm first";
  const auto why = missing != 0 ? complaint_of(missing) : state;
  links_.broadcast(text_of(mav::kSeverityWarning, {what, why}), counters_);
}

template <class S>
void Boat<S>::enter(core::State state, core::Conditions missing, std::int64_t now_us) {
  if (core::armed(state) && !core::armed(state_)) armed_us_ = now_us;
  state_ = state;
  starting_ = state == State::kFormation;
  const std::string_view why = complaint_of(missing);
  const std::uint8_t severity = missing != 0 ? mav::kSeverityError : mav::kSeverityInfo;
  links_.broadcast(text_of(severity, {name_of(state), why.empty() ? "" : ": ", why}), counters_);
  announce_ = true;
}

template <class S>
void Boat<S>::reckon(std::int64_t now_us) {
  const std::int64_t since_us = now_us - last_tick_us_.value_or(now_us);
  core::reckon_forward(law_.vessel, own_now_, thrust_.given, convert::seconds<S>(since_us));
  if (own_.messages() == own_messages_) return;
  own_messages_ = own_.messages();
  const auto& last = own_.last();
  const S age = convert::seconds<S>(own_.age_us(now_us).value_or(0));
  core::reckon_from(core::ReckoningParams<S>{}, law_.vessel, own_now_,
                    {last.psi, last.nu, age, last.dt}, thrust_.given);
}

template <class S>
core::Encounter<S> Boat<S>::encounter(std::int64_t now_us) const {
  return convert::encounter_of<S>(own_.position(), own_now_.motion, leader_.position(),
                                  leader_.motion(now_us));
}

template <class S>
void Boat<S>::steer(std::int64_t now_us) {
  const S dt = last_tick_us_ ? convert::seconds<S>(now_us - *last_tick_us_) : S(0);
  const bool drive = core::may_drive(state_, conditions_) && now_us - armed_us_ >= kArmedZeros_us;
  law_output_ = {};
  reckon(now_us);
  if (drive) {
    const core::Encounter<S> in = encounter(now_us);
    if (starting_) law_state_ = core::controller_start(in);
    law_output_ = core::controller_step(law_, law_state_, in, starting_ ? S(0) : dt);
    starting_ = false;
  } else if ((conditions_ & core::kOwnFresh) != 0 && (conditions_ & core::kLeaderFresh) != 0) {
    law_output_.error = core::formation_error(encounter(now_us), law_.d);
  }
  thrust_ = thrusters_.step(drive && core::may_drive(state_, conditions_),
                            law_output_.allocation.thrust, dt);
}

template <class S>
link::Heartbeat Boat<S>::heartbeat() const {
  const bool formation = state_ == State::kFormation;
  const bool armed = core::armed(state_);
  return {formation ? mode::kFormation : mode::kHold, mav::kTypeSurfaceBoat, mav::kAutopilotGeneric,
          static_cast<std::uint8_t>(mav::kModeFlagCustom | (armed ? mav::kModeFlagArmed : 0)),
          state_ == State::kFault ? mav::kStateEmergency
                                  : (armed ? mav::kStateActive : mav::kStateStandby)};
}

template <class S>
void Boat<S>::report(std::int64_t now_us) {
  for (const TimeRequests::Owed& owed : time_.owed()) {
    links_.send(owed.link, owed.answer, counters_);
  }
  time_.clear_owed();
  if (heartbeat_due_.due(now_us) || announce_) links_.broadcast(heartbeat(), counters_);
  announce_ = false;
  if (timesync_due_.due(now_us)) {
    links_.broadcast(time_.ask(now_us, byte_of(parameters_.MAV_SYSID)), counters_);
  }
  const bool complaint = own_.take_frame_complaint() | leader_.take_frame_complaint();
  if (complaint && complaint_due_.due(now_us)) {
    links_.broadcast(
        text_of(mav::kSeverityWarning, {"ODOMETRY refused: frame is not north-aligned"}),
        counters_);
  }
  if (slow_due_.due(now_us)) report_slowly(now_us);
  if ((conditions_ & core::kOwnFresh) == 0) return;
  if (state_due_.due(now_us)) {
    const std::uint32_t stamp_ms = convert::boot_ms(now_us);
    const convert::Position at = own_.position();
    const S since_stamp = convert::seconds<S>(now_us - convert::us_of_ms(now_us));
    const convert::OwnState<S> own{at.north_m, at.east_m,
                                   core::moment_before(own_now_.motion, since_stamp)};
    links_.broadcast_telemetry(
        {convert::attitude_of(own, stamp_ms), convert::local_position_of(own, stamp_ms)},
        counters_);
  }
  if (own_.has_origin() && origin_due_.due(now_us)) {
    link::GpsGlobalOrigin origin = own_.position().origin;
    origin.time_usec = static_cast<std::uint64_t>(now_us);
    links_.broadcast(origin, counters_);
  }
}

template <class S>
void Boat<S>::report_slowly(std::int64_t now_us) {
  const auto say = [&](std::string_view name, float value) {
    links_.broadcast_telemetry({value_of(name, value, convert::boot_ms(now_us))}, counters_);
  };
  if (const auto age = own_.age_us(now_us)) say("NAV_AGE", convert::seconds<float>(*age));
  if (const auto age = leader_.age_us(now_us)) say("LEAD_AGE", convert::seconds<float>(*age));
  say("OVERRUNS", static_cast<float>(host_.overruns));
}

template <class S>
Snapshot Boat<S>::snapshot() const {
  const auto age_s = [&](const VesselTrack<S>& track) -> std::optional<double> {
    const auto age = last_tick_us_ ? track.age_us(*last_tick_us_) : std::nullopt;
    if (!age) return std::nullopt;
    return convert::seconds<double>(*age);
  };
  const auto& law = law_output_;
  const auto& e = law.error.e;
  const auto& star = law.wanted.nu_star;
  constexpr core::Conditions kSeen = core::kOwnFresh | core::kLeaderFresh;
  return {state_,
          conditions_,
          age_s(own_),
          age_s(leader_),
          (conditions_ & kSeen) == kSeen,
          {double(e.x), double(e.y), double(e.psi)},
          {double(star.u), double(star.v), double(star.r)},
          {double(law.tau.X), double(law.tau.N)},
          {double(thrust_.given.X), double(thrust_.given.N)},
          {double(thrust_.thrust.port), double(thrust_.thrust.stbd)},
          law.allocation.surge_limited,
          law.allocation.yaw_limited,
          thrust_.slew_limited,
          counters_};
}

template class Boat<float>;
template class Boat<double>;

}  // namespace flotilla::app
