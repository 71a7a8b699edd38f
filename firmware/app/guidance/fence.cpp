// SPDX-License-Identifier: MIT
#include "app/guidance/fence.hpp"

#include <algorithm>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

using core::Q16;

constexpr int kReach_m = 4000, kOriginReach_m = 100'000;
constexpr Q16 kRounding = Q16(0.02);  // of clearances, m

constexpr std::string_view kOutside = "outside the fence", kNear = "too near to the fence",
                           kWay = "the way there leaves the fence",
                           kWayNear = "the way there is too near to the fence",
                           kFar = "over 4 km from the fence";

bool same_place(const link::GpsGlobalOrigin& a, const link::GpsGlobalOrigin& b) {
  return a.latitude == b.latitude && a.longitude == b.longitude && a.altitude == b.altitude;
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

/// In the plane of the boat's origin if that is near, else in the plane of the first item.
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
  return way + kRounding < margin ? kWayNear : std::string_view{};
}

std::string_view Fence::refusal_of(const convert::GlobalPoint& place, float margin_m) const {
  if (!is_on()) return {};
  const auto at = on_map(place);
  if (!at) return kFar;
  const Length clear = clearance(*at);
  if (!(Q16(0) < clear)) return kOutside;
  return clear + kRounding < convert::scalar<Q16>(margin_m) ? kNear : std::string_view{};
}

std::string_view Fence::refusal_of(const convert::GlobalPoint& from, const convert::GlobalPoint& to,
                                   float margin_m) const {
  if (const std::string_view why = refusal_of(to, margin_m); !why.empty() || !is_on()) return why;
  const auto a = on_map(from), b = on_map(to);
  if (!a || !b) return kFar;
  const Length way = clearance(*a, *b);
  if (!(Q16(0) < way)) return kWay;
  return way + kRounding < convert::scalar<Q16>(margin_m) ? kWayNear : std::string_view{};
}

}  // namespace flotilla::app
