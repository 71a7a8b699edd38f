// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

#include "core/scalar/fixed_eigen.hpp"

namespace flotilla::core {
namespace {

using Matrix = Eigen::Matrix<Q16, 3, 3>;
using Vector = Eigen::Matrix<Q16, 3, 1>;

/// A vessel's mass matrix: positive definite, sway and yaw coupled.
Matrix mass() {
  Matrix m = Matrix::Zero();
  m(0, 0) = Q16(25.8);
  m(1, 1) = Q16(33.8);
  m(2, 2) = Q16(2.76);
  m(1, 2) = m(2, 1) = Q16(1.0948);
  return m;
}

double number(Q16 x) { return x.raw() / 65536.0; }

TEST_CASE("M nu by Eigen equals the product written out, to the last bit") {
  const Vector nu(Q16(1.2), Q16(-0.3), Q16(0.1));
  const Vector momentum = mass() * nu;
  CHECK(momentum(0) == Q16(25.8) * nu(0));
  CHECK(momentum(1) == Q16(33.8) * nu(1) + Q16(1.0948) * nu(2));
  CHECK((nu + nu).isApprox(Q16(2) * nu));
  CHECK(nu.dot(nu) == nu(0) * nu(0) + nu(1) * nu(1) + nu(2) * nu(2));
  CHECK((nu / Q16(2))(0) == nu(0) / Q16(2));
}

TEST_CASE("the acceleration by Cholesky is M^-1 tau, within 1e-3") {
  const Vector tau(Q16(10), Q16(-4), Q16(1.5));
  const Vector nu_dot = mass().llt().solve(tau);
  const double m11 = 25.8, m22 = 33.8, m23 = 1.0948, m33 = 2.76;
  const double determinant = m22 * m33 - m23 * m23;
  CHECK(std::abs(number(nu_dot(0)) - 10 / m11) < 1e-3);
  CHECK(std::abs(number(nu_dot(1)) - (m33 * -4 - m23 * 1.5) / determinant) < 1e-3);
  CHECK(std::abs(number(nu_dot(2)) - (m22 * 1.5 - m23 * -4) / determinant) < 1e-3);
}

TEST_CASE("a vector's length and direction are those of its components") {
  const Eigen::Matrix<Q16, 2, 1> way(Q16(3), Q16(-4));
  CHECK(way.norm() == Q16(5));
  CHECK(way.cwiseAbs().maxCoeff() == Q16(4));
  CHECK(way.normalized()(1) == Q16(-0.8));
}

TEST_CASE("in-place operations give the same as the plain ones") {
  Q16 x(1.5);
  CHECK((x += Q16(2)) == Q16(3.5));
  CHECK((x -= Q16(0.5)) == Q16(3));
  CHECK((x *= Q16(-0.25)) == Q16(-0.75));
  CHECK((x /= Q16(3)) == Q16(-0.25));
}

TEST_CASE("Eigen's traits give the ends of the range and one LSB") {
  using Traits = Eigen::NumTraits<Q16>;
  q16_overflow = false;
  CHECK(Traits::epsilon() == Q16(1) / Q16(16384) / Q16(4));
  CHECK(number(Traits::lowest()) == -32768);
  CHECK(number(Traits::highest()) == 32768 - 1.0 / 65536);
  CHECK_FALSE(q16_overflow);
  CHECK(Traits::highest() + Traits::epsilon() == Traits::highest());
  CHECK(std::exchange(q16_overflow, false));
  CHECK(std::pow(2.0, Traits::digits()) == 2147483648.0);
  CHECK(std::pow(10.0, Traits::digits10()) < 32768);
}

}  // namespace
}  // namespace flotilla::core
