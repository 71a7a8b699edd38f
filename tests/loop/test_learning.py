# SPDX-License-Identifier: MIT
"""Boats find which number of their model is wrong, and find nothing where none is.

The short form of `python -m tests.loop.learning`.
"""

import re
from collections.abc import Sequence
from functools import cache

import pytest

from sil.scenario import presets
from tests.each_push import few
from tests.loop import learning
from tests.loop.learning import BALANCE, DRAG, YAW, Learnt, Wrong

MOST_M = 0.2  # from the slots, RMS
ERRORS = {BALANCE: 0.015, DRAG: 0.1, YAW: 0.15}


@cache
def learnt(fleet: str, changes: tuple[str, ...], minutes: float) -> list[Learnt]:
    return learning.learnt(fleet, changes, [1], minutes)


def texts(runs: Sequence[Learnt]) -> list[str]:
    """All texts of all boats."""
    return [told.text for run in runs for own in run.texts.values() for told in own]


@pytest.mark.parametrize(
    "case",
    [
        learning.weak("noisy", 0.88, 1.0),
        learning.weak("current", 1.0, 0.88),
        learning.times("noisy", DRAG, 0.5),
        learning.times("noisy", YAW, 2.0),
        pytest.param(learning.times("noisy", DRAG, 2.0), marks=pytest.mark.nightly),
        pytest.param(learning.times("noisy", YAW, 0.5), marks=pytest.mark.nightly),
        pytest.param(learning.times("windy", DRAG, 2.0), marks=pytest.mark.nightly),
    ],
    ids=lambda case: f"{case.fleet}, {case.what}",
)
def test_every_boat_reports_the_wrong_parameter_and_no_other(case: Wrong) -> None:
    runs = learnt(case.fleet, case.changes, 5.0)
    row = learning.judged(case, runs)
    assert (row.found, row.others) == (1.0, 0), texts(runs)
    assert row.error[1] < ERRORS[case.number]
    assert row.rms_m < MOST_M and not row.left


@pytest.mark.parametrize("fleet", few(["noisy", "sea", "windy"], ["windy"]))
def test_boats_with_correct_parameters_report_nothing(fleet: str) -> None:
    assert not texts(learnt(fleet, (), 5.0))


@pytest.mark.parametrize(
    ("fleet", "minutes"),
    few(
        [*((name, 5.0) for name in presets.names()), ("blueboat in weather", 8.0)],
        [("blueboat", 5.0)],
    ),
)
def test_correct_parameters_are_reported_on_no_hull(fleet: str, minutes: float) -> None:
    told = texts(learnt(fleet, (), minutes))
    # a BlueBoat's propellers differ, and its parameters do not know it
    assert [text for text in told if "THR_BALANCE" not in text] == []


@pytest.mark.parametrize("hull", few(presets.names(), ["heron"]))
def test_a_drag_that_is_wrong_is_found_on_every_hull(hull: str) -> None:
    case = learning.preset_drag(hull, 1.7)
    runs = learnt(case.fleet, case.changes, 5.0)
    assert learning.judged(case, runs).found == 1.0, texts(runs)


def test_a_text_names_propeller_share_time_and_parameter_to_set() -> None:
    case = learning.weak("noisy", 0.88, 1.0)
    first = texts(learnt(case.fleet, case.changes, 5.0))[0]
    # the boats' clocks do not know the time of day
    assert re.fullmatch(r"Port 1\d % weak for \d min: THR_BALANCE 0\.0[5-8]", first), first
