// SPDX-License-Identifier: MIT
// Random boats and encounters within the ranges that core's headers promise.
#pragma once

#include <doctest/doctest.h>

#include <limits>
#include <random>

#include "core/controller.hpp"

namespace flotilla::testing {

constexpr double kPi = 3.14159265358979323846;

/// Draws in double, so that float and double see the same numbers.
struct Random {
  explicit Random(std::uint32_t seed) : engine(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  double angle() { return (*this)(-kPi, kPi); }
  std::mt19937 engine;
};

/// Equal but for some roundings of numbers as large as `scale`.
template <class S>
doctest::Approx approx(S value, double scale = 1) {
  const double epsilon = 100 * static_cast<double>(std::numeric_limits<S>::epsilon());
  return doctest::Approx(static_cast<double>(value)).epsilon(epsilon).scale(scale);
}

template <class S>
core::Nu<S> arbitrary_nu(Random& random) {
  return {S(random(-3, 3)), S(random(-1, 1)), S(random(-2, 2))};
}

template <class S>
core::Encounter<S> arbitrary_encounter(Random& random) {
  core::Encounter<S> in;
  in.separation_n = {S(random(-30, 30)), S(random(-30, 30))};
  in.psi = S(random.angle());
  in.psi_L = S(random.angle());
  in.nu = arbitrary_nu<S>(random);
  in.nu_L = arbitrary_nu<S>(random);
  in.nu_L_dot = arbitrary_nu<S>(random);
  return in;
}

/// In its slot, with its leader's velocity.
template <class S>
core::Encounter<S> encounter_in_slot(const core::Vec2<S>& d, Random& random) {
  core::Encounter<S> in = arbitrary_encounter<S>(random);
  in.separation_n = d;
  in.psi = in.psi_L;
  in.nu = in.nu_L;
  return in;
}

template <class S>
core::Vessel<S> arbitrary_vessel(Random& random) {
  const auto draw = [&] { return S(random(0.1, 50)); };
  return {draw(), draw(), draw(), draw(), draw(), draw()};
}

/// The vessel of the paper's section III.
template <class S>
core::Vessel<S> papers_vessel() {
  return {S(1.012), S(1.982), S(0.354), S(3.436), S(18.99), S(0.864)};
}

}  // namespace flotilla::testing
