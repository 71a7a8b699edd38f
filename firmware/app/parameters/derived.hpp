// SPDX-License-Identifier: MIT
// Gains that scale with the boat. They replace a negative LAW_KDU, LAW_KDR, LAW_OBS_BW, LAW_CUR_BW,
// LAW_XT_DIST or LAW_R_MAX; other values count as they are set.
//
//   τ = THR_LAG + τ₀                       lag of the propellers, and τ₀ = 18 ms of the loop itself
//   T_u = 4.18 τ,  T_r = 1.81 τ            time constants of the velocity loops
//   k_du = m11 / T_u − d11                 m11 ė_u = −(d11 + k_du) e_u: the gain adds only the
//   k_dr = m33 / T_r − d33                 damping that the drag does not give
//   ω = min(2 rad/s, 1 / T_u)              the observer is not faster than the loops
//   ω_c = 0.1 rad/s max(1, min(T_v, 6/T_v))   T_v = m22 / d22: a hull that drifts on for long looks
//                                          like a current, and the estimate should follow the drift
//   Δ = min(100 m, L / 1.3, max(1 m, 2 u_max T_r))   look-ahead: the lateral loop T_r ÿ + ẏ + y u/Δ = 0
//                                          has the damping 0.7 at u_max. A longer Δ has a cost: an
//                                          error of the course displaces the boat by Δ times it
//   r_max = min(0.8 · 1.3 m / max(L, 1.3 m), 0.6 N_max / (d33 + d33u u_max / 2)) rad/s
//
//   unknown THR_LAG: 20 ms (√(m11 / 1.012 kg) − 1), within 0 … 0.5 s
//
// The paper's vessel, without lag, gets the paper's k_du = k_dr = 10. Its loops have T_u = 75 ms
// and T_r = 33 ms; every boat has the same T_u/τ and T_r/τ. With a lag τ the loop m ν̇ = X − d ν,
// τ Ẋ = −k ν − X has the damping ζ = ½ √(T/τ), about 1.0 in surge and 0.67 in yaw.
#pragma once

#include <optional>
#include <string_view>

#include "app/parameters.hpp"

namespace flotilla::app {

/// The same parameters with each negative gain replaced by the derived one.
Parameters derived(const Parameters& p);

/// A gain that gives its loop a time constant that does not fit another loop's.
struct GainFault {
  std::string_view gain;
  float value;
  float time_s;
  std::string_view loop;
  std::string_view other;  ///< the parameter that limits it
  float allowed_s;
  bool more;  ///< true: allowed_s or more; false: or less
};

/// The first gain that does not fit the hull, whether an operator set it or it is derived. Each
/// loop must have a damping of ½ or more together with the loop inside it:
///
///   too fast for the propellers   ζ² = (m + d τ)² / (4 m τ (d + k)) < ¼, observer: ω τ > 1
///   too slow for the outer loop   T_u k_x > 1, T_r k_ψ > 1
///
/// While THR_LAG is unknown nothing is too fast.
std::optional<GainFault> gain_fault(const Parameters& p);

}  // namespace flotilla::app
