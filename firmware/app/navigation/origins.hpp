// SPDX-License-Identifier: MIT
// Keeps the origin that one vessel's positions are measured from.
#pragma once

#include <cstdint>

#include "app/convert/convert.hpp"

namespace flotilla::app {

/// Local positions count from the origin that their sender reports. Global ones are anchored: they
/// count from that origin if it is near, else from the first of them, and keep it, because
/// followers rely on it.
class Origins {
 public:
  /// The last position, from the origin in use.
  const convert::Position& position() const { return position_; }
  void put(Metres north_m, Metres east_m) {
    position_.north_m = north_m;
    position_.east_m = east_m;
  }

  /// This component has reported the origin of its local positions.
  bool is_told_by(std::uint8_t component) const { return told_by_ == component; }

  /// Positions of this component can be compared with other vessels'.
  bool knows(std::uint8_t component) const { return anchored_ || is_told_by(component); }

  /// The positions in use are local, and their origin would move.
  bool moves_to(const link::GpsGlobalOrigin& origin) const {
    const bool same = origin.latitude == told_.latitude && origin.longitude == told_.longitude;
    return !same && told_by_ != 0 && !anchored_;
  }

  void take(const link::GpsGlobalOrigin& origin, std::uint8_t component) {
    told_ = origin;
    told_by_ = component;
    if (!anchored_) position_.origin = origin;
  }

  /// A global position too far from the anchor to be compared with the last one.
  template <class S>
  bool is_far(const convert::Sample<S>& sample) const {
    return sample.at && anchored_ && !convert::reaches(position_.origin, *sample.at);
  }

  /// Positions of this kind, global or local, are in use.
  template <class S>
  bool is_of_kind(const convert::Sample<S>& sample) const {
    return anchored_ == sample.at.has_value();
  }

  /// The sample as north-east from the origin in use.
  template <class S>
  convert::Sample<S> in_plane(const convert::Sample<S>& sample) const {
    return sample.at && anchored_ ? convert::in_plane(sample, position_.origin) : sample;
  }

  /// Positions count from an origin that suits this sample from now on.
  template <class S>
  void anchor(const convert::Sample<S>& sample, std::uint8_t component) {
    anchored_ = sample.at.has_value();
    const bool told = !anchored_ || (is_told_by(component) && convert::reaches(told_, *sample.at));
    position_.origin =
        told ? told_ : link::GpsGlobalOrigin{sample.at->latitude, sample.at->longitude, 0, 0};
  }

  /// Another component's positions need another anchor.
  void release() { anchored_ = false; }

  /// The vessel rebooted: its local positions have another origin, which nobody knows yet.
  void forget() { told_by_ = 0; }

 private:
  convert::Position position_;
  link::GpsGlobalOrigin told_{};
  std::uint8_t told_by_ = 0;  // component; 0: nobody
  bool anchored_ = false;
};

}  // namespace flotilla::app
