# SPDX-License-Identifier: MIT
"""Compares every published figure and picture with runs sailed here.

Each push sails the law's table, `mismatch` with the seeds that its figures are those of, and some
runs of the Monte Carlo, without the paper's law in long lines; --all sails every seed and run, and
draws the pictures.
"""

import argparse
import io
import math
from functools import cache

import numpy as np
import pytest
from PIL import Image

from sil.campaign.finished import Campaign
from sil.campaign.run_outcome import result_of
from sil.campaign.sampling import Sampler
from sil.cli import results_command
from sil.lockstep.world import all_sailed, sail
from sil.results import (
    published,
    results,
    results_campaigns,
    results_fleets,
    results_readme,
    sailing,
)
from sil.results.claims import CLAIMS
from sil.results.results_table import decisive
from sil.results.sailing import Job, Outcome
from sil.scenario import scenario

# Figures are stored with 6 digits and printed with 2 or 3.
SHARE, LEAST = 1e-3, 1e-6
# A pixel differs from 32 of 255 on: the 256 colours of a picture are chosen by all of it.
PIXEL, PIXELS = 32, 1e-4
FEW_RUNS = 5
# Lines that amplify errors until boats lose their leaders; a boat whose slot is refused.
LOST = {(name, "paper") for name in ("line10", "line20", "line20_relay")}
LOST |= {("diamond_frame1", "product")}
# Long lines behind the paper's law, and two runs that the test of the fleets' table sails too.
NIGHTLY = {Job(name, "paper") for name in ("line10", "line20", "line20_relay", "star20")}
NIGHTLY |= {Job(name, "product") for name in ("line20", "line20_relay")}
# Bounds that the pages say are missed.
MISSED = [
    ("mismatch", "rms_error_m"),
    ("turning", "overshoot_m"),
]
RENEW = "renew what is published, and look at it: flotilla results"

NOTED = published.noted()
BY_JOB = {outcome.job: outcome for outcome in NOTED.outcomes}
CAMPAIGNS = {campaign.scenario: campaign for campaign in NOTED.campaigns}


def published_jobs() -> set[Job]:
    """The runs whose figures are in the tables; with many seeds, the 95th percentile's."""
    found = set()
    for row in NOTED.table:
        for law in row.bound.laws:
            runs = [o for o in NOTED.outcomes if o.job[:2] == (row.scenario, law)]
            if runs and not any(run.failure for run in runs):
                found.add(decisive(runs, row.bound).job)
    return found


def jobs() -> list[object]:
    quick = published_jobs() - NIGHTLY
    return [
        pytest.param(job, marks=() if job in quick else pytest.mark.nightly, id=str(job))
        for job in BY_JOB
    ]


@cache
def sailed(job: Job) -> Outcome:
    # without a recording, which takes a quarter of the time and no figure depends on
    (run,) = all_sailed(sail([sailing.scenario_of(job)], {}))
    return sailing.outcome(job, run)


def check(what: str, now: float, noted: float) -> None:
    alike = now == noted or math.isclose(now, noted, rel_tol=SHARE, abs_tol=LEAST)
    assert alike, f"{what} is {now:.6g} now, {noted:.6g} in {published.FIGURES.name}; {RENEW}"


def test_pages_have_the_figures_that_are_noted() -> None:
    for path, text in published.pages(NOTED).items():
        lines, wanted = path.read_text(encoding="utf-8").splitlines(), text.splitlines()
        wrong = [line for line in lines if line not in wanted]
        missing = [line for line in wanted if line not in lines]
        assert lines == wanted, f"{path.name} has {wrong}, not {missing}; {RENEW}"


def test_every_run_of_the_pages_is_stored_and_only_the_listed_bounds_are_missed() -> None:
    parser = argparse.ArgumentParser()
    results_command.add_to(parser)
    assert list(BY_JOB) == results.jobs(parser.parse_args([])), RENEW
    assert [str(o.job) for o in NOTED.outcomes if o.failure] == []
    assert [(row.scenario, row.bound.key) for row in NOTED.table if not row.reached] == MISSED
    assert list(CAMPAIGNS) == list(results_campaigns.NAMES.values()), RENEW
    for campaign in NOTED.campaigns:
        runs = {"ok": results_campaigns.RUNS}
        assert campaign.ended == {"ok": len(campaign.runs_m)} == runs, RENEW
    wanted = results_readme.WANTED
    assert not {n for n, most in wanted.items() if NOTED.measured[n] > most}


def test_runs_that_are_in_the_fleets_table_too_have_the_same_figures_there() -> None:
    """So a push, which sails them once for that table, holds this one."""
    there = {outcome.job: outcome.figures for outcome in results_fleets.noted()}
    both = BY_JOB.keys() & there.keys()
    assert {job for job in NIGHTLY if job.law == "product"} <= both
    assert all(BY_JOB[job].figures == there[job] for job in both), RENEW


@pytest.mark.parametrize("job", jobs())
def test_run_has_the_figures_that_are_noted(job: Job) -> None:
    outcome, noted = sailed(job), BY_JOB[job]
    assert not outcome.failure
    assert outcome.boats and outcome.figures.keys() == noted.figures.keys() != set(), RENEW
    for key, figure in outcome.figures.items():
        check(f"{job}: {key}", figure, noted.figures[key])
    states = {state for boat in outcome.boats for state in boat["states"]}
    assert (states == {"FORMATION"}) == (job[:2] not in LOST)


@pytest.mark.nightly  # each push: their limits, in test_leader_sources.py and test_radio_share.py
def test_page_has_the_distances_behind_other_leaders_and_the_shares_of_the_radio() -> None:
    measured = results_readme.sail()
    assert measured.keys() == NOTED.measured.keys(), RENEW
    for name, figure in measured.items():
        check(name, figure, NOTED.measured[name])


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_first_runs_of_the_monte_carlo_have_the_percentiles_that_are_noted(name: str) -> None:
    sampler = Sampler(scenario.read(name))
    scenarios = [sampler.scenario(run) for run in range(FEW_RUNS)]
    together = zip(range(FEW_RUNS), scenarios, sail(scenarios, {}), strict=True)
    for run, result in enumerate(result_of(*each) for each in together):
        check_run(name, run, [[b["error_p50_m"], b["error_p95_m"]] for b in result.boats])


def check_run(name: str, run: int, boats: object) -> None:
    now, noted = np.array(boats, float), np.array(CAMPAIGNS[name].runs_m[run])
    assert now.shape == noted.shape, RENEW
    for place in np.ndindex(now.shape):
        boat, percent = place[0] + 1, (50, 95)[place[1]]
        check(
            f"{name}, run {run}, boat {boat}: {percent} %", float(now[place]), float(noted[place])
        )


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Campaign]:
    found = results_campaigns.sail(tmp_path_factory.mktemp("campaigns"), workers=2)
    return {campaign.scenario: campaign for campaign in found}


@pytest.mark.nightly
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_monte_carlo_has_the_percentiles_that_are_noted(
    campaigns: dict[str, Campaign], name: str
) -> None:
    now, noted = results_campaigns.told(campaigns[name]), CAMPAIGNS[name]
    assert now.ended == noted.ended, RENEW
    for run, boats in enumerate(now.runs_m):
        check_run(name, run, boats)
    for boat, (percentiles, wanted) in enumerate(zip(now.late_m, noted.late_m, strict=True), 1):
        for percent, figure, expected in zip((50, 95), percentiles, wanted, strict=True):
            check(f"{name}, boat {boat}, all runs: {percent} %", figure, expected)


def check_picture(name: str, now: bytes) -> None:
    path = published.PICTURES / f"{name}.png"
    with Image.open(path) as old, Image.open(io.BytesIO(now)) as new:
        assert old.size == new.size, f"{path.name}: another size; {RENEW}"
        was, drawn = (np.asarray(image.convert("RGB"), dtype=int) for image in (old, new))
    share = np.mean(np.abs(was - drawn).max(axis=2) > PIXEL)
    assert share <= PIXELS, f"{path.name}: {100 * share:.2g} % of its pixels differ now; {RENEW}"


@pytest.mark.nightly
@pytest.mark.parametrize("name", CLAIMS)
def test_picture_of_a_scenario_matches_the_run(name: str) -> None:
    picture = results.picture(name, [sailed(job) for job in BY_JOB if job.scenario == name])
    assert picture is not None
    check_picture(name, picture)


@pytest.mark.nightly
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_picture_of_the_monte_carlo_matches_the_runs(
    campaigns: dict[str, Campaign], name: str
) -> None:
    check_picture(name, results_campaigns.picture(campaigns[name]))
