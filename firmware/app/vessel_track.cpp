// SPDX-License-Identifier: MIT
#include "app/vessel_track.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace flotilla::app {
namespace {

/// A heading older than this cannot be carried over to a position.
constexpr std::int64_t kHeadingUsable_us = 300'000;

}  // namespace

template <class S>
bool VesselTrack<S>::mine(link::Sender from) const {
  return from.system == identity_.system && from.component != identity_.ignored_component &&
         from.component != 0;
}

template <class S>
bool VesselTrack<S>::chosen(std::uint8_t component, std::int64_t now_us) {
  const bool silent = now_us - arrived_us_ > kSilent_us;
  if (component_ == 0) component_ = component;
  if (component < component_ || (component != component_ && silent)) {
    forget();
    component_ = component;
  }
  return component == component_;
}

template <class S>
bool VesselTrack<S>::preferred(Source source, std::int64_t now_us) {
  if (source != source_ && (source < source_ || now_us - arrived_us_ > kSilent_us)) {
    stamp_us_.reset();
    clock_.reset();  // the stamps of the two need not count from the same instant
    track_ = {};
    source_ = source;
  }
  return source == source_;
}

template <class S>
void VesselTrack<S>::forget() {
  has_origin_ = false;
  heading_.reset();
  stamp_us_.reset();
  clock_.reset();
  track_ = {};
}

template <class S>
void VesselTrack<S>::take(const link::Received& received, std::int64_t now_us,
                          link::Counters& counters) {
  if (!mine(received.from)) return;
  if (const auto* odometry = std::get_if<link::Odometry>(&received.message)) {
    const convert::Reading reading = convert::sample_of(*odometry);
    if (!reading.sample) {
      const bool bad_frame = reading.refusal == convert::Refusal::kBadFrame;
      ++(bad_frame ? counters.mavlink_bad_frame : counters.mavlink_bad_value);
      frame_complaint_ = frame_complaint_ || bad_frame;
    } else if (chosen(received.from.component, now_us) && preferred(Source::kOdometry, now_us)) {
      accept(*reading.sample, now_us, counters);
    }
  } else if (const auto* attitude = std::get_if<link::Attitude>(&received.message)) {
    const auto heading = convert::heading_of(*attitude);
    if (!heading) {
      ++counters.mavlink_bad_value;
    } else if (chosen(received.from.component, now_us)) {
      heading_ = heading;
    }
  } else if (const auto* local = std::get_if<link::LocalPositionNed>(&received.message)) {
    if (!chosen(received.from.component, now_us) || !heading_ ||
        !preferred(Source::kLocalPosition, now_us)) {
      return;
    }
    const auto sample = convert::sample_of(*local, *heading_);
    if (!sample) {
      ++counters.mavlink_bad_value;
    } else if (std::abs(sample->stamp_us - heading_->stamp_us) <= kHeadingUsable_us) {
      accept(*sample, now_us, counters);
    }
  } else if (const auto* origin = std::get_if<link::GpsGlobalOrigin>(&received.message)) {
    if (!convert::is_valid(*origin)) {
      ++counters.mavlink_bad_value;
    } else {
      position_.origin = *origin;
      has_origin_ = true;
    }
  }
}

template <class S>
void VesselTrack<S>::accept(convert::Sample sample, std::int64_t now_us, link::Counters& counters) {
  if (stamp_us_ && sample.stamp_us <= *stamp_us_) {
    if (now_us - arrived_us_ <= kSilent_us) {
      ++counters.mavlink_old_stamp;
      return;
    }
    // It may have rebooted, and its local frame may have another origin now.
    forget();
  }
  sample = convert::at_reference_point(sample, antenna_.x_m, antenna_.y_m);
  clock_.heard(sample.stamp_us, now_us);
  const S dt = stamp_us_ ? convert::seconds<S>(sample.stamp_us - *stamp_us_) : S(0);
  core::track_update(core::TrackParams<S>{}, track_, S(sample.psi_rad), convert::nu_of<S>(sample),
                     dt);
  position_.north_m = sample.north_m;
  position_.east_m = sample.east_m;
  stamp_us_ = sample.stamp_us;
  arrived_us_ = now_us;
}

template <class S>
void VesselTrack<S>::answered(link::Sender from, std::int64_t sent_us, std::int64_t read_us,
                              std::int64_t now_us) {
  if (mine(from) && from.component == component_) clock_.answered(sent_us, read_us, now_us);
}

template <class S>
std::optional<std::int64_t> VesselTrack<S>::age_us(std::int64_t now_us) const {
  const auto offset = clock_.offset_us();
  if (!stamp_us_ || !offset) return std::nullopt;
  return std::max<std::int64_t>(now_us - (*stamp_us_ + *offset), 0);
}

template <class S>
bool VesselTrack<S>::fresh(std::int64_t now_us, std::int64_t limit_us) const {
  const auto age = age_us(now_us);
  return age && *age < limit_us && now_us - arrived_us_ < limit_us;
}

template <class S>
core::Motion<S> VesselTrack<S>::motion(std::int64_t now_us) const {
  return core::track_forward(track_, convert::seconds<S>(age_us(now_us).value_or(0)));
}

template <class S>
bool VesselTrack<S>::take_frame_complaint() {
  return std::exchange(frame_complaint_, false);
}

template class VesselTrack<float>;
template class VesselTrack<double>;

}  // namespace flotilla::app
