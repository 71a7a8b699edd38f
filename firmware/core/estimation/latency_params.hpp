// SPDX-License-Identifier: MIT
// The parameters of latency.hpp, for those who need not read its matrices.
#pragma once

#include "core/scalar/scalar.hpp"

namespace flotilla::core {

template <class S>
struct LatencyParams {
  S d{};  ///< δ
  S h = S(0.05);
  S step = S(0.11);  ///< longest step of the integration, s
  S R = S(0.0001);
  S q_r = S(0.01), q_b = S(0.3), q_gamma = S(0.0001);
  S memory = S(60);  ///< of λ = 1 − dt/memory, s
  S gamma_min = S(0.2);
  S A_min = S(60);
  S D_min = S(60);
  S J_min = S(0.1);  ///< floor of J / Σλ, for the model's error
};

}  // namespace flotilla::core
