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

#include "core/scalar.hpp"
#include "core/types.hpp"

namespace flotilla::core {

/// R(ψ) x_b.
template <class S>
Vec2<S> to_north_east(S psi, const Vec2<S>& b) {
  const S c = cos(psi);
  const S s = sin(psi);
  return {c * b.x - s * b.y, s * b.x + c * b.y};
}

/// R(ψ)ᵀ x_n.
template <class S>
Vec2<S> to_body(S psi, const Vec2<S>& n) {
  const S c = cos(psi);
  const S s = sin(psi);
  return {c * n.x + s * n.y, c * n.y - s * n.x};
}

}  // namespace flotilla::core
