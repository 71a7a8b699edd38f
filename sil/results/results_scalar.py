# SPDX-License-Identifier: MIT
"""Compares the figures of the law's table in another scalar type with those in float."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rich import box
from rich.table import Table

from sil.results.claims import CLAIMS, LAWS, Bound
from sil.results.results_table import percentile
from sil.results.sailing import Outcome
from sil.scenario.sections import Scalar

SHARE = 0.10
# Six LSB of q16: smaller distances from the slot count as zero.
FLOOR_M = 0.0001
_NUMBERS = (3, 4, 5)


@dataclass(frozen=True)
class Pair:
    """A figure of a scenario and law in float and in another scalar.

    Infinite: never reached; None: the run failed.
    """

    scenario: str
    law: str
    bound: Bound
    in_float: float | None
    other: float | None

    @property
    def alike(self) -> bool:
        """Whether the two are within 10 % of each other, or a distance within 0.1 mm."""
        if self.in_float is None or self.other is None:
            return False
        floor = FLOOR_M if self.bound.unit == "m" else 0.0
        return self.in_float == self.other or math.isclose(
            self.other, self.in_float, rel_tol=0.0, abs_tol=max(SHARE * self.in_float, floor)
        )

    @property
    def cells(self) -> list[str]:
        """The cells of its row in the table."""
        ratio = self.other / self.in_float if self.in_float and self.other else math.nan
        return [
            self.scenario,
            self.law,
            self.bound.key,
            _told(self.in_float),
            _told(self.other),
            f"{ratio:.3f}" if math.isfinite(ratio) else "–",
            "yes" if self.alike else "NO",
        ]


def pairs(in_float: Sequence[Outcome], other: Sequence[Outcome]) -> list[Pair]:
    """Pair the figures of the same jobs, in the order of the law's table."""

    def runs(outcomes: Sequence[Outcome], name: str, law: str) -> list[Outcome]:
        return [o for o in outcomes if (o.job.scenario, o.job.law) == (name, law)]

    return [
        Pair(
            name,
            law,
            bound,
            percentile(runs(in_float, name, law), bound, law),
            percentile(runs(other, name, law), bound, law),
        )
        for name in dict.fromkeys(outcome.job.scenario for outcome in in_float)
        for bound in CLAIMS[name].bounds
        for law in LAWS
        if law in bound.laws
    ]


def for_terminal(scalar: Scalar, found: Sequence[Pair]) -> Table:
    """The table for the terminal; differences are red."""
    caption = f"yes: within {SHARE * 100:g} %, or {FLOOR_M * 1000:g} mm"
    grid = Table(
        box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, collapse_padding=True, caption=caption
    )
    for place, head in enumerate(("scenario", "law", "figure", "float", scalar, "ratio", "")):
        grid.add_column(head, justify="right" if place in _NUMBERS else "left", no_wrap=True)
    for pair in found:
        grid.add_row(*pair.cells, style=None if pair.alike else "bold red")
    return grid


def _told(figure: float | None) -> str:
    if figure is None:
        return "failed"
    return f"{figure:.3g}" if math.isfinite(figure) else "never"
