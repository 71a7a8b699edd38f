# SPDX-License-Identifier: MIT
"""The paper's small-gain test by its printed formulas; it is only a sufficient condition.

 γ1 = 2 T β / μ                                            (eq:gamma1)
 β  = 1 + 2 ω̄² T + α + ω̄                                   (above eq:gamma1)
 α  = max{ω̄, (2 ω̄²/k_x)(1 + (T/4μ)(1 + k_x)²)}             (eq:alpha, the least that it allows)
 γ2 = m11 k_x ω̄ / d22                                      (eq:gamma2)
 γ1 γ2 < (2 T m11/μ d22) k_x ω̄ (1 + 2 ω̄² T + 2 ω̄ + (2 ω̄²/k_x)(1 + (T/4μ) q))      (eq:above)
 with q = 1 + k_x² as printed there, or q = (1 + k_x)² as eq:alpha has it.
 ω̄ ≤ ((d22/m11) μ²/(4 μ T + T²))^⅓                         (eq:bound)

Source: Wang and Loría, Prop. 1 and 2. Lengths in m, times in s, masses in kg; without excitation
(μ = 0) every gain is infinite.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from scipy.optimize import brentq

from sil.certificate.references import Reference
from sil.plant.hull import HullParameters

MOST_K_X = 10.0


@dataclass(frozen=True)
class SmallGain:
    """The formulas' values at the chosen gains; `k_x_*`: largest k_x under 1, 1/s, or None.

    `MOST_K_X` stands for that value or more; `above_*`: right-hand side of eq:above, with q = (1 +
    k_x)² or 1 + k_x².
    """

    bound: float
    bound_holds: bool
    beta: float
    alpha: float
    gamma1: float
    gamma2: float
    product: float
    above_square_of_sum: float
    above_sum_of_squares: float
    k_x_product: float | None
    k_x_square_of_sum: float | None
    k_x_sum_of_squares: float | None
    k_du_least: float


def small_gain(vessel: HullParameters, reference: Reference, k_x: float, k_psi: float) -> SmallGain:
    """The test for one vessel with gains k_x, k_ψ (1/s) behind one reference."""
    case = _Case.of(vessel, reference)
    bound = case.bound()
    omega_M = k_psi + case.omega  # |ω*| ≤ ω_M
    return SmallGain(
        bound=bound,
        bound_holds=reference.mu > 0.0 and case.omega <= bound,
        beta=case.beta(k_x),
        alpha=case.alpha(k_x),
        gamma1=case.gamma1(k_x),
        gamma2=case.gamma2(k_x),
        product=case.product(k_x),
        above_square_of_sum=case.above(k_x, (1.0 + k_x) ** 2),
        above_sum_of_squares=case.above(k_x, 1.0 + k_x**2),
        k_x_product=_largest(case.product),
        k_x_square_of_sum=_largest(lambda k: case.above(k, (1.0 + k) ** 2)),
        k_x_sum_of_squares=_largest(lambda k: case.above(k, 1.0 + k**2)),
        k_du_least=vessel.m11**2 * omega_M**2 / (2.0 * vessel.d22),  # Prop. 1
    )


@dataclass(frozen=True)
class _Case:
    """ω̄, the mean of ω², T and T/μ of a reference, and d22/m11."""

    omega: float
    T: float
    T_over_mu: float
    d22_over_m11: float

    @staticmethod
    def of(vessel: HullParameters, reference: Reference) -> "_Case":
        T = reference.T_s or 0.0
        T_over_mu = T / reference.mu if reference.mu > 0.0 else math.inf
        ratio = vessel.d22 / vessel.m11
        return _Case(reference.omega_bar, T, T_over_mu, ratio)

    def bound(self) -> float:
        # μ²/(4μT + T²) = 1/(4 T/μ + (T/μ)²)
        return float(
            (self.d22_over_m11 / (4.0 * self.T_over_mu + self.T_over_mu**2)) ** (1.0 / 3.0)
        )

    def alpha(self, k_x: float) -> float:
        return max(self.omega, self._divided(k_x, (1.0 + k_x) ** 2))

    def beta(self, k_x: float) -> float:
        return 1.0 + 2.0 * self.omega**2 * self.T + self.alpha(k_x) + self.omega

    def gamma1(self, k_x: float) -> float:
        return 2.0 * self.T_over_mu * self.beta(k_x)

    def gamma2(self, k_x: float) -> float:
        return k_x * self.omega / self.d22_over_m11

    def product(self, k_x: float) -> float:
        return self._unless_idle(self.gamma1(k_x) * self.gamma2(k_x))

    def above(self, k_x: float, q: float) -> float:
        bracket = 1.0 + 2.0 * self.omega**2 * self.T + 2.0 * self.omega + self._divided(k_x, q)
        factor = 2.0 * self.T_over_mu / self.d22_over_m11
        return self._unless_idle(factor * k_x * self.omega * bracket)

    def _divided(self, k_x: float, q: float) -> float:
        if k_x == 0.0 or math.isinf(self.T_over_mu):
            return math.inf
        return 2.0 * self.omega**2 / k_x * (1.0 + self.T_over_mu / 4.0 * q)

    def _unless_idle(self, value: float) -> float:
        return math.inf if math.isnan(value) or math.isinf(self.T_over_mu) else value


def _largest(gain: Callable[[float], float]) -> float | None:
    """Largest k_x in (0, 10] whose gain, which grows with k_x, is under 1."""
    least = 1e-9
    if not gain(least) < 1.0:
        return None
    if gain(MOST_K_X) < 1.0:
        return MOST_K_X
    return float(brentq(lambda k: gain(k) - 1.0, least, MOST_K_X, xtol=1e-12))
