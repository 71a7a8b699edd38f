// SPDX-License-Identifier: MIT
// Horizontal rotation between north-east (n) and body (b) axes.
//
//   R(ψ) = [cos ψ  −sin ψ; sin ψ  cos ψ]      x_n = R(ψ) x_b      x_b = R(ψ)ᵀ x_n
//
//  symbol  meaning                          frame  unit  tested range
//  psi     heading, clockwise from north    n      rad   ±100
//
// Source: paper, J(q) below (eq:1).
//
// Q16.16: tested within ±200 (places, m)
#pragma once

#include "core/scalar/scalar.hpp"
#include "core/types.hpp"

namespace flotilla::core {

/// R(ψ), computed once for several vectors.
template <class S>
struct Rotation {
  S c = S(1);
  S s{};
};

template <class S>
Rotation<S> rotation(S psi) {
  const auto [s, c] = sin_cos(psi);
  return {c, s};
}

/// R(ψ) x_b.
template <class S>
Vec2<S> to_north_east(const Rotation<S>& R, const Vec2<S>& b) {
  return {difference_of_products(R.c, b.x, R.s, b.y), sum_of_products(R.s, b.x, R.c, b.y)};
}
template <class S>
Vec2<S> to_north_east(S psi, const Vec2<S>& b) {
  return to_north_east(rotation(psi), b);
}

/// R(ψ)ᵀ x_n.
template <class S>
Vec2<S> to_body(const Rotation<S>& R, const Vec2<S>& n) {
  return {sum_of_products(R.c, n.x, R.s, n.y), difference_of_products(R.c, n.y, R.s, n.x)};
}
template <class S>
Vec2<S> to_body(S psi, const Vec2<S>& n) {
  return to_body(rotation(psi), n);
}

/// Whether |v| < most, > most; computes no root where the components alone decide.
template <class S>
bool is_shorter(const Vec2<S>& v, S most) {
  return abs(v.x) < most && abs(v.y) < most && hypot(v.x, v.y) < most;
}
template <class S>
bool is_longer(const Vec2<S>& v, S most) {
  return most < abs(v.x) + abs(v.y) && most < hypot(v.x, v.y);
}

}  // namespace flotilla::core
