// SPDX-License-Identifier: MIT
// Keeps the origin that one vessel's positions are measured from.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "app/convert/convert.hpp"

namespace flotilla::app {

/// Local positions count from the origin that their sender reports. Global ones are anchored: they
/// count from that origin if it is near, else from the first global position; the anchor does not
/// change, because followers rely on it.
class Origins {
 public:
  /// The last position, from the origin in use.
  const convert::Position& position() const { return position_; }
  void put(Metres north_m, Metres east_m) {
    position_.north_m = north_m;
    position_.east_m = east_m;
  }

  /// This component has reported the origin of its local positions.
  bool is_told_by(std::uint8_t component) const { return told_.by == component; }

  /// The last position can be compared with other vessels'.
  bool located() const { return located_; }

  /// Whether the positions in use are local, and this origin would move them.
  bool moves_to(const link::GpsGlobalOrigin& origin) const {
    const link::GpsGlobalOrigin& old = told_.origin;
    const bool same = origin.latitude == old.latitude && origin.longitude == old.longitude;
    return !same && told_.by != 0 && !anchored_;
  }

  /// Stores an origin, reported by the component in use or by another; anchor() puts it to use.
  void take(const link::GpsGlobalOrigin& origin, std::uint8_t component, bool in_use,
            std::int64_t now_us) {
    (in_use ? told_ : others_) = {origin, component, now_us};
  }

  /// Gives the reported origin to positions whose origin was unknown.
  void locate() {
    if (located_ || anchored_) return;
    position_.origin = told_.origin;
    located_ = true;
  }

  /// The sample's position with its origin; nothing if the origin is unknown.
  template <class S>
  std::optional<convert::Position> place_of(const convert::Sample<S>& sample,
                                            std::uint8_t component) const {
    if (sample.at)
      return convert::Position{0, 0, {sample.at->latitude, sample.at->longitude, 0, 0}};
    const Told& told = is_told_by(component) ? told_ : others_;
    if (told.by != component) return std::nullopt;
    return convert::Position{sample.north_m, sample.east_m, told.origin};
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

  /// From now on positions count from an origin that suits this sample.
  template <class S>
  void anchor(const convert::Sample<S>& sample, std::uint8_t component) {
    anchored_ = sample.at.has_value();
    const bool told =
        !anchored_ || (is_told_by(component) && convert::reaches(told_.origin, *sample.at));
    position_.origin = told
                           ? told_.origin
                           : link::GpsGlobalOrigin{sample.at->latitude, sample.at->longitude, 0, 0};
    located_ = anchored_ || is_told_by(component);
  }

  /// Another component's positions need another anchor.
  void change_to(std::uint8_t component) {
    anchored_ = false;
    if (others_.by == component) std::swap(told_, others_);
  }

  /// The vessel rebooted, so its local frame has a new origin: discards one reported up to
  /// since_us.
  void forget(std::int64_t since_us) {
    if (told_.us <= since_us) told_.by = 0;
  }

 private:
  struct Told {
    link::GpsGlobalOrigin origin{};
    std::uint8_t by = 0;  ///< component; 0: nobody
    std::int64_t us = 0;
  };

  convert::Position position_;
  Told told_, others_;
  bool anchored_ = false, located_ = false;
};

}  // namespace flotilla::app
