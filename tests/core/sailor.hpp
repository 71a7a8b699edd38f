// SPDX-License-Identifier: MIT
// A boat of the product among others, for the tests of separation.
#pragma once

#include "core/closed_loop.hpp"
#include "core/piloted_boat.hpp"
#include "core/separation.hpp"

namespace flotilla::testing {

using core::ControllerOutput;
using core::ControllerParams;
using core::ControllerState;
using core::OtherVessel;
using core::Traffic;
using core::Vec2;

constexpr double kMin = 1.5;

/// A boat under the product's law behind a leader, among other vessels whose motion it knows
/// exactly.
struct Sailor {
  ControllerParams<double> law = products_law<double>().law;
  ControllerState<double> state{};
  Hull hull{};
  ControllerOutput<double> out{};
  double h = 0.01;

  explicit Sailor(Hull::Q q, double least = kMin) {
    hull.q = q;
    law.separation.least = least;
  }
  Vec2<double> place() const { return {hull.q[0], hull.q[1]}; }
  Vec2<double> velocity() const {
    return to_north_east(hull.q[2], Vec2<double>{hull.q[3], hull.q[4]});
  }
  OtherVessel<double> seen_by(const Sailor& other, bool has_way) const {
    return {minus(place(), other.place()), velocity(), 0, has_way, false};
  }
  void sail(const Sighting& leader, const Traffic<double>& traffic) {
    const auto in = controller_input_of<double>(sighting_of(hull), leader);
    if (!state.slot.started) state = controller_start(in);
    out = controller_step(law, state, in, h, &traffic);
    hull.advance(out.allocation.given, h);
  }
};

inline Sighting leader_at(double north, double east, double speed = 0.5) {
  return {{north, east}, 0, {speed, 0, 0}, {}};
}

inline Traffic<double> only(const OtherVessel<double>& other) {
  Traffic<double> traffic;
  traffic.vessels[0] = other;
  traffic.count = 1;
  return traffic;
}

}  // namespace flotilla::testing
