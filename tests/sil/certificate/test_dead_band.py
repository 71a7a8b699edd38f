# SPDX-License-Identifier: MIT
"""A propeller with a dead band in the certificate: against deviations that are sailed."""

import numpy as np
import pytest

from sil.certificate import monodromy
from sil.certificate.certified_fleet import fleet, parameters
from sil.certificate.loop import COMPONENTS, Boat, Loop, leader_rows
from sil.certificate.references import references
from sil.certificate.sampled import sampled_loop
from sil.scenario import scenario
from tests.each_push import few
from tests.sil.certificate.made_up import AT_REST, behind

BLUEBOAT = 2  # of `mixed`: one propeller crosses its dead band in each turn
_CURRENT = COMPONENTS.index("current north")


@pytest.fixture(scope="module")
def blueboat() -> Boat:
    mixed = scenario.load("mixed")
    groups = fleet(mixed, references(mixed)[0], parameters(mixed, {}))
    return next(boat for boats, _, boat in groups if BLUEBOAT in boats)


def shrinking(boat: Boat, off: float, laps: int) -> float:
    """By how much a deviation of the estimated current shrinks in a lap, with the dead band."""
    regime = monodromy.settle(boat, [monodromy.instants(boat, 1, windows=1)])
    (start,) = regime.points[0].states
    lap = round(boat.leader.window_s * boat.rate_hz)
    loop, apart = Loop(boat, 2), []
    both = np.tile(start, (2, 1))
    both[1, _CURRENT] += off
    loop.resume(int(regime.points[0].ticks[0]), both)
    for _ in range(2 + laps):  # the first two are for faster modes
        times_s = boat.h_s * np.arange(loop.tick, loop.tick + lap, dtype=np.float64)
        for row in leader_rows(boat.leader, times_s):
            loop.step(row)
        here, there = loop.state[:, _CURRENT]
        apart.append(abs(there - here))
    return float((apart[-1] / apart[1]) ** (1.0 / laps))


@pytest.mark.parametrize("off_mps", few([1e-3, 1e-2, -3e-2], [1e-2]))
def test_deviations_of_every_size_shrink_as_the_multipliers_say(
    blueboat: Boat, off_mps: float
) -> None:
    assert blueboat.propellers.dead > 0.0
    loop, _ = sampled_loop(blueboat, False)
    assert loop.holds
    lap_s = blueboat.leader.window_s
    assert shrinking(blueboat, off_mps, 3) == pytest.approx(np.exp(-loop.decay * lap_s), rel=0.08)
    # |w| ≤ 2.5 N of each propeller leaves an error, which is told
    assert 0.001 < np.hypot(loop.error[0], loop.error[1]) < 0.03


def test_a_dead_band_does_not_stabilise_an_unstable_loop() -> None:
    rates = ("rate_hz=50.0", "navigation.rate_hz=50.0", "propellers.dead=0.02")
    decay = np.exp(-0.864 / 0.354 * 0.02)
    limit = 0.864 * (1.0 + decay) / (1.0 - decay) - 0.864  # of the held yaw loop
    for share, outcome in ((0.98, "converges"), (1.04, "grows")):
        changed = {"LAW_KDR": share * limit}
        reference, boat = behind((*rates, *AT_REST), "paper", changed, 1)
        assert sampled_loop(boat, reference.kind == "rest")[0].outcome == outcome
