// SPDX-License-Identifier: MIT
// A stored fence as a map in metres, and what it permits. The map is in fixed point whatever the
// law's scalar is: every machine, also one without floating point, gives the same answer at an
// acceptable cost.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "app/plan/zones.hpp"
#include "core/fence.hpp"

namespace flotilla::app {

constexpr core::Q16 kFenceRounding = core::Q16(0.02);  ///< of clearances, m

class Fence {
 public:
  using Length = core::Q16;
  using Place = core::Vec2<Length>;  ///< north and east of the first item, m

  /// corners: room for one per item of a fence; it must outlive this object.
  explicit Fence(std::span<Place> corners) : corners_(corners) {}

  /// Takes a sound fence, or no items. The items must stay in place until the next call.
  void set(Plan items);

  /// Sets the origin of the boat's local frame, and draws the map in its plane if it is near.
  void locate(const link::GpsGlobalOrigin& origin);

  /// A fence that is switched off permits everything.
  void enable(bool on) {
    if (on != on_) ++drawn_;
    on_ = on;
  }
  bool is_stored() const { return !items_.empty(); }
  bool is_on() const { return on_ && is_stored(); }
  /// Changes with the map, and when the fence is switched on or off.
  std::uint32_t drawn() const { return drawn_; }

  /// Nothing beyond 4 km from the first item.
  std::optional<Place> on_map(const convert::Position& place) const;
  std::optional<Place> on_map(const convert::GlobalPoint& place) const;

  /// Distance of a place, or least distance of a straight leg, to the nearest boundary; negative
  /// where the boat may not be. Call only while a fence is stored.
  Length clearance(const Place& place) const;
  Length clearance(const Place& a, const Place& b) const;
  /// Distance that a path between two places must keep from every boundary: margin_m, or the
  /// clearance of one of the places if that is less.
  Length kept(const Place& a, const Place& b, float margin_m) const;
  /// Whether the boat may return straight from `here` to `target`: whether that path keeps this
  /// distance. Outside the fence, the boat may take any path back.
  bool is_straight(const convert::Position& here, const convert::GlobalPoint& target,
                   float margin_m) const;
  /// Whether the fence permits places beyond the map.
  bool permits_far() const;

  /// Places where a path round the zones may bend, numbered, kBends for each item.
  static constexpr std::size_t kBends = 8;
  std::size_t bends() const { return kBends * items_.size(); }
  /// A bend that keeps `off` from a polygon's corner and its two edges, on the outside of their
  /// wedge; or, for a circle that keeps the boat out, a corner of the octagon round it. The fence
  /// may forbid the place. Nothing where no path bends.
  std::optional<Place> bend(std::size_t number, Length off) const;
  convert::GlobalPoint on_globe(const Place& place) const;

  /// Why the boat may not go straight from `here` to `target`, keeping `margin_m` from every
  /// boundary; empty: it may. A boat that is already nearer must not come nearer still.
  std::string_view refusal_of(const convert::Position& here, const convert::GlobalPoint& target,
                              float margin_m) const;

  /// The same for a place alone, and for the leg between two places of a plan.
  std::string_view refusal_of(const convert::GlobalPoint& place, float margin_m) const;
  std::string_view refusal_of(const convert::GlobalPoint& from, const convert::GlobalPoint& to,
                              float margin_m) const;

 private:
  void draw();
  template <class F>
  void for_each_zone(F f) const;

  std::span<Place> corners_;
  Plan items_{};
  convert::Position first_{};  // the first item
  std::optional<link::GpsGlobalOrigin> origin_;
  std::uint32_t drawn_ = 0;
  bool on_ = true;
};

}  // namespace flotilla::app
