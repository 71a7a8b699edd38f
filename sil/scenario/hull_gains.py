# SPDX-License-Identifier: MIT
"""Gains of the law for a hull and its propellers.

Both velocity loops, m ν̇ = T − d ν and τ Ṫ = −k ν − T, have the damping ζ that the paper's gains of
10 and 10 have on its vessel, with τ₀ for the loop's own delay:

k = (m + d τ)² / (4 ζ² m τ) − d,  τ = lag + τ₀,  ζ_u = 1.0853, ζ_r = 0.7023, τ₀ = 18 ms

k: LAW_KDU, LAW_KDR. LAW_XT_DIST is 1 m. The observer is slower than the propellers,
LAW_OBS_BW = min(2, 1/4τ). Where
the hull drifts on for longer than a second, m22/d22 = T, the estimate of the current follows that
drift, yet stays slower than the hull: LAW_CUR_BW = 0.6/T. All found by sailing the five hulls.
"""

from sil.plant.hull import HullParameters
from sil.scenario.sections import Propellers

_ZETA_U, _ZETA_R, _DELAY_S = 1.0853, 0.7023, 0.018
_LOOK_AHEAD_M = 1.0
_OBSERVER_MOST, _OF_LAG = 2.0, 0.25
_LONG_S, _OF_DRIFT = 1.0, 0.6


def gains(model: HullParameters, pair: Propellers) -> dict[str, float]:
    """LAW_* for a linear hull; what keeps the firmware's default is left out."""
    tau = pair.lag_s + _DELAY_S
    law = {
        "LAW_KDU": _loop(model.m11, model.d11, _ZETA_U, tau),
        "LAW_KDR": _loop(model.m33, model.d33, _ZETA_R, tau),
        "LAW_XT_DIST": _LOOK_AHEAD_M,
        "LAW_OBS_BW": min(_OBSERVER_MOST, _OF_LAG / tau),
    }
    drift_s = model.m22 / model.d22
    if drift_s > _LONG_S:
        law["LAW_CUR_BW"] = _OF_DRIFT / drift_s
    return law


def _loop(m: float, d: float, zeta: float, tau: float) -> float:
    return max(0.0, float((m + d * tau) ** 2 / (4.0 * zeta**2 * m * tau) - d))
