// SPDX-License-Identifier: MIT
// The law's parameters as core's structs, in the law's scalar.
#pragma once

#include "app/parameters.hpp"
#include "core/controller.hpp"
#include "core/estimation/latency_params.hpp"
#include "core/estimation/observer.hpp"
#include "core/estimation/plausibility.hpp"
#include "core/reference.hpp"
#include "core/route.hpp"
#include "core/station.hpp"
#include "core/thrust_curve.hpp"

namespace flotilla::app::convert {

/// Full scale of RawCommand (AM32 and VESC divide by 8192).
constexpr int kRawFull = 8191;

template <class S>
struct Law {
  core::ControllerParams<S> controller;
  core::StationParams<S> station;
  core::ObserverParams<S> observer;
  /// The shares of LAW_U_MAX and LAW_R_MAX with which the boat itself approaches its slot.
  core::ForesightLimits<S> foresight;
  /// Limits of the boat's motion from propellers and water; carried: by hand, or on a trailer.
  core::PlausibilityLimits<S> afloat, carried;
  core::ThrustCurveParams<S> port_curve, stbd_curve;
  S slew;
  S coast_s;
  core::Vec2<S> antenna;
  // float for every S: products of its variances are below Q16's resolution.
  core::LatencyParams<float> latency;
  float yaw_inertia_kgm2;
  core::RouteParams<S> route;  ///< of the vessel that sails a plan
};

template <class S>
Law<S> law_of(const Parameters& p);

}  // namespace flotilla::app::convert
