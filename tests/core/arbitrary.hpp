// SPDX-License-Identifier: MIT
// Random boats and encounters within the ranges that core's headers promise.
#pragma once

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "core/controller.hpp"
#include "core/scalar/fixed.hpp"

namespace flotilla::testing {

constexpr double kPi = 3.14159265358979323846;

/// A test's number in the scalar of core.
template <class S>
S in_scalar(double x) {
  return S(x);
}
template <>
inline core::Q16 in_scalar(double x) {
  return core::Q16::of_raw(core::Q16::saturated(std::llround(65536 * x)));
}

inline double number_of(float x) { return double{x}; }
inline double number_of(double x) { return x; }
inline double number_of(core::Q16 x) { return x.raw() / 65536.0; }

/// Draws in double, so that float and double see the same numbers.
struct Random {
  explicit Random(std::uint32_t seed) : engine(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  double angle() { return (*this)(-kPi, kPi); }
  std::mt19937 engine;
};

/// Equal except for some rounding errors of numbers as large as `scale`.
template <class S>
doctest::Approx approx(S value, double scale = 1) {
  const double epsilon = 100 * static_cast<double>(std::numeric_limits<S>::epsilon());
  return doctest::Approx(static_cast<double>(value)).epsilon(epsilon).scale(scale);
}

/// Equal to the last bit, including the sign of a zero.
inline bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}
inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

template <class S>
core::Nu<S> arbitrary_nu(Random& random) {
  return {in_scalar<S>(random(-3, 3)), in_scalar<S>(random(-1, 1)), in_scalar<S>(random(-2, 2))};
}

template <class S>
core::ControllerInput<S> arbitrary_encounter(Random& random) {
  core::ControllerInput<S> in;
  in.separation_n = {in_scalar<S>(random(-30, 30)), in_scalar<S>(random(-30, 30))};
  in.psi = in_scalar<S>(random.angle());
  in.psi_L = in_scalar<S>(random.angle());
  in.nu = arbitrary_nu<S>(random);
  in.nu_L = arbitrary_nu<S>(random);
  in.nu_L_dot = arbitrary_nu<S>(random);
  return in;
}

/// A boat in its slot, with its leader's velocity.
template <class S>
core::ControllerInput<S> encounter_in_slot(const core::Vec2<S>& d, Random& random) {
  core::ControllerInput<S> in = arbitrary_encounter<S>(random);
  in.separation_n = d;
  in.psi = in.psi_L;
  in.nu = in.nu_L;
  return in;
}

/// The encounter h later: both with their velocity, the leader with its acceleration.
inline core::ControllerInput<double> later(core::ControllerInput<double> in, double h) {
  const auto way = [h](double psi, const core::Nu<double>& nu) {
    return core::to_north_east(psi + 0.5 * h * nu.r, core::Vec2<double>{h * nu.u, h * nu.v});
  };
  const core::Vec2<double> own = way(in.psi, in.nu), leader = way(in.psi_L, in.nu_L);
  in.separation_n = {in.separation_n.x + own.x - leader.x, in.separation_n.y + own.y - leader.y};
  in.psi += h * in.nu.r;
  in.psi_L += h * in.nu_L.r;
  in.nu_L = {in.nu_L.u + h * in.nu_L_dot.u, in.nu_L.v + h * in.nu_L_dot.v,
             in.nu_L.r + h * in.nu_L_dot.r};
  return in;
}

/// The paper's error and virtual velocity: the slot has the leader's motion.
template <class S>
core::FormationError<S> papers_error(const core::ControllerInput<S>& in, const core::Vec2<S>& d) {
  return core::formation_error(in, core::slot_beside(in, d));
}

template <class S>
core::VirtualVelocity<S> papers_velocity(const core::VirtualVelocityParams<S>& params,
                                         const core::VirtualVelocityState<S>& state,
                                         const core::ControllerInput<S>& in,
                                         const core::Vec2<S>& d) {
  return core::virtual_velocity(params, state, core::slot_beside(in, d), papers_error(in, d), {});
}

template <class S>
core::Vessel<S> arbitrary_vessel(Random& random) {
  const auto draw = [&] { return in_scalar<S>(random(0.1, 50)); };
  return {draw(), draw(), draw(), draw(), draw(), draw()};
}

/// A vessel whose m11 is `m11_m22` times its m22.
template <class S>
core::Vessel<S> arbitrary_vessel(Random& random, S m11_m22) {
  const core::Vessel<S> v = arbitrary_vessel<S>(random);
  return {m11_m22 * v.m22, v.m22, v.m33, v.d11, v.d22, v.d33};
}

/// The same vessel with drag ahead and in yaw that grows with its speed.
template <class S>
core::Vessel<S> with_speed_drag(const core::Vessel<S>& m, Random& random) {
  const S d11q = in_scalar<S>(random(0, 20)), d33u = in_scalar<S>(random(0, 20));
  return {m.m11, m.m22, m.m33, m.d11, m.d22, m.d33, d11q, d33u};
}

/// The vessel of the paper's section III.
template <class S>
core::Vessel<S> papers_vessel() {
  return {S(1.012), S(1.982), S(0.354), S(3.436), S(18.99), S(0.864)};
}

}  // namespace flotilla::testing
