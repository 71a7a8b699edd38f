// SPDX-License-Identifier: MIT
#include "app/estimation/own_motion.hpp"

#include <utility>
#include <variant>

namespace flotilla::app {
namespace {

// Another own source must take over before FS_NAV_S stops the boat.
constexpr std::int64_t kOwnPatience_us = 300'000;
// A repeated state must count as frozen before then, too.
constexpr std::int64_t kOwnFrozen_us = 300'000;

bool tells_place(const link::Message& message) {
  return std::holds_alternative<link::Odometry>(message) ||
         std::holds_alternative<link::LocalPositionNed>(message) ||
         std::holds_alternative<link::GlobalPositionInt>(message);
}

}  // namespace

template <class S>
OwnMotion<S>::OwnMotion(std::uint8_t system, std::uint8_t component, std::uint8_t unit)
    : track_({system, component, kOwnPatience_us, kOwnFrozen_us, true, unit}) {}

template <class S>
void OwnMotion<S>::configure(const convert::Law<S>& law,
                             const Configuration::Navigation& navigation, std::uint8_t own_system) {
  set_limits(law);
  latency_.configure(law.latency, law.yaw_inertia_kgm2, navigation.lag_s);
  track_.set_lag(latency_.lag_us());
  track_.set_antenna({law.antenna.x, law.antenna.y});
  named_link_ = navigation.link;
  if (std::exchange(limits_, navigation.quality) != limits_) quality_ = {};
  if (track_.follow(own_system, navigation.component)) link_.reset();
}

template <class S>
void OwnMotion<S>::take(const link::Received& received, std::size_t link, std::int64_t now_us,
                        link::Counters& counters) {
  if (received.from.system != track_.system()) return;
  if (!may_be_own(link, now_us)) {
    stranger_ = stranger_ || (!named_link_ && tells_place(received.message));
    return;
  }
  const std::uint8_t resets = track_.clock_resets();
  track_.take(received, now_us, counters);
  if (track_.clock_resets() != resets) latency_.forget();
  if (track_.accepted(now_us)) link_ = static_cast<std::uint8_t>(link);
  if (!track_.is_from_unit(received.from)) return;
  quality_.take(received, limits_, now_us);
  if (const auto* gps = std::get_if<link::GpsRawInt>(&received.message)) {
    gps_ = *gps;
    gps_us_ = now_us;
  }
}

template <class S>
std::optional<link::GpsRawInt> OwnMotion<S>::gps(std::int64_t now_us) const {
  constexpr std::int64_t kOld_us = 2'000'000;
  return gps_us_ && now_us - *gps_us_ < kOld_us ? std::optional(gps_) : std::nullopt;
}

template <class S>
bool OwnMotion<S>::may_be_own(std::size_t link, std::int64_t now_us) const {
  if (!named_link_ && !armed_ && (!link_ || track_.gone(now_us))) return true;
  return (named_link_ || link_) && !is_elsewhere(link);
}

template <class S>
bool OwnMotion<S>::is_elsewhere(std::size_t link) const {
  const auto& pinned = named_link_ ? named_link_ : link_;
  return pinned && *pinned != link;
}

template <class S>
void OwnMotion<S>::observe(const convert::Law<S>& law, const core::Tau<S>& given, S since,
                           bool armed, std::int64_t now_us) {
  const bool waits = !track_.bounded() && track_.age_us(now_us);
  latency_.look_at_clock(waits, S(0) < law.observer.omega, now_us);
  track_.set_lag(latency_.lag_us());
  if (std::exchange(armed_, armed) != armed) {
    set_limits(law);
    track_.hold(armed);
    track_.set_smoothing(!armed);  // the observer extrapolates from each message
  }
  if (!armed) {
    carry(now_us);
    return;
  }
  if (latency_.estimates()) {
    core::impulse_forward(moment_, given, since);
    if (!(moment_.time < S(0.025))) push_moment();  // a yaw rate resolves no shorter times
  }
  response_.push(law.controller, given, since, !track_.has_moved());
  const core::Vessel<S>& vessel = law.controller.vessel;
  track_.push(since * core::max(core::abs(given.X) / vessel.m11, core::abs(given.N) / vessel.m33));
  core::observer_forward(vessel, observer_, given, since);
  const convert::Position before = std::exchange(anchor_, track_.position());
  const auto fix = track_.take_fix();
  if (!fix) return;
  response_.take_fix(fix->nu);
  std::int64_t age_us = track_.age_us(now_us).value_or(0);
  if (latency_.estimates() && update_latency(*fix, age_us)) {
    track_.set_lag(latency_.lag_us());
    age_us = track_.age_us(now_us).value_or(0);
  }
  const auto [way, near] = convert::separation<S>(before, anchor_);
  const core::Vec2<S>& moved = motion().moved_n;
  core::observer_correct(adjusted_for_latency(law.observer), vessel, observer_,
                         {{way.x + moved.x, way.y + moved.y},
                          fix->psi,
                          fix->nu,
                          convert::seconds<S>(age_us),
                          near ? fix->dt : S(0)});
}

template <class S>
void OwnMotion<S>::push_moment() {
  const auto [sum, time] = std::exchange(moment_, {});
  if (S(0) < time) latency_.push(convert::in_float(sum.N), convert::in_float(time));
}

/// True if the compensated latency has changed. Skips fixes less than a tenth of a second after the
/// last one used, which add little information.
template <class S>
bool OwnMotion<S>::update_latency(const core::TrackMessage<S>& fix, std::int64_t age_us) {
  const bool goes_on = S(0) < fix.dt && fix.dt < S(0.5);
  since_fix_ = goes_on ? since_fix_ + fix.dt : S(0);
  if (goes_on && since_fix_ < S(0.095)) return false;
  push_moment();
  return latency_.correct(convert::in_float(fix.nu.r),
                          convert::in_float(std::exchange(since_fix_, S(0))), age_us);
}

template <class S>
void OwnMotion<S>::carry(std::int64_t now_us) {
  observer_ = {};
  observer_.motion = track_.motion(now_us);
  anchor_ = track_.position();
  response_.reset();
  latency_.restart();
  moment_ = {};
  since_fix_ = S(0);
  if (const auto fix = track_.take_fix()) response_.take_fix(fix->nu);
}

/// Averages fixes with uncompensated latency over a longer time: a boat that follows each fix at
/// once would keep correcting its own past turn.
template <class S>
core::ObserverParams<S> OwnMotion<S>::adjusted_for_latency(
    const core::ObserverParams<S>& params) const {
  core::ObserverParams<S> out = params;
  if (!latency_.estimates()) return out;
  out.T = out.T + convert::scalar<S>(1.5F * latency_.uncompensated_s());
  out.omega = core::min(out.omega, S(1) / out.T);
  return out;
}

template <class S>
convert::Position OwnMotion<S>::place() const {
  const core::Vec2<S>& moved = motion().moved_n;
  return {anchor_.north_m + moved.x, anchor_.east_m + moved.y, anchor_.origin};
}

template <class S>
core::Conditions OwnMotion<S>::conditions(std::int64_t limit_us, std::int64_t now_us) const {
  core::Conditions met = 0;
  if (track_.fresh(now_us, limit_us)) met |= core::kOwnFresh;
  if (track_.live()) met |= core::kOwnLive;
  if (track_.steady(now_us)) met |= core::kOwnSteady;
  if (!track_.doubled(now_us)) met |= core::kSoleVessel;
  if (track_.timed()) met |= core::kOwnTimed;
  if (quality_.good(now_us)) met |= core::kOwnGood;
  if (latency_.is_bearable() || track_.bounded()) met |= core::kOwnPrompt;
  if (response_.answers()) met |= core::kBoatAnswers;
  return met;
}

template class OwnMotion<float>;
template class OwnMotion<double>;
template class OwnMotion<core::Q16>;

}  // namespace flotilla::app
