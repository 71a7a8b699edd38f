# SPDX-License-Identifier: MIT
"""The law's table in another scalar beside float, from made-up outcomes."""

import io
import math
from collections.abc import Sequence

import pytest
from rich.console import Console

from sil.results import results_scalar
from sil.results.claims import CLAIMS, LAWS
from sil.results.results_scalar import Pair
from sil.results.sailing import Job, Outcome
from tests.turns import some


def outcomes(name: str, figures: Sequence[float | None]) -> list[Outcome]:
    """Runs of both laws, one seed per figure; None is a failed run."""
    keys = [bound.key for bound in CLAIMS[name].bounds]
    return [
        Outcome(Job(name, law, seed), failure="rammed a pier")
        if figure is None
        else Outcome(Job(name, law, seed), figures=dict.fromkeys(keys, figure))
        for law in LAWS
        for seed, figure in enumerate(figures, start=1)
    ]


def pairs(name: str, in_float: float | None, other: float | None) -> list[Pair]:
    return results_scalar.pairs(outcomes(name, [in_float]), outcomes(name, [other]))


@pytest.mark.parametrize(
    ("in_float", "other", "alike"),
    [
        (1.0, 1.0999, True),
        (1.0, 0.9001, True),
        (1.0, 1.1001, False),
        (1.0, 0.8999, False),
        (0.00005, 0.00014, True),  # both are in their slots
        (0.00005, 0.00016, False),
        (math.inf, math.inf, True),
        (math.inf, 1.0, False),
        (1.0, math.inf, False),
        (1.0, math.nan, False),
        (None, 1.0, False),
        (1.0, None, False),
    ],
)
def test_distance_is_alike_within_10_percent_or_a_tenth_of_a_millimetre(
    in_float: float | None, other: float | None, alike: bool
) -> None:
    assert [pair.alike for pair in pairs("straight", in_float, other)] == [alike, alike]


def test_no_other_figure_has_a_least_difference() -> None:
    found = pairs("stop_and_go", 0.00005, 0.00014)
    assert {(pair.bound.unit, pair.alike) for pair in found} == {("m", True), ("turn", False)}


def test_every_bound_is_compared_for_the_laws_that_have_it() -> None:
    found = [(pair.bound.key, pair.law) for pair in pairs("diamond", 1.0, 1.0)]
    assert found == [
        ("rms_error_m", "paper"),
        ("rms_error_m", "product"),
        ("settling_s", "paper"),
        ("settling_s", "product"),
        ("deviation_from_reference", "paper"),
    ]


def test_figure_of_many_seeds_is_the_one_that_the_table_of_results_has() -> None:
    seeds = [float(seed) for seed in range(40)]
    every, two = outcomes("mismatch", seeds), outcomes("mismatch", seeds[:2])
    for pair in some(results_scalar.pairs(every, two)):
        assert (pair.in_float, pair.other) == (38.0, 1.0)


def test_terminal_of_80_columns_shows_every_figure_whole() -> None:
    console = Console(width=80, file=io.StringIO(), record=True)
    found = [pair for name in CLAIMS for pair in pairs(name, 0.000123, 0.000456)]
    console.print(results_scalar.for_terminal("q16", found))
    text = console.export_text()
    assert "…" not in text and "deviation_from_reference" in text
    assert text.count("0.000123") == text.count(" 3.707 ") == text.count(" NO") == len(found)
