// SPDX-License-Identifier: MIT
// A hull, and its observer, which receives its fixes.
#pragma once

#include "core/piloted_boat.hpp"

namespace flotilla::testing {

/// Standard deviations of a fix.
struct Noise {
  double place = 0, heading = 0, speed = 0, yaw_rate = 0;
};

/// A hull and its observer, with a fix every `spacing` seconds.
template <class S>
struct Watched {
  core::ObserverParams<S> params = products_law<S>().observer;
  Hull hull{{0, 0, 0.3, 0.58, 0, 0}};
  double spacing = 0.05;
  Noise noise{};
  core::Tau<double> extra{};  ///< a force unknown to the observer
  double t = 0;
  Random random{77};
  core::Observer<S> state{};
  core::Vec2<double> anchor{};

  Sighting fix() {
    Sighting s = sighting_of(hull);
    const auto off = [&](double sigma) {
      return sigma * std::normal_distribution<double>()(random.engine);
    };
    s.place = {s.place.x + off(noise.place), s.place.y + off(noise.place)};
    s.psi += off(noise.heading);
    s.nu = {s.nu.u + off(noise.speed), s.nu.v + off(noise.speed), s.nu.r + off(noise.yaw_rate)};
    return s;
  }

  /// The observer takes a fix.
  void take(const Sighting& s) {
    const core::Vec2<S>& moved = state.motion.moved_n;
    core::observer_correct(
        params, papers_vessel<S>(), state,
        core::Fix<S>{{S(anchor.x - s.place.x) + moved.x, S(anchor.y - s.place.y) + moved.y},
                     core::wrap_pi(S(s.psi)),
                     in_scalar<S>(s.nu),
                     S(0),
                     t > 0 ? S(spacing) : S(0)});
    anchor = s.place;
  }

  /// Advances to the next fix: `given` moves the hull, `told` is the wrench that the observer gets.
  void go(const core::Tau<double>& given, const core::Tau<double>& told) {
    for (double h = 0; h < spacing - 0.01 / 2; h += 0.01) {
      hull.advance({given.X + extra.X, given.N + extra.N}, 0.01);
      core::observer_forward(papers_vessel<S>(), state, core::Tau<S>{S(told.X), S(told.N)},
                             S(0.01));
    }
    t += spacing;
  }

  void sail(const core::Tau<double>& given, const core::Tau<double>& told) {
    take(fix());
    go(given, told);
  }

  void sail_until(double until, const Thrusting& thrust) {
    while (t < until - 0.01 / 2) sail(thrust(t), thrust(t));
  }

  core::Tau<double> unknown() const {
    return in_double(core::unknown_wrench(papers_vessel<S>(), state));
  }
};

}  // namespace flotilla::testing
