// SPDX-License-Identifier: MIT
#include "app/plan/fence.hpp"

#include <algorithm>
#include <array>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

using core::Q16;

constexpr int kReach_m = 4000, kOriginReach_m = 100'000;

constexpr std::string_view kOutside = "outside the fence", kNear = "too near the fence",
                           kWay = "path crosses the fence", kWayNear = "path is too near the fence",
                           kFar = "over 4 km from the fence";

bool same_place(const link::GpsGlobalOrigin& a, const link::GpsGlobalOrigin& b) {
  return a.latitude == b.latitude && a.longitude == b.longitude && a.altitude == b.altitude;
}

/// The place outside a corner of angle θ, at off / sin ½θ from it, but at most 4 off: legs along a
/// sharper corner come nearer than `off`.
std::optional<Fence::Place> beside_corner(std::span<const Fence::Place> corners, std::size_t i,
                                          Q16 off) {
  constexpr Q16 kStraight = Q16(0.02);
  const Fence::Place& here = corners[i];
  const auto towards = [&](const Fence::Place& there) {
    const Fence::Place way{there.x - here.x, there.y - here.y};
    const Q16 L = core::hypot(way.x, way.y);
    return Fence::Place{way.x / L, way.y / L};
  };
  const Fence::Place a = towards(corners[(i + corners.size() - 1) % corners.size()]);
  const Fence::Place b = towards(corners[(i + 1) % corners.size()]);
  const Fence::Place sum{a.x + b.x, a.y + b.y};
  const Q16 twice_cos = core::hypot(sum.x, sum.y);
  if (twice_cos < kStraight) return std::nullopt;
  const Q16 twice_sin = core::hypot(a.x - b.x, a.y - b.y);
  const Q16 away = core::min(Q16(2) * off / core::max(twice_sin, Q16(0.1)), Q16(4) * off);
  return Fence::Place{here.x - core::scaled(away, sum.x, twice_cos),
                      here.y - core::scaled(away, sum.y, twice_cos)};
}

/// A corner of the octagon whose edges keep `off` from the circle.
Fence::Place on_octagon(const core::Zone<Q16>& zone, std::size_t part, Q16 off) {
  constexpr Q16 kPerCos = Q16(1.0824), kSlant = Q16(0.70711);  // 1 / cos 22.5°, cos 45°
  constexpr std::array<std::array<int, 2>, Fence::kBends> kWays{
      {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};
  const auto& [north, east] = kWays[part];
  const Q16 radius = (zone.radius + off) * kPerCos;
  const Q16 far = north != 0 && east != 0 ? radius * kSlant : radius;
  return {zone.corners[0].x + Q16(north) * far, zone.corners[0].y + Q16(east) * far};
}

}  // namespace

void Fence::set(Plan items) {
  items_ = items;
  on_ = true;
  draw();
}

void Fence::locate(const link::GpsGlobalOrigin& origin) {
  if (origin_ && same_place(*origin_, origin)) return;
  origin_ = origin;
  draw();
}

/// Draws the map in the plane of the boat's origin if that is near, else in the plane of the first
/// item.
void Fence::draw() {
  ++drawn_;
  if (items_.empty()) return;
  const convert::GlobalPoint first{items_[0].x, items_[0].y};
  first_ = {0, 0, {first.latitude, first.longitude, 0, 0}};
  if (origin_) {
    const convert::Position at_origin{0, 0, *origin_};
    const auto [way, near] = convert::way_to<double>(at_origin, first, kOriginReach_m);
    if (near) first_ = {way.x, way.y, *origin_};
  }
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const convert::GlobalPoint corner{items_[i].x, items_[i].y};
    corners_[i] = convert::way_to<Q16>(first_, corner, kReach_m).n;
  }
}

std::optional<Fence::Place> Fence::on_map(const convert::Position& place) const {
  const auto [way, near] = convert::separation<Q16>(place, first_);
  const auto reached = [](Q16 x) { return core::abs(x) <= Q16(kReach_m); };
  return near && reached(way.x) && reached(way.y) ? std::optional(way) : std::nullopt;
}

std::optional<Fence::Place> Fence::on_map(const convert::GlobalPoint& place) const {
  const auto [way, near] = convert::way_to<Q16>(first_, place, kReach_m);
  return near ? std::optional(way) : std::nullopt;
}

template <class F>
void Fence::for_each_zone(F f) const {
  for (std::size_t at = 0; at < items_.size();) {
    const ZoneItems zone = first_zone(items_.subspan(at));
    const std::span<const Place> corners = corners_.subspan(at, zone.items.size());
    f(core::Zone<Q16>{corners, convert::scalar<Q16>(zone.radius_m), zone.keeps_in});
    at += zone.items.size();
  }
}

Fence::Length Fence::clearance(const Place& place) const {
  Length least = Q16(kReach_m);
  for_each_zone(
      [&](const core::Zone<Q16>& zone) { least = core::min(least, core::clearance(zone, place)); });
  return least;
}

Fence::Length Fence::clearance(const Place& a, const Place& b) const {
  Length least = Q16(kReach_m);
  for_each_zone(
      [&](const core::Zone<Q16>& zone) { least = core::min(least, core::clearance(zone, a, b)); });
  return least;
}

Fence::Length Fence::kept(const Place& a, const Place& b, float margin_m) const {
  return core::min(convert::scalar<Q16>(margin_m), core::min(clearance(a), clearance(b)));
}

bool Fence::is_straight(const convert::Position& here, const convert::GlobalPoint& target,
                        float margin_m) const {
  if (!is_on()) return true;
  const auto from = on_map(here), to = on_map(target);
  if (!from) return true;  // no zone is near; once on the map, the boat judges its leg again
  const Length now = clearance(*from);
  if (!(Q16(0) < now)) return true;
  if (!to) {
    const convert::Position there{0, 0, {target.latitude, target.longitude, 0, 0}};
    return convert::distance_m(here, there) < convert::number(now);
  }
  const Length way = clearance(*from, *to);
  return Q16(0) < way && !(way + kFenceRounding < kept(*from, *to, margin_m));
}

std::optional<Fence::Place> Fence::bend(std::size_t number, Length off) const {
  const std::size_t item = number / kBends, part = number % kBends;
  std::optional<Place> out;
  std::size_t at = 0;
  for_each_zone([&](const core::Zone<Q16>& zone) {
    const std::size_t i = item - at;  // wraps if the item is before the zone
    at += zone.corners.size();
    if (i >= zone.corners.size()) return;
    if (zone.corners.size() > 1) {
      if (part == 0) out = beside_corner(zone.corners, i, off);
    } else if (!zone.keeps_in) {
      out = on_octagon(zone, part, off);
    }
  });
  return out;
}

convert::GlobalPoint Fence::on_globe(const Place& place) const {
  return convert::global_of({first_.north_m + convert::number(place.x),
                             first_.east_m + convert::number(place.y), first_.origin});
}

bool Fence::permits_far() const {
  bool permits = true;
  for_each_zone([&](const core::Zone<Q16>& zone) { permits = permits && !zone.keeps_in; });
  return permits;
}

std::string_view Fence::refusal_of(const convert::Position& here,
                                   const convert::GlobalPoint& target, float margin_m) const {
  if (const std::string_view why = refusal_of(target, margin_m); !why.empty() || !is_on()) {
    return why;
  }
  const auto a = on_map(here), b = on_map(target);
  if (!a || !b) return kFar;
  const Length now = clearance(*a), way = clearance(*a, *b);
  if (!(Q16(0) < now)) return "the boat is outside the fence";
  if (!(Q16(0) < way)) return kWay;
  const Length margin = core::min(convert::scalar<Q16>(margin_m), now);
  return way + kFenceRounding < margin ? kWayNear : std::string_view{};
}

std::string_view Fence::refusal_of(const convert::GlobalPoint& place, float margin_m) const {
  if (!is_on()) return {};
  const auto at = on_map(place);
  if (!at) return kFar;
  const Length clear = clearance(*at);
  if (!(Q16(0) < clear)) return kOutside;
  return clear + kFenceRounding < convert::scalar<Q16>(margin_m) ? kNear : std::string_view{};
}

std::string_view Fence::refusal_of(const convert::GlobalPoint& from, const convert::GlobalPoint& to,
                                   float margin_m) const {
  if (const std::string_view why = refusal_of(to, margin_m); !why.empty() || !is_on()) return why;
  const auto a = on_map(from), b = on_map(to);
  if (!a || !b) return kFar;
  const Length way = clearance(*a, *b);
  if (!(Q16(0) < way)) return kWay;
  return way + kFenceRounding < convert::scalar<Q16>(margin_m) ? kWayNear : std::string_view{};
}

}  // namespace flotilla::app
