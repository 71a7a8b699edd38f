# SPDX-License-Identifier: MIT
"""The law's table, sailed with the product's law: the short form of python -m sil results."""

import math
from pathlib import Path

import pytest

from sil.claims import BASELINE, CLAIMS, PRODUCT, Claim
from sil.sailing import Job, Outcome, sail
from sil.world import Run
from tests.turns import some

SINGLE = [name for name, claim in CLAIMS.items() if not claim.many_seeds]


def sailed(job: Job, folder: Path) -> Outcome:
    outcome = sail(job, folder)
    assert not outcome.failure
    for boat in some(outcome.boats):
        assert set(boat["states"]) == {"FORMATION"}, (job, boat)
    return outcome


def check(claim: Claim, baseline: dict[str, float], product: dict[str, float]) -> None:
    for bound in some(claim.bounds):
        # Those that name no baseline are judged by the product's figure alone.
        figures = baseline.get(bound.key, math.nan), product.get(bound.key, math.nan)
        assert bound.reached(*figures), (bound.what, figures, bound.to_reach)


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
