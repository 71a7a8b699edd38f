# SPDX-License-Identifier: MIT
"""Runs in processes: equal to runs in one process, whatever happens to the others."""

import multiprocessing
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sil.results.sailing import Job, Outcome, sail, sail_all

SHORT = ("duration_s=4.0",)
NOISY = ("duration_s=3.0", "navigation.position_noise_m=0.1")


class Fatal(Job):
    """A job that kills the process that unpickles it."""

    def __reduce__(self) -> tuple[Any, ...]:
        return os._exit, (9,)


JOBS = [
    Job("diamond", "paper", None, SHORT),
    Job("diamond", "product", None, ("duration_s=-4.0",)),
    Fatal("diamond", "paper", 13, SHORT),
    Job("diamond", "paper", 2, NOISY),
    Job("diamond", "product", None, SHORT),
]


@pytest.fixture(scope="module")
def outcomes() -> list[Outcome]:
    told: list[Outcome] = []
    outcomes = sail_all(JOBS, 2, told.append)
    assert len(told) == len(JOBS) and {o.job for o in told} == set(JOBS)
    return outcomes


def test_outcomes_come_in_the_order_of_the_jobs(outcomes: list[Outcome]) -> None:
    assert [outcome.job for outcome in outcomes] == JOBS


@pytest.mark.parametrize("place", [0, 3, 4])
def test_run_beside_others_is_the_run_alone(
    outcomes: list[Outcome], place: int, tmp_path: Path
) -> None:
    alone, beside = sail(JOBS[place], tmp_path), outcomes[place]
    assert not beside.failure
    assert beside.digest == alone.digest and beside.figures == alone.figures
    assert beside.boats == alone.boats and len(beside.boats) == 4
    for name in ("t_s", "eta", "error"):
        np.testing.assert_array_equal(beside.trace[name], alone.trace[name])
    assert list(tmp_path.iterdir()) == []


def test_failed_run_has_its_reason(outcomes: list[Outcome]) -> None:
    assert "must be greater than 0" in outcomes[1].failure
    assert str(outcomes[1].job) == "diamond, product"


def test_run_that_kills_its_process_is_reported_and_loses_no_other(outcomes: list[Outcome]) -> None:
    assert outcomes[2].failure == "the process died"
    assert [bool(outcome.failure) for outcome in outcomes] == [False, True, True, False, False]


def test_laws_and_seeds_are_those_asked_for(outcomes: list[Outcome]) -> None:
    assert len({outcomes[place].digest for place in (0, 3, 4)}) == 3
    assert "deviation_from_reference" in outcomes[0].figures
    assert "deviation_from_reference" not in outcomes[4].figures


def test_interrupted_sailing_leaves_no_process_behind() -> None:
    def interrupt(outcome: Outcome) -> None:
        raise KeyboardInterrupt

    endless = Job("diamond", "paper", None, ("duration_s=10000",))
    refused = Job("diamond", "paper", None, ("duration_s=-1",))
    with pytest.raises(KeyboardInterrupt):
        sail_all([endless, refused], 2, interrupt)
    assert multiprocessing.active_children() == []
