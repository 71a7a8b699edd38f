// SPDX-License-Identifier: MIT
#include "app/convert/law.hpp"

#include <algorithm>
#include <cmath>

#include "app/convert/convert_scalar.hpp"
#include "app/parameters/derived.hpp"

namespace flotilla::app::convert {
namespace {

/// Thrust limits of the weaker propeller.
template <class S>
core::AllocationParams<S> propellers_of(const Parameters& p) {
  const float share = 1 - std::abs(p.THR_BALANCE);
  const bool brakes = p.LAW_U_MAX > 0;  // the paper's law has no greatest speed
  return {scalar<S>(p.THR_ARM), scalar<S>(share * p.THR_FWD_MAX), scalar<S>(share * p.THR_REV_MAX),
          brakes};
}

template <class S>
core::SeparationParams<S> separation_params(const Parameters& p) {
  core::SeparationParams<S> out{scalar<S>(separation_m(p))};
  out.horizon = core::horizon_of(out, scalar<S>(p.LAW_U_MAX), scalar<S>(p.LAW_R_MAX),
                                 scalar<S>(p.THR_REV_MAX / p.VES_M11));
  return out;
}

template <class S>
core::ControllerParams<S> controller_params(const Parameters& p) {
  const bool turns = p.FORM_FRAME == 1.0F;
  return {
      {{scalar<S>(p.FORM_OFS_N), scalar<S>(p.FORM_OFS_E)}, turns, turns || p.LAW_CUR_BW > 0},
      {scalar<S>(p.LAW_KX), scalar<S>(p.LAW_KPSI), scalar<S>(p.LAW_U_MAX), scalar<S>(p.LAW_R_MAX)},
      {scalar<S>(p.LAW_KDU), scalar<S>(p.LAW_KDR)},
      {scalar<S>(p.VES_M11), scalar<S>(p.VES_M22), scalar<S>(p.VES_M33), scalar<S>(p.VES_D11),
       scalar<S>(p.VES_D22), scalar<S>(p.VES_D33), scalar<S>(p.VES_D11Q), scalar<S>(p.VES_D33U)},
      propellers_of<S>(p),
      {scalar<S>(p.LAW_XT_DIST)},
      separation_params<S>(p)};
}

template <class S>
core::StationParams<S> station_params(const Parameters& p) {
  core::StationParams<S> out{scalar<S>(p.FS_SLOT_M), scalar<S>(p.LAW_XT_DIST),
                             scalar<S>(p.LAW_R_MAX)};
  constexpr float kFourTurns_rad = 25.13F, kLongest_s = 900;
  if (p.LAW_R_MAX > 0) {
    out.stuck_s =
        core::max(out.stuck_s, scalar<S>(std::min(kFourTurns_rad / p.LAW_R_MAX, kLongest_s)));
  }
  return out;
}

template <class S>
core::ObserverParams<S> observer_params(const Parameters& p) {
  const S most = S(0.5) * (scalar<S>(p.THR_FWD_MAX) + scalar<S>(p.THR_REV_MAX));  // half of both
  return {scalar<S>(p.LAW_OBS_BW),
          scalar<S>(p.LAW_CUR_BW),
          {most / scalar<S>(p.VES_M11), most / scalar<S>(p.VES_M22),
           scalar<S>(p.THR_ARM) * most / scalar<S>(p.VES_M33)}};
}

template <class S>
core::ThrustCurveParams<S> thrust_curve_params(const Parameters& p, float share) {
  return {scalar<S>(share * p.THR_FWD_MAX), scalar<S>(share * p.THR_REV_MAX), scalar<S>(p.THR_EXPO),
          scalar<S>(p.THR_DEAD), S(kRawFull)};
}

template <class S>
core::PlausibilityLimits<S> plausibility_limits(const Parameters& p, bool carried) {
  // Twice the model's values, because the model may be wrong by half. A current of 2 m/s may begin
  // at once.
  const float thrust = 4 * std::max(p.THR_FWD_MAX, p.THR_REV_MAX);
  const float moment = p.THR_ARM * thrust;
  const auto within = [](float most, float x) { return scalar<S>(std::min(x, most)); };
  constexpr float kAnyRate = 500, kAnySpeed = 150;  // above these no state is refused
  const S current = S(2);
  const core::PlausibilityLimits<S> afloat{S(1),
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
core::ForesightLimits<S> foresight_limits(const Parameters& p) {
  constexpr float kAny = 100;
  return {scalar<S>(p.LAW_U_MAX > 0 ? p.LAW_U_MAX / 5 : kAny),
          scalar<S>(p.LAW_R_MAX > 0 ? p.LAW_R_MAX / 4 : kAny)};
}

/// Limits of the planned motion: the hull can follow it with a quarter of its thrust and half of
/// LAW_R_MAX. The law corrects its errors with the rest.
template <class S>
core::RouteParams<S> route_params(const Parameters& p) {
  const float force = p.THR_FWD_MAX / 2, moment = p.THR_ARM * std::min(force, p.THR_REV_MAX / 2);
  core::RouteParams<S> out;
  out.accel = core::min(out.accel, scalar<S>(std::min(force / p.VES_M11, 1.0F)));
  out.yaw_accel = core::min(out.yaw_accel, scalar<S>(std::min(moment / p.VES_M33, 1.0F)));
  const float damping = p.VES_D33 + p.VES_D33U * p.WP_SPEED;
  const float rate = std::min(p.LAW_R_MAX > 0 ? p.LAW_R_MAX / 2 : 1, moment / damping);
  out.yaw_rate = core::min(out.yaw_rate, scalar<S>(rate));
  out.half_width = scalar<S>(p.WP_WIDTH);
  out.radius = scalar<S>(1.25F * p.WP_WIDTH);  // the slot on the inside keeps steerage way
  return out;
}

}  // namespace

template <class S>
Law<S> law_of(const Parameters& given) {
  const Parameters p = derived(given);
  return {.controller = controller_params<S>(p),
          .station = station_params<S>(p),
          .observer = observer_params<S>(p),
          .foresight = foresight_limits<S>(p),
          .afloat = plausibility_limits<S>(p, false),
          .carried = plausibility_limits<S>(p, true),
          .port_curve = thrust_curve_params<S>(p, 1 - p.THR_BALANCE),
          .stbd_curve = thrust_curve_params<S>(p, 1 + p.THR_BALANCE),
          .slew = scalar<S>(p.THR_SLEW),
          .coast_s = scalar<S>(p.FS_COAST_S),
          .antenna = {scalar<S>(p.NAV_OFS_X), scalar<S>(p.NAV_OFS_Y)},
          .latency = {.d = p.VES_D33 / p.VES_M33},
          .yaw_inertia_kgm2 = p.VES_M33,
          .route = route_params<S>(p)};
}

template Law<float> law_of(const Parameters&);
template Law<double> law_of(const Parameters&);
template Law<core::Q16> law_of(const Parameters&);

}  // namespace flotilla::app::convert
