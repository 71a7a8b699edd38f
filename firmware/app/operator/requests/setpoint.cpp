// SPDX-License-Identifier: MIT
#include "app/operator/requests/setpoint.hpp"

#include <algorithm>
#include <cmath>

#include "app/convert/portable.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

// POSITION_TARGET_TYPEMASK: fields to ignore.
constexpr unsigned kPlace = 1 | 2, kVelocity = 8 | 16, kAcceleration = 64 | 128 | 256,
                   kYawRate = 2048;

// A script's slower velocity is rounding, and means rest.
constexpr double kRest_mps = 0.05;

/// The fields that both messages share; velocities north and east, or ahead and to starboard.
struct Request {
  unsigned ignored;
  bool in_body;  ///< the velocity
  double vx, vy, yaw_rate;
};

bool has(const Request& request, unsigned fields) { return (request.ignored & fields) == 0; }

/// Whether the fields a and b are both ignored, or both used and finite.
bool is_whole(const Request& request, unsigned fields, double a, double b) {
  if ((request.ignored & fields) == fields) return true;
  return has(request, fields) && std::isfinite(a) && std::isfinite(b);
}

Setpoint velocity_of(const Request& request) {
  const bool turns = has(request, kYawRate);
  if (turns && !std::isfinite(request.yaw_rate)) return {.why = "yaw rate is not finite"};
  if (!request.in_body && turns) return {.why = "yaw rate only in body frames"};
  if (request.in_body && (request.vx < -kRest_mps || std::abs(request.vy) > kRest_mps))
    return {.why = "body velocity must be ahead"};
  constexpr double kFastest_radps = 4;  // of any boat; the range of core/drive.hpp
  const double r = std::clamp(request.yaw_rate, -kFastest_radps, kFastest_radps);
  core::Drive<double> drive{request.vx, turns ? r : 0.0, {}};
  if (!request.in_body) {
    drive.u = portable::hypot(request.vx, request.vy);
    if (drive.u >= kRest_mps) drive.course = portable::atan2(request.vy, request.vx);
  }
  if (drive.u < kRest_mps) drive.u = 0;
  return {.drive = drive};
}

/// place: nothing if the frame is for velocities only.
Setpoint setpoint(const Request& request, const std::optional<convert::GlobalPoint>& place) {
  if ((request.ignored & kAcceleration) != kAcceleration)
    return {.why = "acceleration not supported"};
  if (!is_whole(request, kVelocity, request.vx, request.vy))
    return {.why = "velocity needs vx and vy"};
  if (!has(request, kPlace)) {
    return has(request, kVelocity) ? velocity_of(request)
                                   : Setpoint{.why = "no position or velocity"};
  }
  if (!place || !convert::is_valid({place->latitude, place->longitude, 0, 0})) {
    return {.why = "position invalid in this frame"};
  }
  const double speed = has(request, kVelocity) ? portable::hypot(request.vx, request.vy) : 0;
  return {.target = Target{*place, static_cast<float>(speed)}};
}

}  // namespace

Setpoint setpoint_of(const link::SetPositionTargetLocalNed& m, const convert::OwnState& own) {
  constexpr std::uint8_t kLocalOffsetNed = 7;
  const bool in_body = m.coordinate_frame == mav::kFrameBodyNed ||
                       m.coordinate_frame == mav::kFrameBodyOffsetNed ||
                       m.coordinate_frame == mav::kFrameBodyFrd;
  const bool offset = m.coordinate_frame == kLocalOffsetNed;
  if (!in_body && !offset && m.coordinate_frame != mav::kFrameLocalNed) {
    return {.why = "unsupported setpoint frame"};
  }
  const Request request{m.type_mask, in_body, double{m.vx}, double{m.vy}, double{m.yaw_rate}};
  if (!is_whole(request, kPlace, double{m.x}, double{m.y})) {
    return {.why = "position needs x and y"};
  }
  std::optional<convert::GlobalPoint> place;
  constexpr float kFar_m = 100'000;  // a tangent plane is inaccurate beyond this
  if (!in_body && std::abs(m.x) < kFar_m && std::abs(m.y) < kFar_m) {
    place = convert::global_of({double{m.x} + (offset ? own.north_m : 0.0),
                                double{m.y} + (offset ? own.east_m : 0.0), own.origin});
  }
  return setpoint(request, place);
}

Setpoint setpoint_of(const link::SetPositionTargetGlobalInt& m) {
  if (!is_global(m.coordinate_frame)) return {.why = "unsupported setpoint frame"};
  const Request request{m.type_mask, false, double{m.vx}, double{m.vy}, double{m.yaw_rate}};
  if (!is_whole(request, kPlace, 0, 0)) return {.why = "position needs x and y"};
  return setpoint(request, convert::GlobalPoint{m.lat_int, m.lon_int});
}

}  // namespace flotilla::app
