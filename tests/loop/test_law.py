# SPDX-License-Identifier: MIT
"""The law's table, sailed with the product's law: the short form of python -m sil results."""

import math
from pathlib import Path

import numpy as np
import pytest

from sil import figures, metrics
from sil.claims import BASELINE, CLAIMS, PRODUCT, Claim
from sil.sailing import Job, Outcome, sail
from sil.world import Run
from tests.loop.conftest import Sail

SINGLE = [name for name, claim in CLAIMS.items() if not claim.many_seeds]


def sailed(job: Job, folder: Path) -> Outcome:
    outcome = sail(job, folder)
    assert not outcome.failure
    for boat in outcome.boats:
        assert set(boat["states"]) == {"FORMATION"}, (job, boat)
    return outcome


def check(claim: Claim, baseline: dict[str, float], product: dict[str, float]) -> None:
    for bound in claim.bounds:
        # Those that name no baseline are judged by the product's figure alone.
        both = baseline.get(bound.key, math.nan), product.get(bound.key, math.nan)
        assert bound.reached(*both), (bound.what, both, bound.to_reach)


@pytest.mark.parametrize("name", [name for name in SINGLE if name != "diamond"])
def test_in_every_water_the_boats_keep_their_slots(name: str, tmp_path: Path) -> None:
    check(CLAIMS[name], {}, sailed(Job(name, PRODUCT), tmp_path).figures)


def test_the_products_law_closes_up_half_as_long_again_before_the_papers(
    diamond: tuple[Run, Path], tmp_path: Path
) -> None:
    trace = diamond[0].trace
    claim = CLAIMS["diamond"]
    baseline = {bound.key: bound.figure(trace) for bound in claim.bounds}
    check(claim, baseline, sailed(Job("diamond", PRODUCT), tmp_path).figures)


def test_boats_that_are_not_what_their_firmware_believes_keep_their_slots_with_less_effort(
    tmp_path: Path,
) -> None:
    for seed in (1, 2):
        runs = {
            law: sailed(Job("mismatch", law, seed, ("duration_s=150",)), tmp_path).figures
            for law in (BASELINE, PRODUCT)
        }
        check(CLAIMS["mismatch"], runs[BASELINE], runs[PRODUCT])
        assert runs[BASELINE]["rms_error_m"] > 2.0 * runs[PRODUCT]["rms_error_m"]


@pytest.mark.parametrize(("name", "least_m"), [("straight", 0.5), ("current", 0.5), ("sea", 1.0)])
def test_where_nothing_turns_or_the_water_moves_the_papers_law_does_not(
    name: str, least_m: float, tmp_path: Path
) -> None:
    job = Job(name, BASELINE, overrides=("duration_s=150",))
    assert sailed(job, tmp_path).figures["rms_error_m"] > least_m


@pytest.mark.parametrize("wind_mps", [12.0, 15.0])
def test_before_a_strong_wind_slow_boats_come_to_their_track(sail: Sail, wind_mps: float) -> None:
    run = sail("tail_wind", "duration_s=150", f"wind.mean_mps=[{wind_mps}, 0.0]")
    assert figures.rms_error_m(run.trace) < 0.05


def test_boats_abeam_of_a_resting_leader_form_up_and_lie_still(sail: Sail) -> None:
    trace = sail("resting_leader", "duration_s=150").trace
    late = trace["t_s"] >= 60.0
    assert (metrics.distances(trace["error"])[0] >= 10.0).all()
    assert metrics.distances(trace["error"])[late].max() < 0.4
    # the leader's heading, and nobody hunts
    assert np.abs(trace["error"][late, :, 2]).max() < 0.05
    assert np.ptp(np.unwrap(trace["eta"][..., 2], axis=0), axis=0).max() < 2.0 * np.pi


@pytest.mark.parametrize("current_mps", [[0.0, 0.1], [0.1, 0.0], [-0.1, -0.1]])
def test_beside_a_resting_leader_a_current_is_not_chased_in_circles(
    sail: Sail, current_mps: list[float]
) -> None:
    trace = sail("resting_leader", "duration_s=200", f"water.current_mps={current_mps}").trace
    assert figures.rms_error_m(trace) < 0.2
    late = trace["t_s"] >= 120.0
    assert np.ptp(np.unwrap(trace["eta"][late, 1:, 2], axis=0), axis=0).max() < 0.5


def test_when_the_leader_stops_boats_in_formation_stay_as_they_are(sail: Sail) -> None:
    trace = sail("stop_and_go", "duration_s=90").trace
    assert figures.turns_at_a_stop(trace) < 0.1
    assert figures.overshoot_m(trace) < 0.012
