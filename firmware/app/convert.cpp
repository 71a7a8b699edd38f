// SPDX-License-Identifier: MIT
#include "app/convert.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/geodesy.hpp"

namespace flotilla::app::convert {
namespace {

using geodesy::Plane;

constexpr double kPi = 3.14159265358979323846;

/// At the height that the origin says, where that can be one of a water.
Plane plane_at(const link::GpsGlobalOrigin& o) {
  constexpr double kHighest_m = 9000;
  const double height_m = o.altitude * 1e-3;
  return {o.latitude, o.longitude, std::abs(height_m) <= kHighest_m ? height_m : 0};
}

/// Where the leader is, north-east from us in our plane, and how far its plane's north is turned.
struct Seen {
  double north_m, east_m, turn_rad;
  bool same_side;  ///< of the globe
};

Seen seen_from(const Position& own, const Position& leader) {
  if (own.origin.latitude == leader.origin.latitude &&
      own.origin.longitude == leader.origin.longitude) {
    return {leader.north_m - own.north_m, leader.east_m - own.east_m, 0, true};
  }
  const Plane ours = plane_at(own.origin), theirs = plane_at(leader.origin);
  constexpr double kSameSide_m = 6e6;
  const auto [north_m, east_m, down_m] =
      ours.local_of(theirs.sea_level({leader.north_m, leader.east_m}));
  return {north_m - own.north_m, east_m - own.east_m, ours.turn_of(theirs), down_m < kSameSide_m};
}

std::int16_t cm_per_s(double mps) {
  return static_cast<std::int16_t>(std::lround(100 * std::clamp(mps, -300.0, 300.0)));
}

}  // namespace

template <class S>
core::Vec2<S> separation(const Position& own, const Position& leader) {
  const Seen seen = seen_from(own, leader);
  return {scalar<S>(-seen.north_m), scalar<S>(-seen.east_m)};
}

template <class S>
core::Encounter<S> encounter_of(const Position& own, const core::Motion<S>& own_motion,
                                const Position& leader, const core::Motion<S>& leader_motion) {
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

Sample in_plane(const Sample& global, const link::GpsGlobalOrigin& origin) {
  const Plane plane = plane_at(origin), there{global.at->latitude, global.at->longitude};
  const auto [north_m, east_m, down_m] = plane.local_of(there.origin());
  Sample sample = global;
  sample.north_m = north_m;
  sample.east_m = east_m;
  sample.psi_rad += plane.turn_of(there);
  sample.at.reset();
  return sample;
}

bool reaches(const link::GpsGlobalOrigin& origin, const GlobalPoint& at) {
  constexpr double kReach_m = 100e3;
  const Plane there{at.latitude, at.longitude};
  return geodesy::distance_m(plane_at(origin).origin(), there.origin()) <= kReach_m;
}

template <class S>
GlobalPoint global_of(const Position& position, const core::Vec2<S>& moved_n) {
  const Plane plane = plane_at(position.origin);
  const auto [latitude, longitude] = geodesy::degrees_of(
      plane.sea_level({position.north_m + number(moved_n.x), position.east_m + number(moved_n.y)}));
  return {latitude, longitude, plane.turn_of({latitude, longitude})};
}

bool near(const Position& own, const Position& leader) {
  constexpr double kNear_m = 5000;
  const Seen seen = seen_from(own, leader);
  return seen.same_side &&
         seen.north_m * seen.north_m + seen.east_m * seen.east_m <= kNear_m * kNear_m;
}

double distance_m(const Position& a, const Position& b) {
  const Seen seen = seen_from(a, b);
  return seen.same_side ? std::hypot(seen.north_m, seen.east_m)
                        : std::numeric_limits<double>::infinity();
}

template <class S>
core::ControllerParams<S> controller_params(const Parameters& p) {
  const bool turns = p.FORM_FRAME == 1.0F;
  return {
      {{scalar<S>(p.FORM_OFS_N), scalar<S>(p.FORM_OFS_E)}, turns, turns || p.LAW_CUR_BW > 0},
      {scalar<S>(p.LAW_KX), scalar<S>(p.LAW_KPSI), scalar<S>(p.LAW_U_MAX), scalar<S>(p.LAW_R_MAX)},
      {scalar<S>(p.LAW_KDU), scalar<S>(p.LAW_KDR)},
      {scalar<S>(p.VES_M11), scalar<S>(p.VES_M22), scalar<S>(p.VES_M33), scalar<S>(p.VES_D11),
       scalar<S>(p.VES_D22), scalar<S>(p.VES_D33)},
      {scalar<S>(p.THR_ARM), scalar<S>(p.THR_FWD_MAX), scalar<S>(p.THR_REV_MAX)},
      {scalar<S>(p.LAW_XT_DIST)},
      {scalar<S>(p.FS_SEP_M)}};
}

template <class S>
core::ObserverParams<S> observer_params(const Parameters& p) {
  const S most =
      S(0.5) * (scalar<S>(p.THR_FWD_MAX) + scalar<S>(p.THR_REV_MAX));  // half of what both give
  return {scalar<S>(p.LAW_OBS_BW), scalar<S>(p.LAW_CUR_BW), {most, scalar<S>(p.THR_ARM) * most}};
}

template <class S>
core::ThrustCurveParams<S> thrust_curve_params(const Parameters& p) {
  return {scalar<S>(p.THR_FWD_MAX), scalar<S>(p.THR_REV_MAX), scalar<S>(p.THR_EXPO),
          scalar<S>(p.THR_DEAD), S(kRawFull)};
}

template <class S>
core::JumpLimits<S> jump_limits(const Parameters& p, bool carried) {
  // Twice what the model says: it may be half wrong. A current of 2 m/s may begin at once.
  const float thrust = 4 * std::max(p.THR_FWD_MAX, p.THR_REV_MAX);
  const float moment = p.THR_ARM * thrust;
  const auto within = [](float most, float x) { return scalar<S>(std::min(x, most)); };
  constexpr float kAnyRate = 500, kAnySpeed = 150;  // that, and no state is refused for it
  const S current = S(2);
  const core::JumpLimits<S> afloat{S(1),
                                   S(0.8),
                                   current,
                                   S(1.5),
                                   within(kAnyRate, thrust / p.VES_M11),
                                   within(kAnyRate, moment / p.VES_M33),
                                   within(kAnySpeed, thrust / p.VES_D11) + current,
                                   within(kAnySpeed, moment / p.VES_D33)};
  if (!carried) return afloat;
  return {S(20), S(4), S(20), S(20), afloat.a, afloat.a_r, afloat.V + S(20), afloat.R + S(20)};
}

template <class S>
link::Attitude attitude_of(const OwnState<S>& state, std::uint32_t time_boot_ms) {
  const auto psi = static_cast<float>(core::wrap_pi(state.motion.psi));
  return {time_boot_ms, 0, 0, psi, 0, 0, static_cast<float>(state.motion.nu.r)};
}

template <class S>
link::LocalPositionNed local_position_of(const OwnState<S>& state, std::uint32_t time_boot_ms) {
  const auto& motion = state.motion;
  const core::Vec2<S> v_n =
      core::to_north_east(motion.psi, core::Vec2<S>{motion.nu.u, motion.nu.v});
  return {time_boot_ms,
          static_cast<float>(state.north_m + number(motion.moved_n.x)),
          static_cast<float>(state.east_m + number(motion.moved_n.y)),
          0,
          static_cast<float>(v_n.x),
          static_cast<float>(v_n.y),
          0};
}

template <class S>
link::GlobalPositionInt global_position_of(const OwnState<S>& state, std::uint32_t time_boot_ms) {
  const auto& [moved_n, psi, nu, nu_dot] = state.motion;
  const GlobalPoint at = global_of({state.north_m, state.east_m, state.origin}, moved_n);
  const double psi_rad = number(psi) - at.turn_rad;
  const auto v_n = core::to_north_east(psi_rad, core::Vec2<double>{number(nu.u), number(nu.v)});
  const double turn_cdeg = 18'000 / kPi * core::wrap_pi(psi_rad);
  const auto hdg = static_cast<std::uint16_t>((std::lround(turn_cdeg) + 36'000) % 36'000);
  return {time_boot_ms,    at.latitude, at.longitude, state.origin.altitude, 0, cm_per_s(v_n.x),
          cm_per_s(v_n.y), 0,           hdg};
}

template <class S>
link::FollowTarget follow_target_of(const OwnState<S>& state, std::uint64_t timestamp_ms) {
  namespace mav = link::mav;
  const auto& [moved_n, psi, nu, nu_dot] = state.motion;
  const GlobalPoint at = global_of({state.north_m, state.east_m, state.origin}, moved_n);
  const S psi_n = core::wrap_pi(psi - scalar<S>(at.turn_rad));
  const core::Vec2<S> v_n = core::to_north_east(psi_n, core::Vec2<S>{nu.u, nu.v});
  const core::Vec2<S> a_n =
      core::to_north_east(psi_n, core::Vec2<S>{nu_dot.u - nu.r * nu.v, nu_dot.v + nu.r * nu.u});
  const auto f = [](S value) { return static_cast<float>(value); };
  const S half = S(0.5) * psi_n;
  return {timestamp_ms,
          at.latitude,
          at.longitude,
          static_cast<float>(state.origin.altitude * 1e-3),
          {f(v_n.x), f(v_n.y), 0},
          {f(a_n.x), f(a_n.y), 0},
          {f(core::cos(half)), 0, 0, f(core::sin(half))},
          {0, 0, f(nu.r)},
          mav::kFollowPosition | mav::kFollowVelocity | mav::kFollowAcceleration |
              mav::kFollowAttitude};
}

#define FLOTILLA_INSTANTIATE(S)                                                         \
  template core::Vec2<S> separation<S>(const Position&, const Position&);               \
  template core::Encounter<S> encounter_of<S>(const Position&, const core::Motion<S>&,  \
                                              const Position&, const core::Motion<S>&); \
  template GlobalPoint global_of<S>(const Position&, const core::Vec2<S>&);             \
  template core::ControllerParams<S> controller_params<S>(const Parameters&);           \
  template core::ObserverParams<S> observer_params<S>(const Parameters&);               \
  template core::ThrustCurveParams<S> thrust_curve_params<S>(const Parameters&);        \
  template core::JumpLimits<S> jump_limits<S>(const Parameters&, bool);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
FLOTILLA_INSTANTIATE(core::Q16)
#undef FLOTILLA_INSTANTIATE

#define FLOTILLA_INSTANTIATE(S)                                                              \
  template link::Attitude attitude_of<S>(const OwnState<S>&, std::uint32_t);                 \
  template link::LocalPositionNed local_position_of<S>(const OwnState<S>&, std::uint32_t);   \
  template link::GlobalPositionInt global_position_of<S>(const OwnState<S>&, std::uint32_t); \
  template link::FollowTarget follow_target_of<S>(const OwnState<S>&, std::uint64_t);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app::convert
