// SPDX-License-Identifier: MIT
#include "policies/monitor.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "policies/rules.hpp"

namespace flotilla::policies {
namespace {

using core::State;

/// Equivalent to calling each rule, without the calls: the rules take most of the monitor's time.
bool all_hold(const Seen& b, const Moment& n) {
  using namespace rules;
#define POLICY(group, name, condition) \
  if (!(condition)) return false;
#include "policies/rules.def"
#undef POLICY
  return true;
}

}  // namespace

std::optional<std::string_view> first_broken(const Seen& before, const Moment& now) {
  if (all_hold(before, now)) return std::nullopt;
  const auto* const found = std::find_if(
      kRules.begin(), kRules.end(), [&](const Rule& rule) { return !rule.holds(before, now); });
  return found->name;
}

template <class S>
Monitor<S>::Monitor(const app::Parameters& p)
    : can_(static_cast<std::uint8_t>(p.CAN_NODE)), mavlink_(p), known_(p) {
  now_.leader = static_cast<std::uint8_t>(p.FORM_LEADER);
}

template <class S>
void Monitor<S>::heard(std::span<const std::uint8_t> bytes) {
  torn_ = !mavlink_.hear(bytes, known_, now_) || torn_;
}

template <class S>
std::optional<Violation> Monitor<S>::ticked(const app::Boat<S>& boat,
                                            const typename app::Boat<S>::Output& out,
                                            std::int64_t now_us) {
  if (broken_) return std::nullopt;
  look_inside(boat);
  note_damage(boat.counters());
  note_times();
  can_.read(out.can, known_, now_);
  for (std::size_t link = 0; link < out.links->count(); ++link) {
    mavlink_.read(out.links->bytes(link), link, now_);
  }
  mavlink_.note_times(out.links->count(), now_);
  note_deeds();
  if (const auto name = first_broken(before_, now_)) broken_ = Violation{*name, now_us};
  before_ = now_;
  now_.heard = {};
  now_.bus = {};
  now_.links = {};
  return broken_;
}

template <class S>
void Monitor<S>::look_inside(const app::Boat<S>& boat) {
  now_.now_us = boat.now_us();
  now_.dt_us = now_.now_us - before_.now_us;
  now_.before_ms = before_.now_ms;
  now_.now_ms = static_cast<std::uint32_t>(now_.now_us / 1000);
  now_.state = boat.state();
  now_.met = boat.conditions();
  const auto& thrust = boat.thrust();
  now_.thrust_N = {static_cast<float>(app::convert::number(thrust.port)),
                   static_cast<float>(app::convert::number(thrust.stbd))};
  now_.own_age_s = boat.guidance().own_age_s(now_.now_us);
  now_.leader_age_s = boat.guidance().leader_age_s(now_.now_us);
  const std::uint8_t leader = boat.guidance().leader();
  if (std::exchange(now_.leader, leader) != leader) now_.leader_true_us = kNever_us;
  now_.p = &boat.parameters();
  now_.in_range = true;
  now_.locked_change = false;
  if (std::memcmp(&known_, now_.p, sizeof known_) != 0) note_change(*now_.p);
}

template <class S>
void Monitor<S>::note_change(const app::Parameters& now) {
  using app::ParameterChange;
  for (const app::ParameterInfo& info : app::kParameterList) {
    const float value = now.*info.member;
    const bool locked =
        info.change == ParameterChange::kDisarmed || info.change == ParameterChange::kRestart;
    now_.in_range = now_.in_range && app::is_valid(info, value);
    now_.locked_change = now_.locked_change || (locked && value != known_.*info.member);
  }
  // A sender not allowed to command at reception may have been allowed at the answer.
  if (now.MAV_GCS_SYSID != known_.MAV_GCS_SYSID) {
    now_.asked[Ask::kArmAllowed] = now_.asked[Ask::kArm];
  }
  known_ = now;
}

/// In damaged bytes the decoder may find a different message, and later messages may be delayed by
/// 0.3 s; wrongly signed messages do not count at all.
template <class S>
void Monitor<S>::note_damage(const link::Counters& c) {
  const std::uint32_t damage = c.mavlink_skipped_bytes + c.mavlink_unknown + c.mavlink_forged +
                               c.mavlink_replayed + c.mavlink_future_stamp +
                               c.mavlink_streams_full + c.mavlink_unsigned_refused;
  if (std::exchange(torn_, false) || std::exchange(damage_, damage) != damage) {
    torn_until_us_ = now_.now_us + 500'000;
  }
  now_.torn = now_.now_us < torn_until_us_;
}

template <class S>
void Monitor<S>::note_times() {
  const Heard& heard = now_.heard;
  // The boat gets the benefit of the doubt: input that keeps something fresh counts as received
  // now, input that forbids something as received at the previous tick.
  if (heard.own) now_.own_us = now_.now_us;
  if (heard.leader) now_.leader_us = now_.now_us;
  if (heard.sticks) now_.sticks_us = now_.now_us;
  if (heard.neutral || now_.torn) now_.neutral_us = now_.now_us;
  for (std::size_t esc = 0; esc < heard.escs.size(); ++esc) {
    if (heard.escs[esc]) now_.esc_us[esc] = now_.now_us;
  }
  now_.has_stop_switch |= heard.stop_switch;
  if (heard.controller) now_.controller_us = before_.now_us;
  if (heard.rebooted) now_.reboot_us = before_.now_us;
  if (now_.state == before_.state) return;
  now_.state_us = now_.now_us;
  if (now_.armed() && !before_.armed()) now_.armed_us = now_.now_us;
}

/// Counts the boat's actions that need a request.
template <class S>
void Monitor<S>::note_deeds() {
  const State was = before_.state;
  Asked& done = now_.done;
  if (now_.armed() && !before_.armed()) ++done[Ask::kArm], ++done[Ask::kArmAllowed];
  if (now_.state != was) {
    const bool lost = core::follows(was) && !now_.has(core::kFollows | core::kGcsHeard);
    if (now_.in(State::kManual) && !lost) ++done[Ask::kManual];
    // A loss may lead to these, by the operator's choice; so may the end of COAST.
    const bool failed = core::law_drives(was) && (was == State::kCoast || !now_.has(core::kLosses));
    // By the rule of a fleet's table a follower may begin to lead, and a leader to follow.
    const bool leads = now_.in_fleet && core::follows(was);
    const bool yields = now_.in_fleet && core::sails_alone(was);
    if (now_.in(State::kLoiter) && !failed && !leads) ++done[Ask::kLoiter];
    if (now_.in(State::kReturn) && !failed) ++done[Ask::kReturn];
    if (now_.in(State::kGuided)) ++done[Ask::kGuided];
    // If the leader is lost in the tick of the request, the state may be COAST already.
    if (now_.follows() && !core::follows(was) && !yields) ++done[Ask::kFormation];
    if (now_.in(State::kAuto) && !leads) ++done[Ask::kAuto];
    if (now_.in(State::kTest)) ++done[Ask::kTest];
    if (now_.in(State::kFault) && was == State::kDisarmed) ++done[Ask::kTerminate];
  }
  if (!now_.torn) return;
  for (std::size_t i = 0; i < kAsks; ++i) {
    const auto what = static_cast<Ask>(i);
    now_.asked[what] = std::max(now_.asked[what], done[what]);
  }
}

template class Monitor<float>;
template class Monitor<double>;
template class Monitor<core::Q16>;

}  // namespace flotilla::policies
