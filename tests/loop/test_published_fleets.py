# SPDX-License-Identifier: MIT
"""Compares the published figures of fleets with runs sailed here, and with their targets.

Each push sails most cases, the one of many seeds with its first; --all sails all, and two seeds.
"""

import math

import pytest

from sil.lockstep.world import all_sailed, sail
from sil.results import results_fleets, sailing
from sil.results.sailing import Job

SHARE, LEAST = 1e-3, 1e-6  # figures are stored with 6 digits
RENEW = "renew what is published, and look at it: flotilla results --fleets"
# Of a step and a turn each push sails the harder run, in which messages are lost besides.
NIGHTLY = (
    "20 in a line, root 0.58 to 1.0 m/s at 150 s",
    "20 in a line, root straight, then 0.35 rad/s",
)

NOTED = results_fleets.noted()
BY_JOB = {outcome.job: outcome for outcome in NOTED}


def test_page_has_the_figures_that_are_noted() -> None:
    assert results_fleets.PAGE.read_text(encoding="utf-8") == results_fleets.page(NOTED), RENEW


def test_every_case_is_noted_and_all_targets_are_reached() -> None:
    assert list(BY_JOB) == results_fleets.jobs(), RENEW
    assert [outcome.failure for outcome in NOTED if outcome.failure] == []
    rows = results_fleets.rows(NOTED)
    assert [(row.case.about, row.bound.key) for row in rows if not row.reached] == []


@pytest.mark.parametrize(
    "job",
    [
        pytest.param(
            job,
            marks=pytest.mark.nightly if case.about in NIGHTLY or k else (),
            id=f"{case.about}, {job.seed}",
        )
        for case in results_fleets.CASES
        for k, job in enumerate(case.jobs[:2])
    ],
)
def test_run_has_the_figures_that_are_noted(job: Job) -> None:
    (run,) = all_sailed(sail([sailing.scenario_of(job)], {}))
    outcome, noted = sailing.outcome(job, run), BY_JOB[job]
    assert outcome.figures.keys() == noted.figures.keys() != set(), RENEW
    pairs = [(key, figure, noted.figures[key]) for key, figure in outcome.figures.items()]
    boats = zip(outcome.boats, noted.boats, strict=True)
    pairs += [
        (f"boat {n}", now["rms_error_m"], was["rms_error_m"])
        for n, (now, was) in enumerate(boats, 1)
    ]
    for what, now, was in pairs:
        alike = now == was or math.isclose(now, was, rel_tol=SHARE, abs_tol=LEAST)
        assert alike, f"{job}: {what} is {now:.6g} now, {was:.6g} is noted; {RENEW}"
