# SPDX-License-Identifier: MIT
"""Columns of motion that contradict each other are refused: swapped axes, signs, units."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from sil.identify import kinematics
from sil.identify.voyage_log import Array, BadLogError, VoyageLog
from tests.sil.identify.sailed import Noise, levels, sail

EXACT, GPS = Noise(0.0, 0.0, 0.0, 0.0), Noise(position=0.3, heading=0.1)


def plain(noise: Noise = EXACT, current: tuple[float, float] = (0.0, 0.0)) -> VoyageLog:
    rng = np.random.default_rng(1)
    return sail(levels(rng, 150.0), rng, noise, current=current)


@pytest.mark.parametrize(
    "log",
    [
        plain(),
        plain(current=(0.3, -0.2)),
        plain(GPS),
        replace(plain(), motion=np.full((900, 6), np.nan)),
    ],
)
def test_a_log_that_agrees_with_itself_passes(log: VoyageLog) -> None:
    kinematics.check(log)


def test_a_compass_that_deviates_by_20_degrees_passes() -> None:
    log = plain()
    kinematics.check(replace(log, motion=log.motion + np.radians(20.0) * np.eye(6)[2]))


SPOILT: dict[str, tuple[Callable[[Array], Array], str]] = {
    "north and east swapped": (lambda m: m[:, [1, 0, 2, 3, 4, 5]], "north and east"),
    "heading counted from east": (lambda m: m + 0.5 * np.pi * np.eye(6)[2], "north and east"),
    "speed in knots": (lambda m: m * [1, 1, 1, 1.944, 1.944, 1], "their units"),
    "speed astern": (lambda m: m * [1, 1, 1, -1, -1, 1], "their signs"),
    "heading anticlockwise": (lambda m: m * [1, 1, -1, 1, 1, 1], "heading turns by -1°"),
    "yaw rate said to be in degrees": (lambda m: m * [1, 1, 1, 1, 1, 1 / 57.3], "by 57°"),
    "speed said to be in mm/s": (lambda m: m * [1, 1, 1, 1e-3, 1e-3, 1], "their units"),
    "yaw rate in degrees": (lambda m: m * [1, 1, 1, 1, 1, 57.3], "heading turns by 0.017°"),
}


@pytest.mark.parametrize("case", SPOILT)
def test_a_log_that_contradicts_itself_is_refused(case: str) -> None:
    spoil, told = SPOILT[case]
    log = plain()
    with pytest.raises(BadLogError, match=told):
        kinematics.check(replace(log, motion=spoil(log.motion)))
