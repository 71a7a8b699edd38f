# SPDX-License-Identifier: MIT
"""The margins of a scenario's worst chain of boats: additional delay, and error of the hull.

Both are found by bisection; the chain's probes are sailed anew at each step. All boats have the
same error: masses and dampings deviate by the same share, up or down, in each of the four
combinations.
"""

from collections.abc import Callable
from dataclasses import dataclass

from sil.certificate.chain import Chain, chain
from sil.certificate.references import Reference
from sil.lockstep.start import RunError
from sil.scenario.scenario import Scenario

STEPS = 5  # steps of bisection
_MOST_DELAY_S, _MOST_SHARE = 1.0, 0.8


@dataclass(frozen=True)
class Margins:
    """The chain's margins beyond the scenario: s of radio delay, share of mass and damping."""

    delay_s: float
    mismatch: float


def margins(
    scenario: Scenario, reference: Reference, overrides: dict[str, float], found: Chain
) -> Margins:
    """The margins of the chain `found`; 0 if it does not hold even without changes."""
    if not found.holds or STEPS == 0:
        return Margins(0.0, 0.0)
    depth = len(found.path)

    def holds(changed: Scenario, scale: tuple[float, float] = (1.0, 1.0)) -> bool:
        try:
            only = found.path
            return chain(changed, reference, overrides, path=only, most=depth, scale=scale).holds
        except RunError:
            return False

    def late(delay_s: float) -> bool:
        link = scenario.link.model_copy(update={"delay_s": scenario.link.delay_s + delay_s})
        return holds(scenario.model_copy(update={"link": link}))

    def wrong(share: float) -> bool:
        factors = (1.0 + share, 1.0 - share)
        return all(holds(scenario, (m, d)) for m in factors for d in factors)

    return Margins(_greatest(late, _MOST_DELAY_S), _greatest(wrong, _MOST_SHARE))


def _greatest(holds: Callable[[float], bool], most: float) -> float:
    """The greatest tried value up to `most` that holds."""
    if holds(most):
        return most
    low, high = 0.0, most
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        if holds(middle):
            low = middle
        else:
            high = middle
    return low
