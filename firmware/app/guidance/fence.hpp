// SPDX-License-Identifier: MIT
// A stored fence as a map in metres, and what it permits. In fixed point whatever the law's scalar
// is: every machine gives the same answer, also one without floating point, at a bearable cost.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "app/guidance/zones.hpp"
#include "core/fence.hpp"

namespace flotilla::app {

class Fence {
 public:
  using Length = core::Q16;
  using Place = core::Vec2<Length>;  ///< north and east of the first item, m

  /// corners: one for each item that a fence may have; it must outlive this object.
  explicit Fence(std::span<Place> corners) : corners_(corners) {}

  /// Takes a sound fence; the items must stay until the next one, or none, is set.
  void set(Plan items);

  /// The origin of the boat's local frame, in whose plane the map is drawn from now on.
  void locate(const link::GpsGlobalOrigin& origin);

  /// A fence that is switched off permits everything.
  void enable(bool on) { on_ = on; }
  bool is_stored() const { return !items_.empty(); }
  bool is_on() const { return on_ && is_stored(); }
  /// Counts the maps that were drawn.
  std::uint32_t drawn() const { return drawn_; }

  /// Nothing beyond 4 km from the first item.
  std::optional<Place> on_map(const convert::Position& place) const;
  std::optional<Place> on_map(const convert::GlobalPoint& place) const;

  /// Distance to the nearest boundary, negative where the boat may not be; of a place, and of a
  /// straight leg. Only while a fence is stored.
  Length clearance(const Place& place) const;
  Length clearance(const Place& a, const Place& b) const;
  /// Whether a boat beyond the map is where it may be.
  bool permits_far() const;

  /// Bends that a way round the zones may have, numbered: kBends for each item.
  static constexpr std::size_t kBends = 8;
  std::size_t bends() const { return kBends * items_.size(); }
  /// The place that keeps `off` from a corner and both its edges, on the outside of their wedge; or
  /// from a circle to stay outside, a corner of the octagon round it. Perhaps not permitted; nothing
  /// where no way bends.
  std::optional<Place> bend(std::size_t number, Length off) const;
  convert::GlobalPoint on_globe(const Place& place) const;

  /// Why the boat may not go straight from `here` to `target`, keeping `margin_m` from every
  /// boundary; empty: it may. A boat that is nearer than that now must not come nearer still.
  std::string_view refusal_of(const convert::Position& here, const convert::GlobalPoint& target,
                              float margin_m) const;

  /// The same of a place alone, and of the leg between two places that a plan names.
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
