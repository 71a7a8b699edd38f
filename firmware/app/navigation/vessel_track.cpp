// SPDX-License-Identifier: MIT
#include "app/navigation/vessel_track.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace flotilla::app {
namespace {

/// An older heading cannot be extrapolated to a position.
constexpr std::int64_t kHeadingUsable_us = 300'000;

/// Time to extrapolate a track over, s; nobody uses a track after ten.
template <class S>
S carried(std::int64_t us) {
  return convert::seconds<S>(std::min<std::int64_t>(us, 10'000'000));
}

}  // namespace

template <class S>
void VesselTrack<S>::follow(std::uint8_t system) {
  if (system == identity_.system) return;
  Identity identity = identity_;
  identity.system = system;
  const core::PlausibilityLimits<S> limits = guard_.limits();
  const bool smooths = smooths_;
  const std::int64_t lag_us = lag_us_;
  *this = VesselTrack(identity, antenna_);
  set_limits(limits);
  set_smoothing(smooths);
  set_lag(lag_us);
}

template <class S>
void VesselTrack<S>::set_smoothing(bool smooths) {
  smooths_ = smooths;
  track_.nu_dot = track_.nu_ddot = {};
}

template <class S>
bool VesselTrack<S>::chosen(std::uint8_t component, std::int64_t now_us) {
  if (component_ == 0) component_ = component;
  if (component < component_ || (component != component_ && silent(now_us))) {
    component_ = component;
    sources_.forget();
    odometry_resets_.reset();
    anchored_ = false;
    restart();
  }
  return component == component_;
}

/// Registers a message of that source; returns whether to use it.
template <class S>
bool VesselTrack<S>::preferred(Source source, std::int64_t stamp_us, std::int64_t now_us) {
  sources_.hear(source, stamp_us, now_us, stamp_us_.has_value());
  if (source == sources_.in_use()) return true;
  if (!sources_.better(source, now_us, origin_known())) return false;
  change_to(source, now_us);
  return true;
}

/// The track continues the old source's motion with the new source's stamps and clock, which need
/// not count from the same instant.
template <class S>
void VesselTrack<S>::change_to(Source source, std::int64_t now_us) {
  const auto age = age_us(now_us);
  other_source_us_ = age ? std::optional(now_us - *age) : std::nullopt;
  stamp_us_.reset();
  refused_stamp_us_.reset();
  refused_in_a_row_ = 0;
  guard_.forget();
  if (sources_.change_to(source)) origin_component_ = 0;
}

/// The vessel rebooted: its clock and its frame have changed.
template <class S>
void VesselTrack<S>::rebooted(std::int64_t stamp_us) {
  restart();
  origin_component_ = 0;
  sources_.rebooted(stamp_us);
}

/// A jump: no motion leads from the last state to the next one.
template <class S>
void VesselTrack<S>::jumped() {
  guard_.forget();
  stamp_us_.reset();
  refused_stamp_us_.reset();
  refused_in_a_row_ = 0;
  track_ = {};
}

template <class S>
void VesselTrack<S>::restart() {
  guard_.forget();
  stamp_us_.reset();
  refused_stamp_us_.reset();
  other_source_us_.reset();
  refused_in_a_row_ = 0;
  sources_.restart();
  track_ = {};
}

template <class S>
void VesselTrack<S>::take_mine(const link::Received& received, std::int64_t now_us,
                               link::Counters& counters) {
  const std::uint8_t component = received.from.component;
  if (const auto* odometry = std::get_if<link::Odometry>(&received.message)) {
    take(*odometry, component, now_us, counters);
  } else if (const auto* attitude = std::get_if<link::Attitude>(&received.message)) {
    take(*attitude, component, now_us, counters);
  } else if (const auto* position = std::get_if<link::LocalPositionNed>(&received.message)) {
    take_joined(Source::kLocalPosition, *position, component, now_us, counters);
  } else if (const auto* global = std::get_if<link::GlobalPositionInt>(&received.message)) {
    take_joined(Source::kGlobalPosition, *global, component, now_us, counters);
  } else if (const auto* target = std::get_if<link::FollowTarget>(&received.message)) {
    take(*target, component, now_us, counters);
  } else if (const auto* origin = std::get_if<link::GpsGlobalOrigin>(&received.message)) {
    take(*origin, component, counters);
  }
}

template <class S>
void VesselTrack<S>::take(const link::Odometry& message, std::uint8_t component,
                          std::int64_t now_us, link::Counters& counters) {
  const convert::Reading<S> reading = convert::sample_of<S>(message);
  if (!reading.sample) {
    const bool bad_frame = reading.refusal == convert::Refusal::kBadFrame;
    ++(bad_frame ? counters.mavlink_bad_frame : counters.mavlink_bad_value);
    frame_complaint_ = frame_complaint_ || bad_frame;
  } else if (chosen(component, now_us)) {
    if (sources_.is_news(Source::kOdometry, reading.sample->stamp_us)) {
      // Only an increment by one is a reset; another number may be another vessel's.
      const std::uint8_t resets = odometry_resets_.value_or(message.reset_counter);
      const bool next = message.reset_counter == static_cast<std::uint8_t>(resets + 1);
      if (next && sources_.in_use() == Source::kOdometry) jumped();
    }
    if (preferred(Source::kOdometry, reading.sample->stamp_us, now_us) &&
        accept(*reading.sample, now_us, counters)) {
      odometry_resets_ = message.reset_counter;
      heading_older_us_ = 0;
    }
  }
}

template <class S>
void VesselTrack<S>::take(const link::Attitude& message, std::uint8_t component,
                          std::int64_t now_us, link::Counters& counters) {
  auto sample = convert::heading_of<S>(message);
  if (!sample) {
    ++counters.mavlink_bad_value;
    return;
  }
  Heading& heading = component == component_ ? heading_ : other_heading_;
  if (heading.component == component) {
    sample->stamp_us = convert::unwrapped_us(sample->stamp_us, heading.sample.stamp_us);
  }
  if (heading.component == component && sample->stamp_us <= heading.sample.stamp_us &&
      !silent(now_us)) {
    ++counters.mavlink_old_stamp;
    return;
  }
  // Perhaps of another vessel with another clock: it would block this one's.
  if (heading.component == component && now_us - heading.arrived_us < kHeadingUsable_us &&
      sample->stamp_us - heading.sample.stamp_us > now_us - heading.arrived_us + kSilent_us) {
    guard_.note_jump(now_us);
    ++counters.mavlink_jump;
    return;
  }
  heading = {component, *sample, now_us};
}

template <class S>
void VesselTrack<S>::take(const link::FollowTarget& message, std::uint8_t component,
                          std::int64_t now_us, link::Counters& counters) {
  if (!convert::is_usable(message)) {
    ++counters.mavlink_bad_value;
    return;
  }
  const auto heading = convert::own_heading_of<S>(message);
  if (!heading) {
    take_joined(Source::kFollowTarget, message, component, now_us, counters);
    return;
  }
  if (!chosen(component, now_us)) return;
  const auto sample = convert::sample_of(message, *heading);
  if (preferred(Source::kFollowTarget, sample->stamp_us, now_us) &&
      accept(*sample, now_us, counters)) {
    heading_older_us_ = 0;
  }
}

/// A position joined with ATTITUDE's heading.
template <class S>
template <class Message>
void VesselTrack<S>::take_joined(Source source, const Message& message, std::uint8_t component,
                                 std::int64_t now_us, link::Counters& counters) {
  const Heading heading = component == component_ ? heading_ : other_heading_;
  if (heading.component != component) {
    ++counters.mavlink_no_heading;
    return;
  }
  const auto sample = convert::sample_of(message, heading.sample);  // its stamp near the heading's
  if (!sample) {
    ++counters.mavlink_bad_value;
    return;
  }
  const std::int64_t older_us = sample->stamp_us - heading.sample.stamp_us;
  if (std::abs(older_us) > kHeadingUsable_us) {
    ++counters.mavlink_no_heading;
    if (component == component_ && source == sources_.in_use()) {
      guard_.look_at(guard_.seen(here(*sample), now_us), false);
    }
    return;
  }
  if (!chosen(component, now_us)) return;
  heading_ = heading;
  if (preferred(source, sample->stamp_us, now_us) && accept(*sample, now_us, counters)) {
    heading_older_us_ = std::max<std::int64_t>(older_us, 0);
  }
}

template <class S>
void VesselTrack<S>::take(const link::GpsGlobalOrigin& message, std::uint8_t component,
                          link::Counters& counters) {
  if (!convert::is_valid(message)) {
    ++counters.mavlink_bad_value;
  } else if (component_ == 0 || component == component_) {
    const bool moved =
        message.latitude != origin_.latitude || message.longitude != origin_.longitude;
    // A local position is valid only with the origin that it was measured from.
    if (moved && origin_component_ != 0 && !anchored_) restart();
    origin_ = message;
    origin_component_ = component;
    if (!anchored_) position_.origin = message;
  }
}

/// A global sample in the plane of the last position.
template <class S>
convert::Sample<S> VesselTrack<S>::here(const convert::Sample<S>& sample) const {
  return sample.at && anchored_ ? convert::in_plane(sample, position_.origin) : sample;
}

/// Sets the origin of the positions believed from now on. For global positions it stays fixed:
/// followers of this vessel rely on it.
template <class S>
void VesselTrack<S>::anchor(const convert::Sample<S>& sample) {
  if (!sample.at) {
    if (anchored_) position_.origin = origin_;
    anchored_ = false;
    return;
  }
  const auto& at = *sample.at;
  const bool near = origin_known() && convert::reaches(origin_, at);
  position_.origin = near ? origin_ : link::GpsGlobalOrigin{at.latitude, at.longitude, 0, 0};
  anchored_ = true;
}

/// The stamp is not newer than the last one, and the vessel has not rebooted.
template <class S>
bool VesselTrack<S>::is_late(const convert::Sample<S>& sample, std::int64_t now_us) {
  if (!stamp_us_ || sample.stamp_us > *stamp_us_) return false;
  const bool advances = refused_stamp_us_ && sample.stamp_us > *refused_stamp_us_;
  refused_stamp_us_ = sample.stamp_us;
  refused_in_a_row_ = advances ? refused_in_a_row_ + 1 : 1;
  if (!silent(now_us) || !advances || sample.stamp_us == *stamp_us_) {
    guard_.look_at(guard_.seen(here(sample), now_us), true);
    return true;
  }
  rebooted(sample.stamp_us);
  return false;
}

/// A jump was believed: drops the motion, and the clock too if the stamps jumped.
template <class S>
void VesselTrack<S>::moved(std::int64_t stamp_us, std::int64_t now_us) {
  if (std::abs(stamp_us - *stamp_us_ - (now_us - arrived_us_)) > kSilent_us) {
    restart();
  } else {
    jumped();
  }
}

template <class S>
bool VesselTrack<S>::accept(const convert::Sample<S>& sample, std::int64_t now_us,
                            link::Counters& counters) {
  if (is_late(sample, now_us)) {
    ++counters.mavlink_old_stamp;
    return false;
  }
  const bool far = sample.at && anchored_ && !convert::reaches(position_.origin, *sample.at);
  convert::Sample<S> placed = here(sample);
  auto seen = guard_.seen(placed, now_us);
  const auto verdict = guard_.judge(seen, far);
  if (verdict == JumpGuard<S>::Verdict::kRefused) {
    ++counters.mavlink_jump;
    return false;
  }
  if (verdict == JumpGuard<S>::Verdict::kMoved) moved(sample.stamp_us, now_us);
  // A 32-bit clock that restarts after 25 days of uptime appears to leap ahead.
  if (stamp_us_ && sample.stamp_us - *stamp_us_ > now_us - arrived_us_ + kLeap_us) {
    rebooted(sample.stamp_us);
  }
  // Stamps advanced regularly but late: the clock was set back, or once ran ahead. If TIMESYNC
  // confirms the clock, the messages were merely overtaken.
  if (refused_in_a_row_ >= 3 && !clock().was_answered()) sources_.restart();
  refused_in_a_row_ = 0;
  if (far || anchored_ != sample.at.has_value()) {
    anchor(sample);
    placed = here(sample);
    seen = guard_.seen(placed, now_us);
  }
  guard_.believe(seen);
  const std::int64_t since_us = stamp_us_ ? placed.stamp_us - *stamp_us_ : 0;
  liveness_.take(placed, convert::seconds<S>(std::min(since_us, kSilent_us)));
  update(convert::at_reference_point(placed, antenna_.x_m, antenna_.y_m), now_us);
  return true;
}

template <class S>
void VesselTrack<S>::update(const convert::Sample<S>& sample, std::int64_t now_us) {
  clock().heard(sample.stamp_us, now_us);
  const std::int64_t true_us = sample.stamp_us + clock().offset_us().value_or(0);
  const core::TrackParams<S> params{};
  const bool resumed = other_source_us_.has_value();
  const S dt = resumed
                   ? convert::seconds<S>(std::max<std::int64_t>(true_us - *other_source_us_, 1000))
               : stamp_us_ ? convert::seconds<S>(sample.stamp_us - *stamp_us_)
                           : S(0);
  const core::TrackMessage<S> message{sample.psi_rad, convert::nu_of(sample), dt};
  if (resumed || !smooths_) {
    core::track_resume(params, track_, message);
  } else {
    core::track_update(params, track_, message);
  }
  other_source_us_.reset();
  // Of several messages between two ticks the last one counts, with dt over all of them.
  const bool led = track_.dt > S(0) && (!fix_ || fix_->dt > S(0));
  const S since = led ? track_.dt + (fix_ ? fix_->dt : S(0)) : S(0);
  fix_ = core::TrackMessage<S>{message.psi, message.nu, since};
  ++messages_;
  position_.north_m = sample.north_m;
  position_.east_m = sample.east_m;
  stamp_us_ = sample.stamp_us;
  refused_stamp_us_.reset();
  arrived_us_ = now_us;
}

template <class S>
void VesselTrack<S>::answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                              std::int64_t now_us) {
  if (!mine(from) || from.component != component_) return;
  sources_.answered(sent_us, read_us, now_us);
}

template <class S>
std::optional<std::int64_t> VesselTrack<S>::age_us(std::int64_t now_us) const {
  const auto offset = clock().offset_us();
  if (!stamp_us_ || !offset) return std::nullopt;
  // A state is at least as old as its arrival, whatever TIMESYNC has since made of its stamp.
  return std::max<std::int64_t>(now_us - std::min(*stamp_us_ + *offset, arrived_us_), 0) + lag_us();
}

template <class S>
bool VesselTrack<S>::fresh(std::int64_t now_us, std::int64_t limit_us) const {
  const auto least = clock().least_us();
  if (!stamp_us_ || !least) return false;
  const std::int64_t worst_age_us = now_us - (*stamp_us_ + *least) + lag_us();
  return worst_age_us + heading_older_us_ < limit_us && now_us - arrived_us_ < limit_us;
}

template <class S>
core::Motion<S> VesselTrack<S>::motion(std::int64_t now_us) const {
  return core::track_forward(track_, carried<S>(age_us(now_us).value_or(0)));
}

template <class S>
std::optional<double> VesselTrack<S>::uncertainty_m(std::int64_t now_us) const {
  const auto age = age_us(now_us);
  const auto least = clock().least_us(), offset = clock().offset_us();
  if (!age || !least || !offset) return std::nullopt;
  const S off = carried<S>(std::abs(*offset - *least));
  return convert::number(core::track_uncertainty(track_, carried<S>(*age), off));
}

template <class S>
bool VesselTrack<S>::take_frame_complaint() {
  return std::exchange(frame_complaint_, false);
}

template class VesselTrack<float>;
template class VesselTrack<double>;
template class VesselTrack<core::Q16>;

}  // namespace flotilla::app
