// SPDX-License-Identifier: MIT
#include "app/boat.hpp"

#include <algorithm>
#include <utility>

#include "core/manual.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;
// ESCs want to see zeros after they were armed, before they are driven.
constexpr std::int64_t kArmedZeros_us = 200'000;
// Another own source must take over before FS_NAV_S stops the boat.
constexpr std::int64_t kOwnPatience_us = 300'000;
// 285 years: in ns it still fits 64 bits, and no clock says so in earnest.
constexpr std::int64_t kLatest_us = 9'000'000'000'000'000;

std::uint8_t byte_of(float parameter) { return static_cast<std::uint8_t>(parameter); }

template <class S>
std::optional<double> age_of(const VesselTrack<S>& track, std::int64_t now_us) {
  const auto age_us = track.age_us(now_us);
  if (!age_us) return std::nullopt;
  return convert::seconds<double>(*age_us);
}

}  // namespace

template <class S>
Boat<S>::Boat(const Parameters& p, std::size_t links)
    : vehicle_(p, links),
      tick_rate_Hz_(p.CTL_RATE),
      law_(convert::controller_params<S>(p)),
      own_({byte_of(p.MAV_SYSID), byte_of(p.MAV_COMPID), kOwnPatience_us},
           {p.NAV_OFS_X, p.NAV_OFS_Y}),
      leader_({byte_of(p.FORM_LEADER), 0}),
      thrusters_(p),
      can_({byte_of(p.CAN_NODE), byte_of(p.MAV_SYSID)}, convert::half_period_us(p.CTL_RATE)),
      complaint_due_(10 * kSecond_us) {}

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
  while (!data.empty()) {
    data = data.subspan(vehicle_.links().decoder(link).fill(data));
    take_all(link, now_us);
  }
}

template <class S>
void Boat<S>::end_of_datagram(std::int64_t now, std::size_t link) {
  give_up(link, monotonic(now));
}

template <class S>
void Boat<S>::take_all(std::size_t link, std::int64_t now_us) {
  const std::uint32_t before = vehicle_.links().decoder(link).whole();
  while (const auto received = vehicle_.next(link, now_us, counters_)) {
    if (const auto* timesync = std::get_if<link::Timesync>(&received->message)) {
      if (const auto sent_us = vehicle_.sent_us(*timesync)) {
        own_.answered(received->from, *sent_us, timesync->tc1 / 1000, now_us);
        leader_.answered(received->from, *sent_us, timesync->tc1 / 1000, now_us);
      }
    } else {
      own_.take(*received, now_us, counters_);
      leader_.take(*received, now_us, counters_);
    }
  }
  const bool heard = vehicle_.links().decoder(link).whole() != before;
  vehicle_.links().note_waiting(link, heard, now_us);
}

/// Nothing more of the message that is waited for will come; another may be hidden behind it.
template <class S>
void Boat<S>::give_up(std::size_t link, std::int64_t now_us) {
  link::MavlinkDecoder& decoder = vehicle_.links().decoder(link);
  while (decoder.waits()) {
    decoder.give_up(counters_);
    take_all(link, now_us);
  }
}

template <class S>
void Boat<S>::on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now) {
  can_.on_frame(can_id, data, monotonic(now), counters_);
}

template <class S>
typename Boat<S>::Output Boat<S>::tick(std::int64_t now) {
  const std::int64_t now_us = monotonic(now);
  vehicle_.begin(now_us, last_tick_us_ ? now_us - *last_tick_us_ : 0);
  can_output_.count = 0;
  idle_ticks_ = last_tick_us_ == now_us ? idle_ticks_ + 1 : 0;
  for (std::size_t link = 0; link < vehicle_.links().count(); ++link) {
    if (vehicle_.links().waits_in_vain(link, now_us)) give_up(link, now_us);
  }
  supervise(now_us);
  steer(now_us);
  can_.send(thrust_.raw, core::armed(state()), now_us, counters_, can_output_);
  complain(now_us);
  vehicle_.tell(report(now_us), counters_);
  last_tick_us_ = now_us;
  return {&vehicle_.links(), std::span(can_output_.frames).first(can_output_.count)};
}

template <class S>
void Boat<S>::supervise(std::int64_t now_us) {
  if (vehicle_.take_change()) configure();
  vehicle_.heed(conditions_ = conditions(now_us), counters_);
  bool more = true;
  while (more) {
    more = vehicle_.answer(counters_);
    note_state(now_us);
    if (!vehicle_.take_change()) continue;
    // What was set is in force before the next request: another leader, say, was not heard yet.
    configure();
    vehicle_.heed(conditions_ = conditions(now_us), counters_);
  }
  note_state(now_us);
}

/// A stop that is followed by other requests in the same tick was one all the same.
template <class S>
void Boat<S>::note_state(std::int64_t now_us) {
  const core::State was = std::exchange(last_state_, state());
  if (core::armed(state()) && !core::armed(was)) armed_us_ = now_us;
  starting_ = starting_ || (state() == core::State::kFormation && was != state());
}

template <class S>
void Boat<S>::configure() {
  const Parameters& p = parameters();
  law_ = convert::controller_params<S>(p);
  own_.set_antenna({p.NAV_OFS_X, p.NAV_OFS_Y});
  if (vehicle_.self().system != own_.system()) own_.follow(vehicle_.self().system);
  if (byte_of(p.FORM_LEADER) != leader_.system()) {
    leader_.follow(byte_of(p.FORM_LEADER));
    starting_ = true;
  }
  if (!core::armed(state())) thrusters_ = Thrusters<S>(p);
}

template <class S>
core::Conditions Boat<S>::conditions(std::int64_t now_us) const {
  const Parameters& p = parameters();
  const std::int64_t esc_limit_us = convert::microseconds(p.FS_ESC_S);
  core::Conditions met = vehicle_.conditions(now_us);
  // Where time stands still nothing grows old, and nothing can be trusted.
  if (static_cast<float>(idle_ticks_) > p.FS_NAV_S * tick_rate_Hz_) return 0;
  if (own_.fresh(now_us, convert::microseconds(p.FS_NAV_S))) met |= core::kOwnFresh;
  if (leader_.system() != own_.system() &&
      leader_.fresh(now_us, convert::microseconds(p.FS_LEADER_S)) && leader_.has_origin() &&
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
bool Boat<S>::may_drive(std::int64_t now_us) const {
  return core::may_drive(state(), conditions_) && now_us - armed_us_ >= kArmedZeros_us;
}

template <class S>
core::Thrust<S> Boat<S>::wanted_thrust(std::int64_t now_us, S dt) {
  switch (state()) {
    case core::State::kManual: {
      const Sticks& sticks = vehicle_.sticks();
      law_output_.tau = core::stick_wrench(law_.propellers, static_cast<S>(sticks.surge),
                                           static_cast<S>(sticks.yaw));
      law_output_.allocation = core::allocate(law_.propellers, law_output_.tau);
      break;
    }
    case core::State::kTest: {
      const MotorTest& test = *vehicle_.motor_test();
      law_output_.allocation.thrust = core::test_thrust(
          law_.propellers, test.stbd ? core::Propeller::kStbd : core::Propeller::kPort,
          static_cast<S>(test.share));
      break;
    }
    default: {
      const core::Encounter<S> in = encounter(now_us);
      if (starting_) law_state_ = core::controller_start(in);
      law_output_ = core::controller_step(law_, law_state_, in, starting_ ? S(0) : dt);
      starting_ = false;
    }
  }
  return law_output_.allocation.thrust;
}

template <class S>
void Boat<S>::steer(std::int64_t now_us) {
  const S dt = last_tick_us_ ? convert::seconds<S>(now_us - *last_tick_us_) : S(0);
  law_output_ = {};
  reckon(now_us);
  core::Thrust<S> wanted{};
  const bool drive = may_drive(now_us);
  if (drive) wanted = wanted_thrust(now_us, dt);
  const bool formation = drive && state() == core::State::kFormation;
  if (!formation && seen()) {
    law_output_.error = core::formation_error(encounter(now_us), law_.d);
  }
  // Asked once more, of conditions that are looked at anew.
  const bool still = drive && core::may_drive(state(), conditions(now_us));
  thrust_ = thrusters_.step(still, wanted, dt);
}

template <class S>
void Boat<S>::complain(std::int64_t now_us) {
  const bool complaint = own_.take_frame_complaint() | leader_.take_frame_complaint();
  if (complaint && complaint_due_.due(now_us)) {
    vehicle_.say(link::mav::kSeverityWarning, {"ODOMETRY refused: frame is not north-aligned"},
                 counters_);
  }
  if (!std::exchange(save_failed_, host_.save_failed) && save_failed_) {
    vehicle_.say(link::mav::kSeverityError, {"parameters could not be saved: see the host's disk"},
                 counters_);
  }
}

template <class S>
std::optional<OwnReport> Boat<S>::own_report(std::int64_t now_us) const {
  if ((conditions_ & core::kOwnFresh) == 0) return std::nullopt;
  const S since_stamp = convert::seconds<S>(now_us - convert::us_of_ms(now_us));
  const core::Motion<S> then = core::moment_before(own_now_.motion, since_stamp);
  const convert::Position at = own_.position();
  return OwnReport{convert::boot_ms(now_us),
                   {at.north_m, at.east_m, convert::in_double(then), at.origin},
                   own_.has_origin()};
}

template <class S>
Report Boat<S>::report(std::int64_t now_us) {
  Report out;
  out.now_us = now_us;
  out.unix_us = host_.unix_us;
  out.conditions = conditions_;
  out.own = own_report(now_us);
  const bool just_armed = core::armed(state()) && armed_us_ == now_us;
  if (out.own && out.own->located && (!home_ || just_armed)) {
    const auto at = convert::global_of(own_.position(), own_now_.motion.moved_n);
    home_ = Home{at.latitude, at.longitude, own_.position().origin.altitude};
  }
  out.home = home_;
  if (seen()) {
    out.formation = FormationReport{convert::in_double(law_output_.error.e),
                                    convert::in_double(law_output_.wanted.nu_star),
                                    convert::in_double(law_output_.allocation.missing)};
  }
  out.own_age_s = age_of(own_, now_us);
  out.leader_age_s = age_of(leader_, now_us);
  const Parameters& p = parameters();
  out.escs = {EscReport{byte_of(p.ESC_PORT), can_.esc_status(byte_of(p.ESC_PORT), now_us)},
              EscReport{byte_of(p.ESC_STBD), can_.esc_status(byte_of(p.ESC_STBD), now_us)}};
  out.overruns = host_.overruns;
  return out;
}

template <class S>
Snapshot Boat<S>::snapshot() const {
  const auto age_s = [&](const VesselTrack<S>& track) {
    return last_tick_us_ ? age_of(track, *last_tick_us_) : std::nullopt;
  };
  const auto& law = law_output_;
  return {state(),
          conditions_,
          age_s(own_),
          age_s(leader_),
          seen(),
          convert::in_double(law.error.e),
          convert::in_double(law.wanted.nu_star),
          convert::in_double(law.tau),
          convert::in_double(thrust_.given),
          {double(thrust_.thrust.port), double(thrust_.thrust.stbd)},
          law.allocation.surge_limited,
          law.allocation.yaw_limited,
          thrust_.slew_limited,
          counters_};
}

template class Boat<float>;
template class Boat<double>;

}  // namespace flotilla::app
