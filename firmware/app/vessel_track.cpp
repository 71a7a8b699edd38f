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
bool VesselTrack<S>::mine(link::Address from) const {
  return from.system == identity_.system && from.component != identity_.ignored_component &&
         from.component != 0;
}

template <class S>
bool VesselTrack<S>::chosen(std::uint8_t component, std::int64_t now_us) {
  if (component_ == 0) component_ = component;
  if (component < component_ || (component != component_ && silent(now_us))) {
    component_ = component;
    restart();
  }
  return component == component_;
}

template <class S>
bool VesselTrack<S>::preferred(Source source, std::int64_t now_us) {
  if (source != source_ && (source < source_ || now_us - arrived_us_ > kSourceSilent_us)) {
    restart();  // the stamps of the two need not count from the same instant
    source_ = source;
  }
  return source == source_;
}

template <class S>
void VesselTrack<S>::restart() {
  stamp_us_.reset();
  refused_stamp_us_.reset();
  refused_in_a_row_ = 0;
  clock_.reset();
  track_ = {};
}

template <class S>
void VesselTrack<S>::take(const link::Received& received, std::int64_t now_us,
                          link::Counters& counters) {
  if (!mine(received.from)) return;
  const std::uint8_t component = received.from.component;
  if (const auto* odometry = std::get_if<link::Odometry>(&received.message)) {
    take(*odometry, component, now_us, counters);
  } else if (const auto* attitude = std::get_if<link::Attitude>(&received.message)) {
    take(*attitude, component, now_us, counters);
  } else if (const auto* position = std::get_if<link::LocalPositionNed>(&received.message)) {
    take(*position, component, now_us, counters);
  } else if (const auto* origin = std::get_if<link::GpsGlobalOrigin>(&received.message)) {
    take(*origin, component, counters);
  }
}

template <class S>
void VesselTrack<S>::take(const link::Odometry& message, std::uint8_t component,
                          std::int64_t now_us, link::Counters& counters) {
  const convert::Reading reading = convert::sample_of(message);
  if (!reading.sample) {
    const bool bad_frame = reading.refusal == convert::Refusal::kBadFrame;
    ++(bad_frame ? counters.mavlink_bad_frame : counters.mavlink_bad_value);
    frame_complaint_ = frame_complaint_ || bad_frame;
  } else if (chosen(component, now_us) && preferred(Source::kOdometry, now_us) &&
             accept(*reading.sample, now_us, counters)) {
    heading_older_us_ = 0;
  }
}

template <class S>
void VesselTrack<S>::take(const link::Attitude& message, std::uint8_t component,
                          std::int64_t now_us, link::Counters& counters) {
  auto sample = convert::heading_of(message);
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
  heading = {component, *sample};
}

template <class S>
void VesselTrack<S>::take(const link::LocalPositionNed& message, std::uint8_t component,
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
    return;
  }
  if (!chosen(component, now_us) || !preferred(Source::kLocalPosition, now_us)) return;
  heading_ = heading;
  if (accept(*sample, now_us, counters)) {
    heading_older_us_ = std::max<std::int64_t>(older_us, 0);
  }
}

template <class S>
void VesselTrack<S>::take(const link::GpsGlobalOrigin& message, std::uint8_t component,
                          link::Counters& counters) {
  if (!convert::is_valid(message)) {
    ++counters.mavlink_bad_value;
  } else if (component_ == 0 || component == component_) {
    const auto& old = position_.origin;
    const bool moved = message.latitude != old.latitude || message.longitude != old.longitude;
    // A position belongs to the origin that it was measured from.
    if (moved && origin_component_ != 0) restart();
    position_.origin = message;
    origin_component_ = component;
  }
}

template <class S>
bool VesselTrack<S>::accept(convert::Sample sample, std::int64_t now_us, link::Counters& counters) {
  if (stamp_us_ && sample.stamp_us <= *stamp_us_) {
    const bool advances = refused_stamp_us_ && sample.stamp_us > *refused_stamp_us_;
    refused_stamp_us_ = sample.stamp_us;
    refused_in_a_row_ = advances ? refused_in_a_row_ + 1 : 1;
    if (!silent(now_us) || !advances || sample.stamp_us == *stamp_us_) {
      ++counters.mavlink_old_stamp;
      return false;
    }
    restart();
    origin_component_ = 0;  // after a reboot its local frame may have another origin
  }
  // Stamps that went on regularly, but behind: their clock was set back, or once ran ahead.
  if (refused_in_a_row_ >= 3) clock_.reset();
  refused_in_a_row_ = 0;
  sample = convert::at_reference_point(sample, antenna_.x_m, antenna_.y_m);
  clock_.heard(sample.stamp_us, now_us);
  const S dt = stamp_us_ ? convert::seconds<S>(sample.stamp_us - *stamp_us_) : S(0);
  const std::int64_t age_us = now_us - (sample.stamp_us + clock_.offset_us().value_or(0));
  core::track_update(core::TrackParams<S>{}, track_,
                     {S(sample.psi_rad), convert::nu_of<S>(sample), dt,
                      convert::seconds<S>(std::max<std::int64_t>(age_us, 0))});
  ++messages_;
  position_.north_m = sample.north_m;
  position_.east_m = sample.east_m;
  stamp_us_ = sample.stamp_us;
  refused_stamp_us_.reset();
  arrived_us_ = now_us;
  return true;
}

template <class S>
void VesselTrack<S>::answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                              std::int64_t now_us) {
  if (!mine(from) || from.component != component_ || !stamp_us_) return;
  const bool wraps = source_ == Source::kLocalPosition;
  clock_.answered(sent_us, wraps ? convert::unwrapped_us(read_us, *stamp_us_) : read_us, now_us);
}

template <class S>
std::optional<std::int64_t> VesselTrack<S>::age_us(std::int64_t now_us) const {
  const auto offset = clock_.offset_us();
  if (!stamp_us_ || !offset) return std::nullopt;
  return std::max<std::int64_t>(now_us - (*stamp_us_ + *offset), 0);
}

template <class S>
bool VesselTrack<S>::fresh(std::int64_t now_us, std::int64_t limit_us) const {
  const auto least = clock_.least_us();
  if (!stamp_us_ || !least) return false;
  const std::int64_t worst_age_us = now_us - (*stamp_us_ + *least);
  return worst_age_us + heading_older_us_ < limit_us && now_us - arrived_us_ < limit_us;
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
