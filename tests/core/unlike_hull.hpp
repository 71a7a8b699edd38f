// SPDX-License-Identifier: MIT
// A hull that differs from its boat's model: its own model of a 20 kg catamaran.
#pragma once

#include <cmath>
#include <random>

#include "core/types.hpp"

namespace flotilla::testing {

struct UnlikeHull {
  // The boat's model: inertia, linear damping, half the distance between the propellers.
  static constexpr double m11 = 22, m22 = 30, m33 = 4, d11 = 14, d22 = 40, d33 = 6, a = 0.3;

  double drag = 1, yaw_damping = 1;  ///< factors relative to the model
  double balance = 0;                ///< share by which starboard is stronger, port weaker
  double wind_n = 0, wind_e = 0;     ///< forces that keep their direction over ground, N
  double wind_turns = 0;             ///< moment of that wind from abeam, N m
  double gust = 0;                   ///< standard deviation of the same, time constant 10 s
  double noise = 0;                  ///< of u, m/s; a fifth of it of r, rad/s
  unsigned seed = 1;

  double psi = 0, u = 0, v = 0, r = 0, t = 0, gust_n = 0, gust_e = 0;
  std::mt19937 random{seed};

  double normal() { return std::normal_distribution<double>()(random); }

  /// Applies the commanded wrench for 10 ms, in Euler steps of a millisecond.
  void step(const core::Tau<double>& told) {
    const double port = (1 - balance) * (told.X / 2 + told.N / (2 * a));
    const double stbd = (1 + balance) * (told.X / 2 - told.N / (2 * a));
    const double kept = std::exp(-0.01 / 10), fresh = gust * std::sqrt(1 - kept * kept);
    gust_n = kept * gust_n + fresh * normal();
    gust_e = kept * gust_e + fresh * normal();
    for (int i = 0; i < 10; ++i) {
      const double c = std::cos(psi), s = std::sin(psi);
      const double n = wind_n + gust_n, e = wind_e + gust_e;
      const double X = port + stbd + c * n + s * e, Y = c * e - s * n;
      const double N = a * (port - stbd) + wind_turns * Y;
      const double u_dot = (X + m22 * v * r - drag * d11 * u) / m11;
      const double v_dot = (Y - m11 * u * r - d22 * v) / m22;
      const double r_dot = (N - (m22 - m11) * u * v - yaw_damping * d33 * r) / m33;
      u += 0.001 * u_dot;
      v += 0.001 * v_dot;
      r += 0.001 * r_dot;
      psi += 0.001 * r;
    }
    t += 0.01;
  }

  /// The velocity as its navigation unit measures it.
  core::Nu<double> seen() {
    return {u + noise * normal(), v + noise * normal(), r + 0.2 * noise * normal()};
  }
};

/// Steers by hand along an S-curve; turns: amplitude of the heading, rad; speed: m/s.
inline core::Tau<double> helm(const UnlikeHull& hull, double turns, double speed) {
  const double desired = turns * std::sin(0.15 * hull.t);
  return {14 * speed + 20 * (speed - hull.u), 12 * (desired - hull.psi) - 6 * hull.r};
}

}  // namespace flotilla::testing
