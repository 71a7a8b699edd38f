// SPDX-License-Identifier: MIT
#include "app/convert/convert.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "app/convert/geodesy.hpp"
#include "app/convert/portable.hpp"

namespace flotilla::app::convert {
namespace {

using geodesy::Plane;

constexpr double kSameSide_m = 6e6;  // depth below the plane

/// At the origin's altitude if a body of water can lie there, else at 0 m.
Plane plane_at(const link::GpsGlobalOrigin& o) {
  constexpr double kHighest_m = 9000;
  const double height_m = o.altitude * 1e-3;
  return {o.latitude, o.longitude, std::abs(height_m) <= kHighest_m ? height_m : 0};
}

/// The leader's position north-east from us in our plane, and the turn of its north from ours.
struct Seen {
  Metres north_m, east_m;
  double turn_rad;
  bool same_side;  ///< on our side of the globe
};

Seen seen_from(const Position& own, const Position& leader) {
  if (own.origin.latitude == leader.origin.latitude &&
      own.origin.longitude == leader.origin.longitude) {
    return {leader.north_m - own.north_m, leader.east_m - own.east_m, 0, true};
  }
  const Plane ours = plane_at(own.origin), theirs = plane_at(leader.origin);
  const auto [north_m, east_m, down_m] =
      ours.local_of(theirs.sea_level({number(leader.north_m), number(leader.east_m)}));
  return {north_m - own.north_m, east_m - own.east_m, ours.turn_of(theirs), down_m < kSameSide_m};
}

bool is_near(const Seen& seen, const Reach& within) {
  const auto surely = [&](Metres x) { return -within.surely_m <= x && x <= within.surely_m; };
  if (surely(seen.north_m) && surely(seen.east_m)) return seen.same_side;
  const double north_m = number(seen.north_m), east_m = number(seen.east_m), most_m = within.m;
  return seen.same_side && north_m * north_m + east_m * east_m <= most_m * most_m;
}

}  // namespace

template <class S>
Separation<S> separation(const Position& own, const Position& leader) {
  const Seen seen = seen_from(own, leader);
  return {{limited<S>(-seen.north_m), limited<S>(-seen.east_m)}, is_near(seen, kNear)};
}

template <class S>
Separation<S> way_to(const Position& from, const GlobalPoint& to, float within_m) {
  const Plane plane = plane_at(from.origin), there{to.latitude, to.longitude};
  const auto [north_m, east_m, down_m] = plane.local_of(there.origin());
  const Seen seen{north_m - from.north_m, east_m - from.east_m, 0, down_m < kSameSide_m};
  if (!is_near(seen, within_m)) return {};
  return {{scalar<S>(seen.north_m), scalar<S>(seen.east_m)}, true};
}

template <class S>
core::ControllerInput<S> controller_input_of(const Position& own, const core::Motion<S>& own_motion,
                                             const Position& leader,
                                             const core::Motion<S>& leader_motion) {
  const Seen seen = seen_from(own, leader);
  const S turn = scalar<S>(seen.turn_rad);
  const core::Vec2<S> moved =
      seen.turn_rad == 0 ? leader_motion.moved_n : core::to_north_east(turn, leader_motion.moved_n);
  return {{scalar<S>(-seen.north_m) + own_motion.moved_n.x - moved.x,
           scalar<S>(-seen.east_m) + own_motion.moved_n.y - moved.y},
          own_motion.psi,
          leader_motion.psi + turn,
          own_motion.nu,
          leader_motion.nu,
          leader_motion.nu_dot,
          {},
          {}};
}

template <class S>
Sample<S> in_plane(const Sample<S>& global, const link::GpsGlobalOrigin& origin) {
  const Plane plane = plane_at(origin), there{global.at->latitude, global.at->longitude};
  const auto [north_m, east_m, down_m] = plane.local_of(there.origin());
  Sample<S> sample = global;
  sample.north_m = north_m;
  sample.east_m = east_m;
  sample.psi_rad = sample.psi_rad + scalar<S>(plane.turn_of(there));
  sample.at.reset();
  return sample;
}

bool reaches(const link::GpsGlobalOrigin& origin, const GlobalPoint& at) {
  constexpr double kReach_m = 100e3;
  const Plane there{at.latitude, at.longitude};
  return geodesy::distance_m(plane_at(origin).origin(), there.origin()) <= kReach_m;
}

GlobalPoint global_of(const Position& position) {
  const Plane plane = plane_at(position.origin);
  const auto [latitude, longitude] =
      geodesy::degrees_of(plane.sea_level({number(position.north_m), number(position.east_m)}));
  return {latitude, longitude, plane.turn_of({latitude, longitude})};
}

bool near(const Position& own, const Position& leader, const Reach& within) {
  return is_near(seen_from(own, leader), within);
}

double distance_m(const Position& a, const Position& b) {
  const Seen seen = seen_from(a, b);
  return seen.same_side ? portable::hypot(number(seen.north_m), number(seen.east_m))
                        : std::numeric_limits<double>::infinity();
}

#define FLOTILLA_INSTANTIATE(S)                                                          \
  template Separation<S> separation<S>(const Position&, const Position&);                \
  template Separation<S> way_to<S>(const Position&, const GlobalPoint&, float);          \
  template core::ControllerInput<S> controller_input_of<S>(                              \
      const Position&, const core::Motion<S>&, const Position&, const core::Motion<S>&); \
  template Sample<S> in_plane<S>(const Sample<S>&, const link::GpsGlobalOrigin&);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
FLOTILLA_INSTANTIATE(core::Q16)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app::convert
