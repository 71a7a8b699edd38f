# SPDX-License-Identifier: MIT
"""The table of results, from made-up outcomes."""

import io
import math
from collections.abc import Sequence

import pytest
from rich.console import Console

from sil.results import SEEDS, published, results_table
from sil.results.claims import CLAIMS, LAWS
from sil.results.results_table import BEGIN, COLUMNS, END, PublishedBound
from sil.results.sailing import Job, Outcome


def outcomes(
    name: str, paper: Sequence[float | None], product: Sequence[float | None]
) -> list[Outcome]:
    """One run per given figure, with all its figures equal; None is a failed run."""
    keys = [bound.key for bound in CLAIMS[name].bounds]
    return [
        Outcome(Job(name, law, seed), failure="" if figure is not None else "rammed a pier")
        if figure is None
        else Outcome(Job(name, law, seed), figures=dict.fromkeys(keys, figure))
        for law, figures in zip(LAWS, (paper, product), strict=True)
        for seed, figure in enumerate(figures, start=1)
    ]


def reached(name: str, paper: float | None, product: float | None) -> list[bool]:
    return [row.reached for row in results_table.rows(outcomes(name, [paper], [product]))]


@pytest.mark.parametrize(
    ("name", "paper", "product", "expected"),
    [
        # distance 2 mm; settled 1.5 × sooner; the paper's law within 0.03 m of the reference
        ("diamond", 0.015, 0.002, [True, True, True]),
        ("diamond", 0.00149, 0.001, [True, False, True]),
        ("diamond", 0.031, 0.0021, [False, True, False]),
        ("diamond", math.inf, 0.001, [True, True, False]),
        ("diamond", math.inf, math.inf, [False, False, False]),
        ("diamond", math.nan, math.nan, [False, False, False]),
        ("diamond", None, 0.01, [False, False, False]),
        ("diamond", 0.02, None, [False, False, True]),
        ("straight", 9.0, 0.0025, [True]),
        ("straight", 9.0, 0.0026, [False]),
        ("noisy", 0.0, 0.03, [True, True]),
        ("noisy", 0.0, 0.19, [False, True]),
        ("noisy", 0.0, 0.21, [False, False]),
        ("mismatch", 0.08, 0.06, [True, True]),
        ("mismatch", 0.08, 0.061, [True, False]),
        ("stop_and_go", 0.0, 0.09, [False, True, True]),
        ("stop_and_go", 0.0, 0.12, [False, False, True]),
        ("stop_and_go", 0.0, 0.2, [False, False, False]),
    ],
)
def test_bound_is_reached_or_missed(
    name: str, paper: float | None, product: float | None, expected: list[bool]
) -> None:
    assert reached(name, paper, product) == expected


def test_figure_of_many_seeds_is_their_95th_percentile_rounded_up_to_a_run() -> None:
    seeds = [float(seed) for seed in range(40)]
    worst = [math.nan, math.inf, *seeds[2:]]
    distance, _ = results_table.rows(outcomes("mismatch", seeds[::-1], worst))
    assert (distance.baseline, distance.product, distance.seeds) == (38.0, math.inf, 40)


def test_one_failed_seed_fails_the_scenario() -> None:
    distance, _ = results_table.rows(outcomes("mismatch", [0.2, 0.2], [0.01, None]))
    assert distance.product is None and not distance.reached
    assert distance.cells[3:] == ["failed", "0.1 m", "NO"]


@pytest.mark.parametrize(
    ("figure", "told"),
    [
        (0.0, "< 0.0001 m"),
        (0.000512, "0.00051 m"),
        (0.0426, "0.043 m"),
        (0.5, "0.500 m"),
        (10.64, "10.6 m"),
        (351.9, "352 m"),
        (math.inf, "never"),
        (None, "failed"),
    ],
)
def test_figure_is_printed_with_its_significant_digits(figure: float | None, told: str) -> None:
    (row,) = results_table.rows(outcomes("straight", [figure], [0.02]))
    assert row.cells[2] == told


def made_up_table() -> list[PublishedBound]:
    return results_table.rows(outcomes("diamond", [0.03], [0.02]) + outcomes("sea", [3], [0.1]))


def page_of(text: str, rows: Sequence[PublishedBound]) -> str:
    return results_table.between(text, BEGIN, results_table.for_page(rows))


def test_page_has_a_line_for_each_bound_and_a_picture_for_each_scenario_between_its_marks() -> None:
    page = page_of(f"before\n{BEGIN}old\n{END}\nafter\n", made_up_table())
    before, _, rest = page.partition(BEGIN)
    table, _, after = rest.partition(END)
    assert (before, after) == ("before\n", "\nafter\n")
    lines = table.splitlines()
    assert lines[2] == (
        "| [`diamond`](../scenarios/diamond.toml) | the paper's section III, nothing disturbs "
        "| 0.030 m | 0.020 m | 0.002 m | **NO** |"
    )
    assert lines[3].endswith("| 0.030 s | 0.020 s | 1.5 × sooner | yes |")
    assert lines[4].endswith("| 0.030 m | – | 0.03 m | yes |")
    pictures = [line.partition("](")[2] for line in lines if line.startswith("![")]
    assert pictures == ["../results/diamond.png)", "../results/sea.png)"]


def test_the_roots_figure_is_printed_beside_the_boats_and_has_no_bound() -> None:
    rows = results_table.rows(outcomes("line20", [9.0], [0.3]))
    (root,) = (row for row in rows if row.bound.key == "roots_yaw_rate_radps")
    assert root.cells[1:] == ["the root's", "9.00 rad/s", "0.300 rad/s", "–", ""]
    assert root.reached


def test_page_written_twice_is_the_page_written_once() -> None:
    once = page_of(f"{BEGIN}{END}", made_up_table())
    assert page_of(once, made_up_table()) == once


@pytest.mark.parametrize("text", ["", BEGIN, END, END + BEGIN, 2 * (BEGIN + END)])
def test_page_that_lost_its_marks_is_an_error(text: str) -> None:
    with pytest.raises(ValueError, match="no place for the results"):
        page_of(text, made_up_table())


def test_projects_page_has_the_marks_and_every_bound_in_order() -> None:
    text = published.PAGE.read_text(encoding="utf-8")
    rows = [
        PublishedBound(name, b, 0.0, 0.0, SEEDS) for name in CLAIMS for b in CLAIMS[name].bounds
    ]
    _, _, rest = page_of(text, rows).partition(BEGIN)
    assert wanted(text.partition(BEGIN)[2]) == wanted(rest), "run flotilla results"


def wanted(page: str) -> list[list[str]]:
    """Lines of the table without the figures."""
    lines = [line.split(" | ") for line in page.partition(END)[0].splitlines()]
    return [[*cells[:2], cells[4]] for cells in lines if len(cells) == len(COLUMNS)]


def test_terminal_shows_every_bound_and_marks_the_missed_one() -> None:
    console = Console(width=100, file=io.StringIO(), record=True)
    console.print(results_table.for_terminal(made_up_table()))
    text = console.export_text()
    assert "diamond" in text and "sea" in text and "1.5 × sooner" in text
    assert text.count("NO") == 1 and text.count("yes") == 3
