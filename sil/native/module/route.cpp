// SPDX-License-Identifier: MIT
#include "route.hpp"

#include <nanobind/ndarray.h>

#include <cmath>
#include <vector>

#include "core/route.hpp"

namespace nb = nanobind;
using namespace flotilla;
using namespace nb::literals;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 5>, nb::c_contig, nb::device::cpu>;
constexpr std::size_t kColumns = 10;

constexpr const char* kSailRoute =
    "Sails a route as the firmware's planner does: straight legs, rounded corners.\n\n"
    "waypoints (N, 5), N > 1: north and east (m), speed of the leg that ends there (m/s),\n"
    "greatest distance of the rounded corner from it (m), time to wait there (s). accel,\n"
    "yaw_rate, yaw_accel: limits (m/s², rad/s, rad/s²); radius: of a corner's arc (m), larger\n"
    "where the yaw limits demand it; half_width: distance of the outermost slot that turns with\n"
    "the leader (m).\n\n"
    "Returns (steps, 10), a row every step_s seconds: north, east, heading (m, m, rad), surge,\n"
    "sway, yaw rate, their derivatives, and the number of the waypoint ahead (N after the\n"
    "last).\n\n"
    "ValueError if two successive waypoints are less than 0.1 m apart or a value is out of range.";

nb::object sail_route(Points waypoints, double accel, double yaw_rate, double yaw_accel,
                      double radius, double half_width, double step_s, std::size_t steps) {
  if (waypoints.shape(0) < 2) throw nb::value_error("waypoints: two or more");
  for (const double limit : {accel, yaw_rate, yaw_accel, step_s}) {
    if (!(limit > 0 && std::isfinite(limit))) {
      throw nb::value_error("accel, yaw_rate, yaw_accel, step_s: positive numbers");
    }
  }
  if (!(radius >= 0 && half_width >= 0)) throw nb::value_error("radius, half_width: not negative");
  std::vector<core::Waypoint<double>> points;
  for (std::size_t i = 0; i < waypoints.shape(0); ++i) {
    const double* row = waypoints.data() + 5 * i;
    const core::Waypoint<double> point{{row[0], row[1]}, row[2], row[3], row[4]};
    const std::string which = "waypoint " + std::to_string(i + 1);
    if (!std::isfinite(row[0] + row[1] + row[4]) || !(row[3] >= 0) ||
        (i > 0 && !(row[2] > 0 && std::isfinite(row[2])))) {
      throw nb::value_error(
          (which + ": finite numbers, a positive speed, reach not negative").c_str());
    }
    if (i > 0 && std::hypot(row[0] - points.back().place.x, row[1] - points.back().place.y) <
                     1e-3 * core::kShortestLeg_mm) {
      throw nb::value_error((which + ": less than 0.1 m from the one before").c_str());
    }
    points.push_back(point);
  }
  const core::RouteParams<double> params{accel, yaw_rate, yaw_accel, radius, half_width};
  auto* out = new double[std::max<std::size_t>(1, steps) * kColumns];
  const nb::capsule owner(out, [](void* p) noexcept { delete[] static_cast<double*>(p); });
  auto state = core::route_start<double>(params, points);
  for (std::size_t k = 0; k < steps; ++k) {
    if (k > 0) core::route_forward<double>(params, points, state, 1.0, step_s);
    const auto& [at, psi, nu, rate] = state.motion;
    const bool arrived = state.phase == core::RoutePhase::kArrived;
    const double row[] = {
        at.x, at.y,   psi,    nu.u,   nu.v,
        nu.r, rate.u, rate.v, rate.r, static_cast<double>(arrived ? points.size() : state.next)};
    std::copy(std::begin(row), std::end(row), out + k * kColumns);
  }
  return nb::cast(nb::ndarray<nb::numpy, double>(out, {steps, kColumns}, owner));
}

}  // namespace

void bind_route(nb::module_& m) {
  m.def("sail_route", &sail_route, "waypoints"_a, "accel"_a, "yaw_rate"_a, "yaw_accel"_a,
        "radius"_a, "half_width"_a, "step_s"_a, "steps"_a, kSailRoute);
}
