# SPDX-License-Identifier: MIT
"""The comparison of fixed-point functions, with few arguments."""

import math
import shutil
import subprocess
from pathlib import Path

import pytest

from sil import ROOT
from sil.examine import fixed_comparison
from sil.examine.fixed_comparison import MeasuredFunction
from tests import measurements
from tests.turns import some

NEEDED = [
    *map(shutil.which, ("qemu-system-arm", "arm-none-eabi-g++")),
    Path("/usr/include/libfixmath/fix16.h").exists(),
]

PROGRAMS = [
    ("release", "fixed_compared"),
    ("cortex-m", "fixed_instructions_soft", "fixed_instructions_hard"),
]

pytestmark = [
    pytest.mark.nightly,
    pytest.mark.skipif(not all(NEEDED), reason="no rivals here: tools/fixed --compare"),
]

ON_THE_PAGE = {
    "sin within ±π": "sin",
    "sin within ±32768": "sin_far",
    "atan2": "atan2",
    "tanh": "tanh",
    "exp up to 32767": "exp",
    "sqrt": "sqrt",
    "hypot": "hypot",
    "multiply": "multiply",
    "divide": "divide",
}


def run(*command: str) -> None:
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)


@pytest.fixture(scope="module")
def built() -> None:
    for preset, *targets in PROGRAMS:
        run("tools/build", preset, *targets)


@pytest.fixture(scope="module")
def rows(built: None) -> dict[str, MeasuredFunction]:
    return {row.name: row for row in fixed_comparison.measure(100_000)}


def test_our_functions_are_within_one_lsb_and_libfixmaths_trigonometry_is_not(
    rows: dict[str, MeasuredFunction],
) -> None:
    assert all(0.4 < row.error < 1 and row.arguments > 20_000 for row in some(rows.values()))
    for name, lsb in {"sin": 100, "sin_far": 1000, "cos": 100, "atan2": 500, "exp": 10_000}.items():
        assert rows[name].error_libfixmath > lsb
    for name in ("multiply", "divide", "sqrt"):
        assert 0.4 < rows[name].error_libfixmath < 1
    assert [name for name, row in rows.items() if math.isnan(row.error_libfixmath)] == [
        "tanh",
        "hypot",
    ]


def test_a_float_has_fewer_places_where_numbers_are_great(
    rows: dict[str, MeasuredFunction],
) -> None:
    assert rows["sin"].error_float < 0.1 < rows["sin"].error
    assert rows["hypot"].error_float > 64 < rows["exp"].error_float


def test_without_a_floating_point_unit_every_function_costs_a_fraction_of_newlibs(
    rows: dict[str, MeasuredFunction],
) -> None:
    for row in some(rows.values()):
        factor = 2 if row.name in ("multiply", "divide", "sqrt") else 8
        assert 0 < factor * row.instructions < row.instructions_soft
        assert row.instructions_fpu < row.instructions_soft


def test_the_tables_have_a_line_for_each_function(rows: dict[str, MeasuredFunction]) -> None:
    for table in some(fixed_comparison.tables(list(rows.values()))):
        assert table.row_count == len(rows) == 10
        assert len(table.columns) == 5


def test_errors_and_instructions_are_those_of_the_page(built: None) -> None:
    whole = {row.name: row for row in fixed_comparison.measure(fixed_comparison.ARGUMENTS)}
    for title, name in ON_THE_PAGE.items():
        now = whole[name]
        figures = [now.error, now.error_libfixmath, now.error_float]
        figures += [now.instructions, now.instructions_soft, now.instructions_fpu]
        cells = measurements.row(title)
        noted = [*cells[:3], *cells[6:]]
        printed = [measurements.printed(*each) for each in zip(figures, noted, strict=True)]
        assert printed == noted, f"{title}, in sil/docs/MEASUREMENTS.md: tools/fixed --compare"
